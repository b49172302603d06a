/* M. Singh, S. Bedi, S. Mann, "A GPU Method and Error Analysis of Multi-Point Positioning of a
 * Toroidal Tool for 5-Axis Machining", 2024: table 1, figures 6, 8 and 9. */
#include "app/papers.h"
#include "app/plan.h"
#include "app/app.h"
#include "core/part.h"
#include "methods/error_model.h"

#include <stdlib.h>
#include <string.h>

/* ---- table 1 ------------------------------------------------------------------------------ */

static const char table_1[] = "GPU table 1: time of 760 positions, concave";
#define CONCAVE    1
#define QUICK_FEET 4

/* `feet`: so many of the positions are timed. */
static const struct {
    const char *quantity, *backend;
    uint32_t window;
    int levels;
    size_t feet;
    double paper;
} columns[] = {
    {"GPU, one level, 650 x 650", "osmesa", 650, 1, 8, 616},
    {"GPU, two levels, 50 x 50", "osmesa", 50, 2, 95, 8.5},
    {"CPU, one level, 650 x 650", "cpu", 650, 1, 2, 304},
    {"CPU, two levels, 50 x 50", "cpu", 50, 2, 24, 14},
};

static size_t feet_of(const papers *p, size_t k) {
    return p->quick ? QUICK_FEET : columns[k].feet;
}

static btg_status time_column(papers *p, size_t k) {
    size_t feet = feet_of(p, k);
    double seconds = 0, *xy = malloc(2 * feet * sizeof *xy);
    btg_position *out = malloc(feet * sizeof *out);
    btg_method_def def = papers_method("depth");
    btg_part_info info;
    btg_status status = BTG_ERROR_MEMORY;
    papers_show(p, columns[k].quantity);
    btg_part_get_info(p->part[CONCAVE], &info);
    def.backend.name = columns[k].backend;
    def.backend.raw = columns[k].backend[0] == 'o';
    def.window = columns[k].window;
    def.levels = columns[k].levels;
    for (size_t i = 0; i < feet && xy; i++)
        bench_spread(&info, i, xy + 2 * i);
    if (xy && out)
        status = papers_solve(p, CONCAVE, &def, &p->solver, xy, feet, out, &seconds, NULL);
    if (status == BTG_OK) {
        double all = seconds * 760 / (double)feet;
        papers_name(papers_add(p, table_1, "s", all, columns[k].paper), "concave", "%s",
                    columns[k].quantity);
    }
    free(xy);
    free(out);
    return status;
}

/* On how many positions a pair of columns, one level and two, is timed. */
static const char *timed_on(const papers *p, size_t k, char text[64]) {
    if (p->quick)
        snprintf(text, 64, "%zu positions, two levels alone", feet_of(p, k + 1));
    else
        snprintf(text, 64, "%zu and %zu positions", feet_of(p, k), feet_of(p, k + 1));
    return text;
}

static btg_status level_times(papers *p) {
    char text[64];
    btg_status status = BTG_OK;
    bool osmesa = plan_raster_ready();
    for (size_t k = 0; k < sizeof columns / sizeof *columns && status == BTG_OK; k++) {
        if (!osmesa && columns[k].backend[0] == 'o') continue;
        if (p->quick && columns[k].levels == 1) continue;
        status = time_column(p, k);
    }
    if (!osmesa)
        papers_note_add(p, table_1,
                        "The GPU's columns are left out: the back end osmesa, which has the "
                        "rasteriser, is not built or not ready here (bitangent info).");
    else
        papers_note_add(
            p, table_1,
            "GPU: osmesa's answers as they are (--raw), llvmpipe, a rasteriser on this "
            "processor; the tool's image is analytic and drops of a batch share one "
            "picture, so read-back, the paper's cost, is nothing; drawing is all. Timed "
            "on %s.",
            timed_on(p, 0, text));
    papers_note_add(
        p, table_1,
        "CPU: one thread, a ray a pixel to the exact surface by Newton's method, 28 drops a "
        "position; timed on %s. The paper's gain of two levels is in pixels: 2 x 50^2 for 650^2, "
        "85 times fewer.",
        timed_on(p, 2, text));
    return status;
}

/* ---- figure 6 ----------------------------------------------------------------------------- */

static const char figure_6[] = "GPU figure 6: error of pixels along the insert";
#define CURVE            200
#define PLACES           12
#define DIRECTIONS       24
#define QUICK_DIRECTIONS 6
#define WINDOWS          3
static const uint32_t window[WINDOWS] = {50, 125, 254}; /* 0.508, 0.203 and 0.1 mm */

static int directions(const papers *p) {
    return p->quick ? QUICK_DIRECTIONS : DIRECTIONS;
}

/* A plane through the origin that rises by `slope` along a direction. */
static btg_part *plane(double slope, double direction) {
    const double side = 60, rise = tan(slope);
    double net[12];
    for (int k = 0; k < 4; k++) {
        double x = k / 2 ? side : -side, y = k % 2 ? side : -side;
        net[3 * k] = x;
        net[3 * k + 1] = y;
        net[3 * k + 2] = rise * (x * cos(direction) + y * sin(direction));
    }
    btg_surface_def surface = {1, 1, 2, 2, net, NULL, NULL, NULL};
    btg_part_def def = btg_part_def_default();
    btg_part *part = NULL;
    def.surfaces = &surface;
    def.surface_count = 1;
    return btg_part_create(&def, &part, NULL) == BTG_OK ? part : NULL;
}

/* How far a drop by pixels leaves the tool inside a plane. */
static btg_status measure_once(papers *p, double slope, double direction, uint32_t pixels,
                               double *deep) {
    btg_part *part = plane(slope, direction);
    btg_method_def def = papers_method("depth");
    btg_method *m = NULL;
    btg_status status = BTG_ERROR_MEMORY;
    def.backend.name = "cpu";
    def.window = pixels;
    def.levels = 1;
    if (part) status = btg_method_open(&def, part, &p->tool, &p->solver, &m, &p->message);
    double ro = p->tool.def.major_radius_mm, ri = p->tool.def.minor_radius_mm;
    if (status >= 0) {
        btg_drop_query q = btg_position_drop_query(0, 0);
        btg_drop_result r = {0};
        status = btg_backend_drop(btg_method_front(m), &q, 1, &r, NULL);
        *deep = ri + ro * sin(slope) - r.height_mm * cos(slope);
    }
    btg_method_close(m);
    btg_part_destroy(part);
    return status < 0 ? status : BTG_OK;
}

/* The deepest over directions, which move the contact about among the pixels. */
static btg_status measure(papers *p, double slope, uint32_t pixels, double *worst) {
    btg_status status = BTG_OK;
    *worst = 0;
    for (int i = 0; i < directions(p) && status == BTG_OK; i++) {
        double deep = 0;
        status = measure_once(p, slope, 0.37 + 2.399963 * i, pixels, &deep);
        *worst = fmax(*worst, deep);
    }
    return status;
}

typedef struct curves {
    double x[CURVE], bound[WINDOWS][CURVE];
    double at[PLACES], measured[WINDOWS][PLACES];
} curves;

static btg_status draw_errors(papers *p, const curves *c) {
    static const char *const bound[WINDOWS] = {"bound, 0.508 mm", "bound, 0.203 mm",
                                               "bound, 0.100 mm"};
    static const char *const dots[WINDOWS] = {"measured, 0.508 mm", "measured, 0.203 mm",
                                              "measured, 0.100 mm"};
    btg_chart_panel panels[2] = {
        btg_chart_panel_of("Whole insert", "x of the contact on the insert, mm", "error, mm"),
        btg_chart_panel_of("Not at its side", "x of the contact on the insert, mm", "error, mm")};
    panels[1].x_max = 5.5;
    panels[1].y_max = 0.03;
    for (int i = 0; i < 2; i++) {
        panels[i].legend_left = true;
        panels[i].y_min = 0;
        for (int w = 0; w < WINDOWS; w++) {
            btg_chart_add(&panels[i], BTG_CHART_LINE, w, bound[w], c->x, c->bound[w], CURVE);
            btg_chart_add(&panels[i], BTG_CHART_DOTS, w, dots[w], c->at, c->measured[w], PLACES);
        }
    }
    return papers_chart(p, "gpu-figure-6", "Error of a drop by pixels, equation 2 and measured",
                        panels, 2, 2);
}

static btg_status pixel_errors(papers *p) {
    curves *c = calloc(1, sizeof *c);
    btg_status status = c ? BTG_OK : BTG_ERROR_MEMORY;
    const btg_tool_def *t = &p->tool.def;
    double ri = t->minor_radius_mm, least = INFINITY, most = 0;
    papers_show(p, "figure 6: error of pixels");
    for (int w = 0; w < WINDOWS && status == BTG_OK; w++) {
        double pitch = 2 * (t->major_radius_mm + ri) / window[w];
        for (int i = 0; i < CURVE; i++) {
            c->x[i] = ri * i / (CURVE - 1);
            c->bound[w][i] = btg_pixel_error(ri, c->x[i], pitch);
        }
        for (int i = 0; i < PLACES && status == BTG_OK; i++) {
            c->at[i] = 0.985 * ri * (i + 1) / PLACES;
            status = measure(p, asin(c->at[i] / ri), window[w], &c->measured[w][i]);
            double all = btg_pixel_bound(t->major_radius_mm, ri, c->at[i], pitch, 0);
            least = fmin(least, all / c->measured[w][i]);
            most = fmax(most, all / c->measured[w][i]);
        }
    }
    if (status == BTG_OK) {
        papers_name(papers_add(p, figure_6, "mm", btg_pixel_error(ri, ri, 0.04), 0.01),
                    "bound at the insert's side", "pixels of 0.04 mm");
        papers_name(papers_add(p, figure_6, "mm", btg_pixel_error(ri, 0.95 * ri, 0.1), 0.01),
                    "bound at 95 % of it", "pixels of 0.1 mm");
        papers_name(papers_add(p, figure_6, "mm", c->measured[2][PLACES - 1], NAN),
                    "measured at 98.5 %", "pixels of 0.1 mm");
        papers_name(papers_add(p, figure_6, "", least, NAN), "bound over measured", "least");
        papers_name(papers_add(p, figure_6, "", most, NAN), "bound over measured", "greatest");
        papers_note_add(
            p, figure_6,
            "Measured by drops on planes that touch the insert at x, in %d directions each. "
            "Equation 2 has the insert along a row of pixels, the contact at one of them, "
            "and leaves out that the tool is round across the insert too (on level ground that "
            "helps: it touches along its circle, and some pixel is near); the bound "
            "compared (and that of bitangent plan) has all of it.",
            directions(p));
        status = draw_errors(p, c);
    }
    free(c);
    return status;
}

/* ---- figures 8 and 9 ---------------------------------------------------------------------- */

static const char figure_8[] = "GPU figures 8 and 9: facets of tool and part";
#define ALLOWED_MM  0.025
#define PART_RADIUS 200.0
#define TOOL_RADIUS 12.0

static double chord(double sagitta, double radius) {
    return 2 * sqrt(2 * sagitta * radius);
}

static btg_status draw_tradeoff(papers *p, const double *share, const double *time) {
    static const double allowed[3] = {0.01, 0.025, 0.05};
    static const char *const name[3] = {"0.01 mm in all", "0.025 mm in all", "0.05 mm in all"};
    double x[3][CURVE], y[3][CURVE];
    btg_chart_panel panels[2] = {
        btg_chart_panel_of("Figure 8: time at 0.025 mm in all", "tool's share of the error",
                           "time, of the least"),
        btg_chart_panel_of("Figure 9: facets that keep an error", "facets of the tool, mm",
                           "facets of the part, mm")};
    panels[0].y_min = 0;
    panels[0].y_max = 6;
    btg_chart_add(&panels[0], BTG_CHART_LINE, 0, NULL, share, time, CURVE);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < CURVE; i++) {
            x[k][i] = chord(share[i] * allowed[k], TOOL_RADIUS);
            y[k][i] = chord((1 - share[i]) * allowed[k], PART_RADIUS);
        }
        btg_chart_add(&panels[1], BTG_CHART_LINE, k, name[k], x[k], y[k], CURVE);
    }
    return papers_chart(p, "gpu-figures-8-9", "Facets of tool and part: error and time", panels, 2,
                        2);
}

/* How the drop's time grows with the part's triangles: the paper's model has it in proportion. */
static btg_status measure_growth(papers *p) {
    static const int side[2] = {50, 200};
    double seconds[2] = {0, 0};
    btg_status status = BTG_OK;
    for (int k = 0; k < 2 && status >= 0; k++) {
        bench_subject s;
        btg_drop_result r;
        btg_solver_def solver = p->solver;
        status = bench_subject_mesh(&s, CONCAVE, side[k], &p->message);
        if (status != BTG_OK) return status;
        size_t size = btg_workspace_size(s.part), drops = 4000;
        void *workspace = malloc(size);
        btg_part_info info;
        btg_part_get_info(s.part, &info);
        double begin = app_seconds();
        for (size_t i = 0; i < drops && workspace && status >= 0; i++) {
            double xy[2];
            bench_spread(&info, i, xy);
            btg_drop_query q = btg_position_drop_query(xy[0], xy[1]);
            status = btg_drop(s.part, &p->tool, &solver, &q, workspace, size, &r);
        }
        seconds[k] = app_seconds() - begin;
        if (!workspace) status = BTG_ERROR_MEMORY;
        free(workspace);
        bench_subject_free(&s);
    }
    if (status < 0) return status;
    papers_name(papers_add(p, figure_8, "", seconds[1] / seconds[0], 16), "a drop's time",
                "16 times the triangles");
    return BTG_OK;
}

static btg_status facets(papers *p) {
    double share[CURVE], time[CURVE], low = 1, high = 0;
    for (int i = 0; i < CURVE; i++) {
        share[i] = (i + 1.0) / (CURVE + 1);
        time[i] = 1 / (4 * share[i] * (1 - share[i]));
        if (time[i] <= 1.25) low = fmin(low, share[i]), high = fmax(high, share[i]);
    }
    double ri = p->tool.def.minor_radius_mm, outer = ri + p->tool.def.major_radius_mm;
    double facet = chord(ALLOWED_MM, ri);
    papers_name(papers_add(p, figure_8, "mm", facet, 1), "facet of the insert", "0.025 mm");
    papers_name(papers_add(p, figure_8, "", ceil(2 * BTG_PI * ri / facet), 36),
                "facets around the insert", "0.025 mm");
    papers_name(papers_add(p, figure_8, "", ceil(2 * BTG_PI * outer / facet), 80),
                "facets around the tool", "0.025 mm");
    papers_name(papers_add(p, figure_8, "mm", chord(ALLOWED_MM, PART_RADIUS), 5),
                "facet of the part", "0.025 mm, radius 200 mm");
    papers_name(papers_add(p, figure_8, "%", 100 * low, NAN), "tool's share of the error",
                "time within 25 %% of the least, from");
    papers_name(papers_add(p, figure_8, "%", 100 * high, NAN), "tool's share of the error",
                "time within 25 %% of the least, to");
    papers_note_add(
        p, figure_8,
        "The paper rounds its facets down (1.1 to 1 mm, 6.3 to 5 mm). Its time goes with "
        "the product of both numbers of facets, least at equal shares and flat, as its "
        "figure 8 shows; a search tree's time hardly grows with the part's, and our tool "
        "has no facets.");
    btg_status status = measure_growth(p);
    return status == BTG_OK ? draw_tradeoff(p, share, time) : status;
}

btg_status papers_gpu(papers *p) {
    btg_status status = level_times(p);
    if (status == BTG_OK) status = pixel_errors(p);
    if (status == BTG_OK && plan_raster_ready()) status = papers_raw(p);
    return status == BTG_OK ? facets(p) : status;
}
