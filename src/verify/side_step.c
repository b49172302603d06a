/* The side step of a scallop height, by trial: passes are solved, cut into a field, and what they
 * leave between them is measured. The widths of strips at single positions do not say it: where P
 * and Q lie apart, what is between them is a neighbour's to cut. */
#include "bitangent/verify.h"
#include "core/part.h"

#include <string.h>

#define DEF_VERSION 1
/* Trials halve from the tool's diameter down to this part of it, */
#define LEAST_PART 0.05
/* and close in on the widest step until two of them differ by no more than this part. */
#define CLOSE_PART 0.02
/* Cells: a field of so many, and so many across a step at least; no whole number, so that cells
 * come to lie everywhere between passes. */
#define CELLS       200000.0
#define CELLS_ASTEP 2.618
#define CHUNK       2048

typedef struct trial {
    const btg_side_step_def *def;
    const btg_part *part;
    const btg_tool *tool;
    btg_part_info info;
    btg_footprint_point *points;
    double xy[2 * CHUNK];
    btg_position positions[CHUNK];
} trial;

btg_side_step_def btg_side_step_def_default(void) {
    btg_side_step_def def;
    memset(&def, 0, sizeof def);
    def.version = DEF_VERSION;
    def.footprint = btg_footprint_def_default();
    def.scallop_mm = 0.01;
    def.share = 0.99;
    return def;
}

/* Solves the footprint and cuts it. */
static btg_status cut(trial *t, size_t count, btg_verify *verify) {
    btg_status status = BTG_OK;
    bool contact = false;
    for (size_t first = 0; first < count && status == BTG_OK; first += CHUNK) {
        size_t n = count - first < CHUNK ? count - first : CHUNK;
        const btg_footprint_point *p = &t->points[first];
        for (size_t i = 0; i < n; i++) {
            t->xy[2 * i] = p[i].x_mm;
            t->xy[2 * i + 1] = p[i].y_mm;
        }
        status = t->def->solve(t->xy, n, t->positions, t->def->user);
        for (size_t i = 0; i < n && status == BTG_OK; i++) {
            const btg_position *q = &t->positions[i];
            bool linked = contact && p[i].point > 0;
            contact = q->status >= 0 && q->status != BTG_NO_CONTACT;
            if (!contact) continue;
            btg_verify_pose pose = {.tip = q->tip, .axis = q->axis, .link = linked};
            status = btg_verify_add(verify, &pose);
        }
    }
    return status;
}

/* Share of the part's cells, a tool's radius inside its extent, that have no more than the scallop
 * left. */
static double finished(const trial *t, const btg_verify_map *map) {
    double reach = t->tool->def.major_radius_mm + t->tool->def.minor_radius_mm;
    double wide = t->info.box_max.x - t->info.box_min.x,
           high = t->info.box_max.y - t->info.box_min.y;
    double mx = min2(reach, wide / 4), my = min2(reach, high / 4);
    uint64_t all = 0, done = 0;
    for (size_t i = 0; i < (size_t)map->width * map->height; i++) {
        double x = map->x_mm + (double)(i % map->width) * map->cell_mm;
        double y = map->y_mm + (double)(i / map->width) * map->cell_mm;
        if (x < t->info.box_min.x + mx || x > t->info.box_max.x - mx) continue;
        if (y < t->info.box_min.y + my || y > t->info.box_max.y - my) continue;
        double left = btg_verify_deviation(map, i);
        if (isnan(left)) continue;
        all++;
        if (left <= t->def->scallop_mm) done++;
    }
    return all > 0 ? (double)done / (double)all : 0;
}

static btg_status try_step(trial *t, double step, double *share, btg_message *message) {
    btg_footprint_def f = t->def->footprint;
    size_t count;
    f.kind = BTG_FOOTPRINT_PARALLEL;
    f.side_step_mm = step;
    btg_status status = btg_footprint_count(&f, &count, message);
    if (status != BTG_OK) return status;
    btg_verify_def def = btg_verify_def_default();
    double wide = t->info.box_max.x - t->info.box_min.x,
           high = t->info.box_max.y - t->info.box_min.y;
    def.cell_mm = max2(min2(sqrt(wide * high / CELLS), step / CELLS_ASTEP), 1e-3);
    def.sweep_error_mm = min2(0.1 * t->def->scallop_mm, 0.01);
    def.threads = t->def->threads;
    def.prove = 0;
    def.allocator = t->def->allocator;
    btg_verify *verify = NULL;
    btg_verify_result result;
    t->points = btg_allocate(&def.allocator, count, sizeof *t->points);
    if (!t->points) return btg_fail(message, BTG_ERROR_MEMORY, "side step: out of memory");
    status = btg_footprint_fill(&f, t->points, count);
    if (status == BTG_OK) status = btg_verify_create(&def, t->part, t->tool, &verify, message);
    if (status == BTG_OK) {
        status = cut(t, count, verify);
        if (status == BTG_OK) status = btg_verify_end(verify, &result);
        if (status < 0) btg_fail(message, status, "side step: %g mm cannot be tried", step);
    }
    if (status == BTG_OK) {
        btg_verify_map map = btg_verify_get_map(verify);
        *share = finished(t, &map);
    }
    btg_verify_destroy(verify);
    btg_release(&def.allocator, t->points);
    t->points = NULL;
    return status;
}

static btg_status search(trial *t, double *step, btg_message *message) {
    double widest = 2 * (t->tool->def.major_radius_mm + t->tool->def.minor_radius_mm);
    double good = widest, bad = 0, share = 0, least = widest * LEAST_PART;
    btg_status status = try_step(t, good, &share, message);
    while (status == BTG_OK && share < t->def->share && good > least) {
        bad = good;
        good = max2(good / 2, least);
        status = try_step(t, good, &share, message);
    }
    if (status != BTG_OK) return status;
    if (share < t->def->share)
        return btg_fail(
            message, BTG_ERROR_ARGUMENT,
            "side step: even %.3g mm leaves more than %g mm on %.3g %% of the part; give "
            "a greater scallop, a smaller forward step or another tool",
            good, t->def->scallop_mm, 100 * (1 - share));
    while (status == BTG_OK && bad > good * (1 + CLOSE_PART)) {
        double middle = sqrt(good * bad);
        status = try_step(t, middle, &share, message);
        if (share >= t->def->share)
            good = middle;
        else
            bad = middle;
    }
    *step = good;
    return status;
}

btg_status btg_side_step(const btg_side_step_def *def, const btg_part *part, const btg_tool *tool,
                         double *step_mm, btg_message *message) {
    if (!def || !part || !tool || !step_mm || !def->solve)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "side step: an argument is NULL");
    if (def->version != DEF_VERSION)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "side step: unknown version; start from btg_side_step_def_default()");
    if (!(def->scallop_mm >= BTG_SIDE_STEP_SCALLOP_MIN && def->scallop_mm <= BTG_LENGTH_MAX) ||
        !(def->share > 0 && def->share <= 1))
        return btg_fail(
            message, BTG_ERROR_ARGUMENT,
            "side step: give a scallop of 0.001 mm or more and a share above 0, up to 1");
    trial *t = btg_allocate(&def->allocator, 1, sizeof *t);
    if (!t) return btg_fail(message, BTG_ERROR_MEMORY, "side step: out of memory");
    memset(t, 0, sizeof *t);
    t->def = def;
    t->part = part;
    t->tool = tool;
    btg_part_get_info(part, &t->info);
    double step = 0;
    btg_status status = search(t, &step, message);
    if (status == BTG_OK) *step_mm = step;
    btg_release(&def->allocator, t);
    return status;
}
