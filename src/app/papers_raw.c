/* What the depth images of the back end osmesa find, before the polish, against the bound of their
 * pixels: section 7 of M. Singh, S. Bedi, S. Mann, "A GPU Method and Error Analysis of Multi-Point
 * Positioning of a Toroidal Tool for 5-Axis Machining", 2024, on surfaces that are curved too, and
 * for circular rays. */
#include "app/papers.h"
#include "app/plan.h"
#include "core/part.h"

#include <stdlib.h>

static const char table[] = "GPU section 7: error of depth images by their window, as found";

/* Places, SIDE along x and y, away from rows of pixels and from the part's middle. */
#define SIDE        8
#define COUNT       (SIDE * SIDE)
#define SIZES       5
#define QUICK_SIZES 2
#define ROUNDING_MM (PLAN_ROUNDING * 150)

static const uint32_t window[2][SIZES] = {{40, 80, 160, 320, 625}, {12, 20, 30, 50, 80}};

/* DROP and TILT with the right answers. TILT starts from the right P: its own error is looked at.
 */
typedef struct study {
    btg_drop_query drops[COUNT];
    btg_drop_result dropped[COUNT];
    btg_tilt_query tilts[COUNT];
    btg_tilt_result tilted[COUNT];
    size_t tilt_count;
} study;

/* Greatest clearance or height missed, its bound there, and the greatest part of its own bound that
 * any error is. */
typedef struct errors {
    double most, bound, share;
} errors;

static btg_status open_backend(papers *p, int surface, const char *name, uint32_t levels,
                               uint32_t pixels, btg_backend **backend) {
    btg_backend_def def = btg_backend_def_default();
    def.name = name;
    def.raw = levels > 0;
    if (levels > 0) def.levels = levels;
    def.window_pixels = pixels;
    return btg_backend_open(&def, p->part[surface], &p->tool, &p->solver, backend, &p->message);
}

static btg_status begin(papers *p, int surface, study *s) {
    btg_backend *cpu = NULL;
    btg_status status = open_backend(p, surface, "cpu", 0, 0, &cpu);
    if (status != BTG_OK) return status;
    for (int i = 0; i < COUNT; i++)
        s->drops[i] = btg_position_drop_query(15.3 + 17 * (i / SIDE), 14.7 + 17.1 * (i % SIDE));
    status = btg_backend_drop(cpu, s->drops, COUNT, s->dropped, NULL);
    s->tilt_count = 0;
    for (int i = 0; i < COUNT && status >= 0; i++)
        if (btg_position_tilt_query(&p->tool, &p->solver, &s->drops[i], &s->dropped[i],
                                    &s->tilts[s->tilt_count]) == BTG_OK)
            s->tilt_count++;
    if (status >= 0) status = btg_backend_tilt(cpu, s->tilts, s->tilt_count, s->tilted, NULL);
    btg_backend_close(cpu);
    return status < 0 ? status : BTG_OK;
}

/* On the part's edge a height is a pixel times the slope off: another bound. */
static bool on_edge(btg_place a) {
    return min2(min2(a.u, a.v), min2(1 - a.u, 1 - a.v)) < 1e-3;
}

/* Clearance that a pixel may hide: half its diagonal from the contact, on a part that curves away
 * from the insert; `c` the cosine between ray and normal, `bend` the ray's own curvature. */
static double hidden(const papers *p, int surface, btg_place place, double pitch, double c,
                     double bend) {
    double curves = 1 / p->tool.def.minor_radius_mm + bend;
    curves += plan_curvature(p->part[surface], place);
    return pitch * pitch * curves / (4 * c * c) + ROUNDING_MM;
}

static void note(errors *e, double error, double bound) {
    if (error >= e->most) e->most = error, e->bound = bound;
    e->share = fmax(e->share, error / bound);
}

static btg_status drops(const papers *p, int surface, study *s, btg_backend *raw, double pitch,
                        errors *e) {
    btg_drop_result found[COUNT];
    btg_status status = btg_backend_drop(raw, s->drops, COUNT, found, NULL);
    for (int i = 0; i < COUNT && status >= 0; i++) {
        const btg_drop_result *right = &s->dropped[i];
        if (right->status != BTG_OK || on_edge(right->contact.place)) continue;
        double c = right->contact.normal.z;
        note(e, fabs(found[i].height_mm - right->height_mm),
             hidden(p, surface, right->contact.place, pitch, c, 0) / c);
    }
    return status;
}

/* As clearances. */
static btg_status tilts(const papers *p, int surface, study *s, btg_backend *raw, double pitch,
                        errors *e) {
    btg_tilt_result found[COUNT];
    btg_status status = btg_backend_tilt(raw, s->tilts, s->tilt_count, found, NULL);
    for (size_t i = 0; i < s->tilt_count && status >= 0; i++) {
        const btg_tilt_query *q = &s->tilts[i];
        const btg_tilt_result *right = &s->tilted[i];
        if (right->status != BTG_OK || on_edge(right->contact.place)) continue;
        btg_vec3 arm = vec_sub(right->contact.point, q->o1);
        double lever = fabs(vec_dot(vec_cross(q->u, arm), right->contact.normal));
        double along = vec_dot(arm, q->u), radius = sqrt(vec_norm2(arm) - along * along);
        note(e, lever * fabs(found[i].tilt_rad - right->tilt_rad),
             hidden(p, surface, right->contact.place, pitch, lever / radius, 1 / radius));
    }
    return status;
}

static btg_status measure(papers *p, int surface, study *s, int levels, uint32_t pixels,
                          errors e[2]) {
    btg_backend *raw = NULL;
    double pitch = 2 * (p->tool.def.major_radius_mm + p->tool.def.minor_radius_mm) / pixels;
    if (levels == 2) pitch *= 2.0 / pixels;
    btg_status status = open_backend(p, surface, "osmesa", (uint32_t)levels, pixels, &raw);
    if (status != BTG_OK) return status;
    status = drops(p, surface, s, raw, pitch, &e[0]);
    if (status >= 0) status = tilts(p, surface, s, raw, pitch, &e[1]);
    btg_backend_close(raw);
    return status < 0 ? status : BTG_OK;
}

static const char *const question[2] = {"drop, height", "tilt, clearance"};

static void add(papers *p, int levels, uint32_t pixels, const errors e[2]) {
    char item[64];
    snprintf(item, sizeof item, "%s level%s, %u x %u", levels == 1 ? "one" : "two",
             levels == 1 ? "" : "s", (unsigned)pixels, (unsigned)pixels);
    for (int k = 0; k < 2; k++) {
        papers_name(papers_add(p, table, "mm", e[k].most, NAN), item, "%s: greatest", question[k]);
        papers_name(papers_add(p, table, "", 1 / e[k].share, NAN), item, "bound over it, least");
    }
}

static btg_status draw(papers *p, const errors e[2][SIZES][2]) {
    static const char *const name[2][2] = {{"bound, one level", "measured, one level"},
                                           {"bound, two levels", "measured, two levels"}};
    double x[2][SIZES], y[2][2][2][SIZES];
    btg_chart_panel panels[2] = {
        btg_chart_panel_of("DROP: height", "log10 of the window, pixels", "log10 of the error, mm"),
        btg_chart_panel_of("TILT: clearance", "log10 of the window, pixels",
                           "log10 of the error, mm")};
    for (int k = 0; k < 2; k++)
        for (int l = 0; l < 2; l++) {
            for (int i = 0; i < SIZES; i++) {
                x[l][i] = log10(window[l][i]);
                y[k][l][0][i] = log10(e[l][i][k].bound);
                y[k][l][1][i] = log10(e[l][i][k].most);
            }
            btg_chart_add(&panels[k], BTG_CHART_LINE, l, name[l][0], x[l], y[k][l][0], SIZES);
            btg_chart_add(&panels[k], BTG_CHART_DOTS, l, name[l][1], x[l], y[k][l][1], SIZES);
        }
    return papers_chart(p, "osmesa-raw-errors",
                        "Depth images: greatest error as found, three surfaces, and its bound",
                        panels, 2, 2);
}

btg_status papers_raw(papers *p) {
    study *s = malloc(PAPERS_SURFACES * sizeof *s);
    errors e[2][SIZES][2] = {0};
    btg_status status = s ? BTG_OK : BTG_ERROR_MEMORY;
    papers_show(p, "error of depth images");
    for (int k = 0; k < PAPERS_SURFACES && status == BTG_OK; k++)
        status = begin(p, k, &s[k]);
    for (int i = 0; i < 2 * SIZES && status == BTG_OK; i++) {
        int level = i / SIZES, size = i % SIZES;
        if (p->quick && size >= QUICK_SIZES) continue;
        for (int k = 0; k < PAPERS_SURFACES && status == BTG_OK; k++)
            status = measure(p, k, &s[k], level + 1, window[level][size], e[level][size]);
        if (status == BTG_OK) add(p, level + 1, window[level][size], e[level][size]);
    }
    free(s);
    if (status == BTG_ERROR_MEMORY) btg_fail(&p->message, status, "bench: out of memory");
    if (status != BTG_OK) return status;
    papers_note_add(p, table,
                    "osmesa --raw against the exact solver, %d places on each of the three "
                    "surfaces, contacts not on the part's edge. The bound is that of pixels "
                    "half a diagonal from the contact, p^2 (1/RI + k) / (4 c^2), and of "
                    "single precision, 3e-7 of the part's size, each at its own contact.",
                    COUNT);
    return draw(p, (const errors(*)[SIZES][2])e);
}
