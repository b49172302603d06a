/* How finely to sample: the error model of M. Singh, S. Bedi, S. Mann, "A GPU Method and Error
 * Analysis of Multi-Point Positioning of a Toroidal Tool for 5-Axis Machining", 2024, sections 6 to
 * 9, turned round (methods/error_model.h). */
#include "app/plan.h"
#include "app/app.h"
#include "app/bench.h"
#include "core/part.h"
#include "methods/error_model.h"

#include <stdlib.h>
#include <string.h>

/* Normals and curvatures are sampled at so many places along a side of a patch. */
#define SAMPLES 17
/* Between samples they are that much steeper, or more curved. */
#define STEEPER 0.03
#define ROUNDER 1.1
/* Pixels take half of the tolerance, facets of tool and part a quarter each: time is flat there. */
#define PIXEL_SHARE 0.5
#define FACET_SHARE 0.25
/* Of the pixels' share; where rounding takes more, finer pixels help little. */
#define MOST_ROUNDING 0.5
/* The back end that draws depth images, in single precision. */
#define RASTER "osmesa"
/* Back ends take no smaller and no larger windows. */
#define WINDOW_MIN 8
#define WINDOW_MAX 4096

#define CHECK_PLACES 256
#define CHECK_LEAST  8
/* Pixels of a check: fewer places with larger windows. */
#define CHECK_PIXELS 2e6
#define CHECK_TRIES  1024
#define TIMED_PLACES 4

/* ---- the part ----------------------------------------------------------------------------- */

/* Principal curvatures at a place, eigenvalues of the second form in the first: the greatest either
 * way, and the greatest away from the side the tool comes from. */
static double curvature_at(const btg_surface_point *f, btg_vec3 n, double *bulge) {
    double e = vec_norm2(f->su), m = vec_dot(f->su, f->sv), g = vec_norm2(f->sv);
    double l = vec_dot(f->suu, n), o = vec_dot(f->suv, n), q = vec_dot(f->svv, n);
    double det = e * g - m * m;
    double mean = 0.5 * (e * q - 2 * m * o + g * l) / det, gauss = (l * q - o * o) / det;
    double spread = sqrt(fmax(mean * mean - gauss, 0));
    *bulge = fmax(spread - (n.z < 0 ? -mean : mean), 0);
    return fabs(mean) + spread;
}

double plan_curvature(const btg_part *part, btg_place place) {
    btg_surface_point f;
    double bulge;
    btg_part_point(part, place, &f);
    return curvature_at(&f, vec_unit(vec_cross(f.su, f.sv)), &bulge);
}

static double bulge_at(const btg_part *part, btg_place place) {
    btg_surface_point f;
    double bulge;
    btg_part_point(part, place, &f);
    return isfinite(curvature_at(&f, vec_unit(vec_cross(f.su, f.sv)), &bulge)) ? bulge : 0;
}

static void look_at(const btg_part *part, btg_place place, plan_part *out, double *most) {
    btg_surface_point f;
    btg_part_point(part, place, &f);
    btg_vec3 n = vec_cross(f.su, f.sv);
    if (!(vec_norm2(n) > 0)) return;
    n = vec_unit(n);
    double bulge, k = curvature_at(&f, n, &bulge);
    double slope = atan2(norm2(n.x, n.y), fabs(n.z));
    plan_ground *ground = &out->ground[(int)fmin(PLAN_GROUNDS * sin(slope), PLAN_GROUNDS - 1)];
    out->slope_rad = fmax(out->slope_rad, slope);
    ground->sine = fmax(ground->sine, sin(fmin(slope + STEEPER, BTG_PI / 2)));
    if (!isfinite(k)) return;
    *most = fmax(*most, k);
    ground->bulge = fmax(ground->bulge, ROUNDER * bulge);
}

plan_part plan_look(const btg_part *part) {
    btg_part_info info;
    plan_part out = {0};
    double most = 0;
    btg_part_get_info(part, &info);
    out.side_mm[0] = info.box_max.x - info.box_min.x;
    out.side_mm[1] = info.box_max.y - info.box_min.y;
    out.size_mm = fmax(fmax(out.side_mm[0], out.side_mm[1]), info.box_max.z - info.box_min.z);
    out.triangles = info.triangle_count > 0;
    for (uint32_t i = 0; i < part->patch_count; i++)
        for (int k = 0; k < SAMPLES * SAMPLES; k++) {
            btg_place at = {i, (double)(k / SAMPLES) / (SAMPLES - 1),
                            (double)(k % SAMPLES) / (SAMPLES - 1)};
            look_at(part, at, &out, &most);
        }
    for (uint32_t i = 0; i < part->triangle_count; i++)
        look_at(part, (btg_place){part->patch_count + i, 1.0 / 3, 1.0 / 3}, &out, &most);
    out.slope_rad = fmin(out.slope_rad + STEEPER, BTG_PI / 2);
    out.radius_mm = most > 1e-9 ? 1 / (most * ROUNDER) : INFINITY;
    return out;
}

/* ---- the plan ----------------------------------------------------------------------------- */

bool plan_raster_ready(void) {
    for (size_t i = 0; i < btg_backend_count(); i++) {
        btg_backend_info info;
        if (btg_backend_get_info(i, &info) == BTG_OK && strcmp(info.name, RASTER) == 0)
            return info.state == BTG_BACKEND_READY;
    }
    return false;
}

static double width_of(const btg_tool *tool) {
    return 2 * (tool->def.major_radius_mm + tool->def.minor_radius_mm);
}

plan_way plan_way_of(const btg_tool *tool, const plan *p, uint32_t window, int levels) {
    plan_way way = {.levels = levels, .window = window};
    double n = window;
    way.pitch_mm = levels == 1 ? width_of(tool) / n : 2 * width_of(tool) / (n * n);
    for (int i = 0; i < PLAN_GROUNDS; i++) {
        const plan_ground *g = &p->part.ground[i];
        double ro = tool->def.major_radius_mm, ri = tool->def.minor_radius_mm;
        double bound = btg_pixel_bound(ro, ri, ri * g->sine, way.pitch_mm, g->bulge);
        way.bound_mm = fmax(way.bound_mm, bound + p->rounding_mm);
    }
    way.pixels = levels * n * n;
    return way;
}

/* The window whose bound is the pixels' share. */
static plan_way window_of(const btg_tool *tool, const plan *p, int levels) {
    double pitch = INFINITY, ro = tool->def.major_radius_mm, ri = tool->def.minor_radius_mm;
    for (int i = 0; i < PLAN_GROUNDS; i++) {
        const plan_ground *g = &p->part.ground[i];
        pitch = fmin(pitch, btg_pixel_pitch(ro, ri, ri * g->sine, g->bulge,
                                            p->pixel_share_mm - p->rounding_mm));
    }
    double n = levels == 1 ? width_of(tool) / pitch : sqrt(2 * width_of(tool) / pitch);
    n = fmin(fmax(ceil(n), WINDOW_MIN), 1e9);
    return plan_way_of(tool, p, (uint32_t)n, levels);
}

static plan_facets around(double radius, double error, double times) {
    plan_facets f = {.length_mm = btg_facet_length(radius, error)};
    f.count = ceil(2 * BTG_PI * radius / f.length_mm);
    f.triangles = 2 * f.count * times;
    return f;
}

btg_status plan_make(const btg_tool *tool, const plan_part *part, double tolerance_mm, plan *out,
                     btg_message *message) {
    double ro = tool->def.major_radius_mm, ri = tool->def.minor_radius_mm;
    *out = (plan){.part = *part};
    out->pixel_share_mm = PIXEL_SHARE * tolerance_mm;
    out->tool_share_mm = out->part_share_mm = FACET_SHARE * tolerance_mm;
    if (plan_raster_ready()) out->rounding_mm = PLAN_ROUNDING * part->size_mm;
    if (out->rounding_mm > MOST_ROUNDING * out->pixel_share_mm) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "--tolerance: %.3g mm; depth images round by %.2g mm on a part of that "
                        "size: ask for %.2g or more, or position without them ('--method vcrf')",
                        tolerance_mm, out->rounding_mm,
                        out->rounding_mm / (MOST_ROUNDING * PIXEL_SHARE));
    }
    out->one = window_of(tool, out, 1);
    out->two = window_of(tool, out, 2);
    out->insert = around(ri, out->tool_share_mm, 1);
    out->rim = around(ro + ri, out->tool_share_mm, out->insert.count);
    out->surface.length_mm = btg_facet_length(part->radius_mm, out->part_share_mm);
    double a = ceil(part->side_mm[0] / out->surface.length_mm);
    double b = ceil(part->side_mm[1] / out->surface.length_mm);
    out->surface.count = fmax(a, 1);
    out->surface.triangles = 2 * fmax(a, 1) * fmax(b, 1);
    return BTG_OK;
}

/* ---- the check ---------------------------------------------------------------------------- */

/* A contact away from the edges of its surface, where the model holds. */
static bool smooth(const btg_drop_result *drop) {
    const btg_place *p = &drop->contact.place;
    return drop->status == BTG_OK && p->u > 0.01 && p->u < 0.99 && p->v > 0.01 && p->v < 0.99;
}

/* Exact drops first: those places that count are kept. */
static size_t exact_drops(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                          size_t most, btg_drop_query *queries, btg_drop_result *drops) {
    size_t size = btg_workspace_size(part), kept = 0;
    void *workspace = malloc(size);
    btg_part_info info;
    btg_part_get_info(part, &info);
    for (size_t i = 0; i < CHECK_TRIES && kept < most && workspace; i++) {
        double xy[2];
        bench_spread(&info, i, xy);
        queries[kept] = btg_position_drop_query(xy[0], xy[1]);
        if (btg_drop(part, tool, solver, &queries[kept], workspace, size, &drops[kept]) >= 0 &&
            smooth(&drops[kept]))
            kept++;
    }
    free(workspace);
    return kept;
}

/* How deep the tool is in the part along the normal: the height that is lacking, leaned. */
static void compare(const btg_part *part, const btg_tool *tool, const plan *p, const plan_way *way,
                    const btg_drop_result *exact, const btg_drop_result *sampled,
                    plan_check *check) {
    double ro = tool->def.major_radius_mm, ri = tool->def.minor_radius_mm;
    check->measured_mm = check->share = 0;
    for (size_t i = 0; i < check->places; i++) {
        double rise = fmin(fabs(exact[i].contact.normal.z), 1);
        double deep = (exact[i].height_mm - sampled[i].height_mm) * rise;
        double bound = btg_pixel_bound(ro, ri, ri * sqrt(1 - rise * rise), way->pitch_mm,
                                       bulge_at(part, exact[i].contact.place)) +
                       p->rounding_mm;
        if (sampled[i].status != BTG_OK) continue;
        check->measured_mm = fmax(check->measured_mm, deep);
        check->share = fmax(check->share, deep / bound);
    }
}

static btg_status time_positions(btg_method *m, const btg_drop_query *queries, size_t count,
                                 double *seconds) {
    double xy[2 * TIMED_PLACES];
    btg_position out[TIMED_PLACES];
    size_t n = count < TIMED_PLACES ? count : TIMED_PLACES;
    for (size_t i = 0; i < n; i++) {
        xy[2 * i] = queries[i].origin.x;
        xy[2 * i + 1] = queries[i].origin.y;
    }
    double begin = app_seconds();
    btg_status status = btg_backend_positions(btg_method_front(m), xy, n, out, NULL);
    *seconds = n > 0 ? (app_seconds() - begin) / (double)n : 0;
    return status;
}

btg_status plan_measure(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                        const plan *p, const plan_way *way, plan_check *check,
                        btg_message *message) {
    btg_drop_query *queries = malloc(CHECK_PLACES * sizeof *queries);
    btg_drop_result *exact = malloc(2 * CHECK_PLACES * sizeof *exact);
    btg_method_def def = btg_method_def_default();
    btg_method *m = NULL;
    bool raster = p->rounding_mm > 0;
    *check = (plan_check){.measured_mm = NAN, .share = NAN, .seconds = NAN};
    def.name = "depth";
    def.backend.name = raster ? RASTER : "cpu";
    def.backend.raw = raster;
    def.window = way->window;
    def.levels = way->levels;
    btg_status status = queries && exact ? BTG_OK : BTG_ERROR_MEMORY;
    if (way->window > WINDOW_MAX) status = BTG_ERROR_UNSUPPORTED;
    if (status == BTG_OK) status = btg_method_open(&def, part, tool, solver, &m, message);
    if (status == BTG_OK) {
        double most = fmin(fmax(CHECK_PIXELS / way->pixels, CHECK_LEAST), CHECK_PLACES);
        check->places = exact_drops(part, tool, solver, (size_t)most, queries, exact);
        btg_drop_result *sampled = exact + CHECK_PLACES;
        status = btg_backend_drop(btg_method_front(m), queries, check->places, sampled, NULL);
        if (status >= 0) compare(part, tool, p, way, exact, sampled, check);
        if (status >= 0) status = time_positions(m, queries, check->places, &check->seconds);
        check->backend = def.backend.name;
    }
    btg_method_close(m);
    free(queries);
    free(exact);
    if (status == BTG_ERROR_UNSUPPORTED) return BTG_OK; /* planned, not measured */
    return status < 0
               ? btg_fail(message, status, "plan: cannot measure (%s)", btg_status_name(status))
               : BTG_OK;
}
