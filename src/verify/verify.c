#include "verify/internal.h"

#include <string.h>

#define DEF_VERSION    1
#define CELL_MM        0.1
#define CELLS_DEFAULT  16e6
#define AXIS_Z_MIN     1e-3 /* a tool that lies down has no lower side to speak of */
#define UNIT_TOLERANCE 1e-6
#define PROOF_BLOCK    16 /* drops that follow each other on one thread, each from the last */
/* A search cut short gives a height that is safe, and too high. */
#define PROOF_NODES     20000
#define COLLISION_NODES 2000
/* Shank and holder that touch the part by less do not collide. */
#define COLLISION_MM 0.01
#define POSE_ORDERS  8

typedef struct proof {
    double bound, collision;
    uint32_t hit; /* 1: shank or holder */
} proof;

struct btg_verify {
    btg_verify_def def;
    const btg_part *part;
    btg_tool tool, cutter_only;
    btg_cutter cutter;
    btg_field field;
    uint32_t threads, bands;
    btg_band *band;
    btg_step *steps;
    uint8_t *is_pose; /* of each step: it stands at a pose, the others lead there */
    proof *proofs;
    size_t step_count;
    char *workspaces;
    size_t workspace_size;
    btg_verify_pose last;
    btg_verify_place last_place;
    bool placed;       /* those two are */
    uint64_t poses;    /* taken so far */
    uint64_t last_hit; /* position counted as a collision last */
    btg_verify_result result;
};

btg_verify_def btg_verify_def_default(void) {
    return (btg_verify_def){.version = DEF_VERSION,
                            .sweep_error_mm = 0.001,
                            .stock_mm = 5,
                            .gouge_mm = 0.01,
                            .scallop_mm = 0.01,
                            .tolerance_mm = 1e-4,
                            .prove = 1};
}

/* ---- set-up ------------------------------------------------------------------------------- */

static btg_status check(const btg_verify_def *def, btg_message *message) {
    if (def->version != DEF_VERSION)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "verify: unknown version; start from btg_verify_def_default()");
    if (!(def->cell_mm == 0 || (def->cell_mm >= 1e-6 && def->cell_mm <= BTG_LENGTH_MAX)))
        return btg_fail(message, BTG_ERROR_ARGUMENT, "verify: cells of %g mm; give 1e-6 to 1e6",
                        def->cell_mm);
    if (!(def->sweep_error_mm >= 1e-9 && def->sweep_error_mm <= BTG_LENGTH_MAX))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "verify: a sweep error of %g mm; give 1e-9 or more", def->sweep_error_mm);
    if (!(def->pose_error_mm >= 0 && def->pose_error_mm < def->sweep_error_mm))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "verify: a pose error of %g mm; give 0 or more, below the sweep error",
                        def->pose_error_mm);
    if (!(def->stock_mm >= 0 && def->stock_mm <= BTG_LENGTH_MAX))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "verify: a stock of %g mm over the part; give 0 or more", def->stock_mm);
    if (!(def->gouge_mm >= 0) || !(def->scallop_mm >= 0))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "verify: a limit of gouge or scallop is negative; give 0 or more");
    return BTG_OK;
}

/* Cell centres lie half a cell inside the part's extent, so that edges are not missed by rounding;
 * the last cells may stand out. */
static btg_status lay_out(btg_verify *v, btg_message *message) {
    btg_field *f = &v->field;
    btg_part_info info;
    btg_part_get_info(v->part, &info);
    double wide = info.box_max.x - info.box_min.x, high = info.box_max.y - info.box_min.y;
    f->cell = v->def.cell_mm;
    if (f->cell == 0) f->cell = max2(CELL_MM, sqrt(wide * high / CELLS_DEFAULT));
    double columns = max2(1, ceil(wide / f->cell - 1e-6)),
           rows = max2(1, ceil(high / f->cell - 1e-6));
    if (!(columns * rows <= BTG_VERIFY_CELLS_MAX))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "verify: %.0f x %.0f cells are too many, at most %d; give a larger cell",
                        columns, rows, BTG_VERIFY_CELLS_MAX);
    f->width = (uint32_t)columns;
    f->height = (uint32_t)rows;
    f->x = info.box_min.x + 0.5 * min2(f->cell, wide);
    f->y = info.box_min.y + 0.5 * min2(f->cell, high);
    f->top = info.box_max.z + v->def.stock_mm;
    f->bottom = info.box_min.z;
    f->tiles.width = (f->width + BTG_TILE - 1) / BTG_TILE;
    f->tiles.height = (f->height + BTG_TILE - 1) / BTG_TILE;
    v->bands = (f->height + BTG_BAND_ROWS - 1) / BTG_BAND_ROWS;
    return BTG_OK;
}

static btg_status allocate(btg_verify *v) {
    const btg_allocator *a = &v->def.allocator;
    size_t cells = (size_t)v->field.width * v->field.height;
    btg_tiles *t = &v->field.tiles;
    size_t tiles = (size_t)t->width * t->height;
    t->z = btg_allocate(a, tiles, sizeof *t->z);
    t->along_x = btg_allocate(a, tiles, sizeof *t->along_x);
    t->along_y = btg_allocate(a, tiles, sizeof *t->along_y);
    t->stale = btg_allocate(a, tiles, sizeof *t->stale);
    v->workspace_size = (btg_workspace_size(v->part) + 63) / 64 * 64;
    v->field.part_z = btg_allocate(a, cells, sizeof *v->field.part_z);
    v->field.stock_z = btg_allocate(a, cells, sizeof *v->field.stock_z);
    v->field.normal_z = btg_allocate(a, cells, sizeof *v->field.normal_z);
    v->band = btg_allocate(a, v->bands, sizeof *v->band);
    v->steps = btg_allocate(a, BTG_STEPS_MAX, sizeof *v->steps);
    v->is_pose = btg_allocate(a, BTG_STEPS_MAX, sizeof *v->is_pose);
    v->proofs = btg_allocate(a, BTG_STEPS_MAX, sizeof *v->proofs);
    v->workspaces = btg_allocate(a, v->threads, v->workspace_size);
    if (!v->field.part_z || !v->field.stock_z || !v->field.normal_z || !v->band || !v->steps ||
        !v->is_pose || !v->proofs || !v->workspaces || !t->z || !t->along_x || !t->along_y ||
        !t->stale)
        return BTG_ERROR_MEMORY;
    memset(t->stale, 1, tiles);
    for (size_t i = 0; i < cells; i++) {
        v->field.part_z[i] = -INFINITY;
        v->field.stock_z[i] = v->field.top;
        v->field.normal_z[i] = 1;
    }
    memset(v->band, 0, v->bands * sizeof *v->band);
    return BTG_OK;
}

/* Each band's rows by one thread. Few bands here: each looks at all of the part's pieces. */
static void fill_rows(void *job, size_t i, uint32_t thread) {
    btg_verify *v = job;
    uint64_t rows = v->field.height, shares = v->threads;
    (void)thread;
    btg_field_part(&v->field, v->part, (uint32_t)(rows * i / shares),
                   (uint32_t)(rows * (i + 1) / shares));
}

btg_status btg_verify_create(const btg_verify_def *def, const btg_part *part, const btg_tool *tool,
                             btg_verify **verify, btg_message *message) {
    if (!def || !part || !tool || !verify)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "verify: an argument is NULL");
    btg_status status = check(def, message);
    if (status < 0) return status;
    btg_verify *v = btg_allocate(&def->allocator, 1, sizeof *v);
    if (!v) return btg_fail(message, BTG_ERROR_MEMORY, "verify: out of memory");
    memset(v, 0, sizeof *v);
    v->def = *def;
    v->part = part;
    v->tool = *tool;
    v->cutter_only = *tool;
    v->cutter_only.element_count = 1;
    v->cutter = (btg_cutter){tool->def.major_radius_mm, tool->def.minor_radius_mm,
                             tool->element[0].hollow != 0};
    v->threads = btg_crew_threads(def->threads);
    status = lay_out(v, message);
    if (status == BTG_OK && allocate(v) != BTG_OK)
        status = btg_fail(message, BTG_ERROR_MEMORY,
                          "verify: no memory for %u x %u cells; give a larger cell", v->field.width,
                          v->field.height);
    if (status < 0) {
        btg_verify_destroy(v);
        return status;
    }
    btg_crew_run(v->threads, v->threads, fill_rows, v);
    v->result.cell_mm = v->field.cell;
    v->result.sweep_error_mm = def->sweep_error_mm;
    *verify = v;
    return BTG_OK;
}

void btg_verify_destroy(btg_verify *v) {
    if (!v) return;
    btg_allocator a = v->def.allocator;
    btg_tiles *t = &v->field.tiles;
    void *memory[] = {v->field.part_z, v->field.stock_z, v->field.normal_z, v->band, v->steps,
                      v->is_pose,      v->proofs,        v->workspaces,     t->z,    t->along_x,
                      t->along_y,      t->stale};
    for (size_t i = 0; i < sizeof memory / sizeof *memory; i++)
        btg_release(&a, memory[i]);
    btg_release(&a, v);
}

/* ---- work on the steps -------------------------------------------------------------------- */

static void cut_band(void *job, size_t i, uint32_t thread) {
    btg_verify *v = job;
    uint32_t first = (uint32_t)i * BTG_BAND_ROWS, end = first + BTG_BAND_ROWS;
    (void)thread;
    if (end > v->field.height) end = v->field.height;
    btg_stock_cut(&v->field, &v->cutter, v->steps, v->step_count, first, end, &v->band[i]);
}

/* Backed out along its axis by the drop's height the tool is clear to the drop's bound, and no
 * point of it has moved by more: so deep can it be in the part where it stands. */
static double backing(const btg_verify *v, const btg_tool *tool, const btg_step *step,
                      char *workspace, btg_place *near, int *has_near, double *bound) {
    btg_solver_def solver = btg_solver_def_default();
    solver.tolerance_mm = tool->element_count > 1 ? COLLISION_MM : v->def.tolerance_mm;
    solver.node_budget = tool->element_count > 1 ? COLLISION_NODES : PROOF_NODES;
    btg_drop_query q = {.origin = step->centre, .axis = step->axis};
    q.has_start = *has_near;
    q.start = *near;
    btg_drop_result r;
    btg_status status = btg_drop(v->part, tool, &solver, &q, workspace, v->workspace_size, &r);
    *bound = 0;
    if (status < 0) return INFINITY;
    if (r.status == BTG_NO_CONTACT) return -INFINITY;
    *bound = r.bound_mm;
    if (r.status == BTG_OK) *near = r.contact.place, *has_near = 1;
    return r.height_mm;
}

static double lowest(const btg_verify *v, const btg_step *step) {
    double across = norm2(step->axis.x, step->axis.y), low = INFINITY;
    for (uint32_t i = 0; i < v->tool.element_count; i++) {
        const btg_tool_element *e = &v->tool.element[i];
        low =
            min2(low, e->from_mm * step->axis.z - e->ring_radius_mm * across - e->corner_radius_mm);
    }
    return step->centre.z + low;
}

static void prove_block(void *job, size_t block, uint32_t thread) {
    btg_verify *v = job;
    char *workspace = v->workspaces + thread * v->workspace_size;
    size_t first = block * PROOF_BLOCK, end = first + PROOF_BLOCK;
    btg_place near = {0};
    int has_near = 0;
    if (end > v->step_count) end = v->step_count;
    for (size_t i = first; i < end; i++) {
        const btg_step *step = &v->steps[i];
        proof *p = &v->proofs[i];
        double bound, all;
        *p = (proof){0};
        if (lowest(v, step) > v->field.top - v->def.stock_mm) continue;
        double height = backing(v, &v->cutter_only, step, workspace, &near, &has_near, &bound);
        p->bound = max2(height, 0) + bound;
        if (v->tool.element_count < 2) continue;
        all = backing(v, &v->tool, step, workspace, &near, &has_near, &bound);
        p->hit = all - bound > max2(height, 0) + COLLISION_MM;
        if (p->hit) p->collision = all;
    }
}

static void take_proofs(btg_verify *v) {
    btg_verify_result *r = &v->result;
    for (size_t i = 0; i < v->step_count; i++) {
        const proof *p = &v->proofs[i];
        const btg_verify_place *place = &v->steps[i].place;
        if (p->bound > r->motion_bound_mm) {
            r->motion_bound_mm = p->bound;
            r->bound = *place;
        }
        if (v->is_pose[i]) r->position_bound_mm = max2(r->position_bound_mm, p->bound);
        if (!p->hit) continue;
        if (place->position != v->last_hit) r->collisions++;
        v->last_hit = place->position;
        if (p->collision <= r->collision_mm) continue;
        r->collision_mm = p->collision;
        r->collision = *place;
    }
}

static void flush(btg_verify *v) {
    if (v->step_count == 0) return;
    btg_crew_run(v->threads, v->bands, cut_band, v);
    if (v->def.prove) {
        size_t blocks = (v->step_count + PROOF_BLOCK - 1) / PROOF_BLOCK;
        btg_crew_run(v->threads, blocks, prove_block, v);
        take_proofs(v);
    }
    v->result.steps += v->step_count;
    v->step_count = 0;
}

/* ---- the path ----------------------------------------------------------------------------- */

static uint32_t twos(uint64_t n, uint32_t most) {
    uint32_t k = 0;
    while (k < most && n > 0 && n % 2 == 0)
        n /= 2, k++;
    return k;
}

static void add_step(btg_verify *v, btg_vec3 tip, btg_vec3 axis, uint32_t order, bool is_pose,
                     const btg_verify_place *place) {
    btg_step *s = &v->steps[v->step_count];
    v->is_pose[v->step_count++] = is_pose;
    *s = (btg_step){.axis = axis, .order = order, .place = *place};
    s->centre = vec_mad(tip, axis, v->cutter.minor);
    s->place.at = tip;
    if (v->step_count == BTG_STEPS_MAX) flush(v);
}

static btg_verify_place place_of(const btg_verify_pose *pose, uint64_t position) {
    return (btg_verify_place){
        .position = position, .line = pose->line, .pass = pose->pass, .point = pose->point};
}

static bool clear_of_stock(const btg_verify *v, const btg_verify_pose *pose) {
    btg_step s = {.axis = pose->axis, .centre = vec_mad(pose->tip, pose->axis, v->cutter.minor)};
    return lowest(v, &s) >= v->field.top;
}

static void add_motion(btg_verify *v, const btg_verify_pose *to, const btg_verify_place *place) {
    const btg_verify_pose *from = &v->last;
    /* Between two poses the tool leans no more than at one of them: it stays as high. */
    if (clear_of_stock(v, from) && clear_of_stock(v, to)) return;
    btg_vec3 way = vec_sub(to->tip, from->tip);
    double angle = atan2(vec_norm(vec_cross(from->axis, to->axis)), vec_dot(from->axis, to->axis));
    double length = vec_norm(way);
    double error = v->def.sweep_error_mm - v->def.pose_error_mm;
    uint32_t n = btg_stock_steps(&v->cutter, length, angle, error);
    v->result.length_mm += length;
    for (uint32_t i = 1; i < n; i++) {
        double t = (double)i / n;
        uint32_t order = 2 * POSE_ORDERS + 1 - twos(i, POSE_ORDERS);
        add_step(v, vec_mad(from->tip, way, t), vec_turned(from->axis, to->axis, t), order, false,
                 2 * i < n ? &v->last_place : place);
    }
}

btg_status btg_verify_add(btg_verify *v, const btg_verify_pose *pose) {
    if (!v || !pose || !vec_finite(pose->tip) || !vec_finite(pose->axis)) return BTG_ERROR_ARGUMENT;
    if (fabs(vec_norm(pose->axis) - 1) > UNIT_TOLERANCE || pose->axis.z < AXIS_Z_MIN)
        return BTG_ERROR_ARGUMENT;
    btg_verify_pose p = *pose;
    p.axis = vec_unit(p.axis);
    btg_verify_place place = place_of(&p, v->result.positions + 1);
    if (p.link && v->placed) add_motion(v, &p, &place);
    if (!p.between) v->result.positions++;
    v->poses++;
    add_step(v, p.tip, p.axis, POSE_ORDERS - twos(v->poses, POSE_ORDERS), !p.between, &place);
    v->placed = true;
    v->last_place = place;
    v->last = p;
    return BTG_OK;
}

btg_status btg_verify_end(btg_verify *v, btg_verify_result *result) {
    if (!v || !result) return BTG_ERROR_ARGUMENT;
    flush(v);
    btg_verify_result *r = &v->result;
    for (uint32_t i = 0; i < v->bands; i++) {
        if (!(v->band[i].gouge > r->max_gouge_mm)) continue;
        r->max_gouge_mm = v->band[i].gouge;
        r->gouge = v->band[i].place;
    }
    btg_result_of_field(&v->field, &v->def, r);
    if (v->def.prove)
        r->motion_bound_mm += v->def.sweep_error_mm;
    else
        r->motion_bound_mm = r->position_bound_mm = NAN;
    *result = *r;
    return BTG_OK;
}

uint32_t btg_verify_threads(const btg_verify *v) {
    return v->threads;
}

btg_verify_map btg_verify_get_map(const btg_verify *v) {
    const btg_field *f = &v->field;
    return (btg_verify_map){f->width, f->height, f->x,        f->y,      f->cell,
                            f->top,   f->part_z, f->normal_z, f->stock_z};
}

double btg_verify_deviation(const btg_verify_map *map, size_t i) {
    if (map->part_z_mm[i] == -INFINITY) return NAN;
    return (map->stock_z_mm[i] - map->part_z_mm[i]) * (double)map->normal_z[i];
}
