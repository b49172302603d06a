/* Bounds of a block of pieces (core/block.c) against dense samples: points by the Bezier net,
 * distances by their definition. */
#include "check.h"
#include "core/cell.h"
#include "hard_parts.h"

#define ROUNDS 600
#define LEVELS 7
#define GRID   25
#define POSES  12
/* Rounding of the samples themselves, part of the coordinates' size. */
#define ROUNDING 1e-13
/* Of small pieces near the tool this many are bounded that well. */
#define SMALL      0.1  /* of the corner radius */
#define WASTE      0.02 /* of the piece's radius */
#define WELL_SHARE 0.9

typedef struct sampled {
    btg_block block;
    btg_vec3 point[BTG_BLOCK][GRID * GRID];
    double size; /* largest coordinate */
} sampled;

static long pieces, small, well, failed;

static double side(int i) {
    return 2.0 * i / (GRID - 1) - 1;
}

static btg_vec3 model_point(const btg_block *block, int k, double s, double t) {
    btg_vec3 p = btg_block_vector(&block->at.s, k);
    p = vec_mad(p, btg_block_vector(&block->at.su, k), s);
    p = vec_mad(p, btg_block_vector(&block->at.sv, k), t);
    p = vec_mad(p, btg_block_vector(&block->at.suu, k), 0.5 * s * s);
    p = vec_mad(p, btg_block_vector(&block->at.suv, k), s * t);
    return vec_mad(p, btg_block_vector(&block->at.svv, k), 0.5 * t * t);
}

/* The grid's place number i: on the square, or on the half of it where s + t <= 0. */
static void grid_place(const btg_block *block, int i, double *s, double *t) {
    *s = side(i / GRID);
    *t = side(i % GRID);
    if (block->triangles) *t = -1 + 0.5 * (*t + 1) * (1 - *s);
}

/* The quadratic, the flat part of it and the ball hold piece k. */
static void check_model(const sampled *of, int k) {
    const btg_block *b = &of->block;
    double slack = ROUNDING * of->size, error = 0, bend = 0, radius = 0;
    btg_vec3 c = btg_block_vector(&b->at.s, k), su = btg_block_vector(&b->at.su, k);
    btg_vec3 sv = btg_block_vector(&b->at.sv, k);
    for (int i = 0; i < GRID * GRID; i++) {
        btg_vec3 p = of->point[k][i];
        double s, t;
        grid_place(b, i, &s, &t);
        error = max2(error, vec_norm(vec_sub(p, model_point(b, k, s, t))));
        bend = max2(bend, vec_norm(vec_sub(p, vec_mad(vec_mad(c, su, s), sv, t))));
        radius = max2(radius, vec_norm(vec_sub(p, c)));
    }
    CHECK(error <= b->error[k] + slack);
    CHECK(bend <= b->bend[k] + slack);
    CHECK(radius <= b->radius[k] + slack);
}

static void sample(const btg_part *part, sampled *of) {
    const btg_block *b = &of->block;
    of->size = part->scale;
    for (int k = 0; k < (int)b->count; k++) {
        const btg_patch *patch = &part->patches[b->whole[k / 4].item];
        for (int i = 0; i < GRID * GRID; i++) {
            double u = b->u[k] + side(i / GRID) * b->hu[k], v = b->v[k] + side(i % GRID) * b->hv[k];
            of->point[k][i] = btg_patch_point(patch, u, v);
        }
        check_model(of, k);
    }
}

/* Distance to the round element: ring or disc, rounded; a cylinder above it. */
static double distance(const btg_tool_element *e, const btg_placement *at, btg_vec3 p,
                       double *height) {
    btg_vec3 d = vec_sub(p, at->centre);
    double r = vec_norm(vec_cross(d, at->axis)), x = r - e->ring_radius_mm;
    *height = vec_dot(d, at->axis);
    if (!e->hollow && x < 0) x = 0;
    return hypot(x, *height < 0 ? *height : 0) - e->corner_radius_mm;
}

/* Anywhere near, or touching a point of the block at any lean, outside or inside the ring, up to a
 * gap of either sign. */
static btg_placement random_pose(rng *r, const btg_tool_element *e, const sampled *of,
                                 bool tangent) {
    int k = rng_pick(r, (int)of->block.count);
    btg_vec3 p = of->point[k][rng_pick(r, GRID * GRID)];
    double ring = e->ring_radius_mm, corner = e->corner_radius_mm;
    btg_vec3 n = vec_unit(
        vec_cross(btg_block_vector(&of->block.at.su, k), btg_block_vector(&of->block.at.sv, k)));
    btg_placement at = {p, hard_unit(r), false};
    if (!tangent || vec_norm2(n) < 0.5) {
        at.centre = vec_mad(p, hard_unit(r), rng_range(r, 0, 2) * (ring + corner));
        return at;
    }
    if (rng_pick(r, 2)) n = vec_scale(n, -1);
    if (vec_dot(n, at.axis) < 0) at.axis = vec_scale(at.axis, -1);
    btg_vec3 out = vec_unit(vec_mad(vec_scale(n, -1), at.axis, vec_dot(n, at.axis)));
    if (e->hollow && rng_pick(r, 3) == 0) out = vec_scale(out, -1);
    double gap = corner * pow(10, rng_range(r, -7, -0.5)) * (rng_pick(r, 2) ? 1 : -1);
    at.centre = vec_mad(vec_mad(p, n, corner + gap), out, -ring);
    return at;
}

static void fail(const sampled *of, int k, const btg_tool_element *e, const btg_placement *at,
                 const btg_block_bound *bound, double least, double top) {
    const btg_piece *w = &of->block.whole[k / 4];
    if (failed++ > 5) return;
    fprintf(stderr, "piece u %a v %a hu %a hv %a cut %d, quarter %d, ring %g corner %g hollow %d\n",
            w->u, w->v, w->hu, w->hv, (int)w->cut, k, e->ring_radius_mm, e->corner_radius_mm,
            e->hollow);
    fprintf(stderr, "  centre %a %a %a axis %a %a %a\n", at->centre.x, at->centre.y, at->centre.z,
            at->axis.x, at->axis.y, at->axis.z);
    fprintf(stderr, "  low %.17g least sample %.17g top %.17g highest %.17g radius %g error %g\n",
            bound->low[k], least, bound->top[k], top, of->block.radius[k], of->block.error[k]);
}

static void check_pose(rng *r, const sampled *of, const btg_tool_element *e, bool tangent) {
    btg_placement at = random_pose(r, e, of, tangent);
    btg_block_bound bound;
    bool always = rng_pick(r, 4) > 0;
    btg_block_bounds(&of->block, e, &at, always ? INFINITY : -1e-7, &bound);
    double slack = ROUNDING * (of->size + vec_norm(at.centre) + e->ring_radius_mm);
    const double low_of_all = always ? INFINITY : -1e-7;
    for (int k = 0; k < (int)of->block.count; k++) {
        double least = INFINITY, top = -INFINITY, height, radius = of->block.radius[k];
        for (int i = 0; i < GRID * GRID; i++) {
            least = min2(least, distance(e, &at, of->point[k][i], &height));
            top = max2(top, height);
        }
        bool holds = bound.low[k] <= least + slack && bound.top[k] >= top - slack;
        if (!holds) fail(of, k, e, &at, &bound, least, top);
        CHECK(bound.low[k] <= least + slack);
        CHECK(bound.top[k] >= top - slack);
        CHECK((bound.deep >> k & 1) == (bound.low[k] < low_of_all));
        CHECK((bound.high >> k & 1) == (bound.top[k] > 0));
        pieces++;
        double corner = e->corner_radius_mm;
        if (!always || radius > SMALL * corner || fabs(least) > 2 * radius) continue;
        if (of->block.error[k] > 0.25 * WASTE * radius) continue; /* it cannot but lose that */
        small++;
        well += bound.low[k] >= least - WASTE * radius;
    }
}

static void check_patch(rng *r, int round) {
    model m = {0};
    double size = rng_pick(r, 2) ? 20 : 100;
    hard_add_patch(&m, r, (hard_patch)(round % HARD_PATCHES), size);
    hard_add_patch(&m, r, (hard_patch)rng_pick(r, HARD_PATCHES), size);
    btg_part *part = model_part(&m);
    model_free(&m);
    static sampled of;
    btg_piece piece[2];
    const btg_piece *both[2] = {&piece[0], &piece[1]};
    btg_piece_root(part, 0, &piece[0]);
    btg_piece_root(part, (uint32_t)rng_pick(r, (int)part->patch_count), &piece[1]);
    for (int level = 0; level < LEVELS; level++) {
        btg_block_make(part, both, rng_pick(r, 4) > 0 ? 2 : 1, &of.block);
        sample(part, &of);
        for (int i = 0; i < POSES; i++) {
            btg_tool tool = hard_tool(rng_pick(r, HARD_CUTTERS));
            check_pose(r, &of, &tool.element[0], i % 3 > 0);
        }
        btg_block_quarter(part, &of.block, rng_pick(r, 4), &piece[0]);
        if (of.block.count > 4) btg_block_quarter(part, &of.block, 4 + rng_pick(r, 4), &piece[1]);
    }
    btg_part_destroy(part);
}

static void sample_triangles(const btg_part *part, sampled *of) {
    of->size = part->scale;
    for (int k = 0; k < (int)of->block.count; k++) {
        btg_vec3 c[3];
        btg_triangle_corners(part, of->block.item[k] - part->patch_count, c);
        for (int i = 0; i < GRID * GRID; i++) {
            double s, t;
            grid_place(&of->block, i, &s, &t);
            btg_place at = btg_block_place(&of->block, k, s, t);
            btg_vec3 p = vec_mad(c[0], vec_sub(c[1], c[0]), at.u);
            of->point[k][i] = vec_mad(p, vec_sub(c[2], c[0]), at.v);
        }
        check_model(of, k);
    }
}

/* The piece by itself is the same as in its block. */
static void check_triangle_piece(const btg_part *part, const btg_block *block, int k,
                                 const btg_piece *piece) {
    btg_cell cell;
    btg_cell_of_triangle(part, piece, &cell);
    btg_vec3 a = btg_block_vector(&block->at.su, k), b = btg_block_vector(&block->at.sv, k);
    btg_vec3 middle = vec_mad(btg_block_vector(&block->at.s, k), vec_add(a, b), -1.0 / 3);
    double slack = ROUNDING * part->scale;
    CHECK(vec_norm(vec_sub(middle, cell.centre)) <= slack);
    CHECK(vec_norm(vec_sub(vec_scale(a, 2), cell.a)) <= slack);
    CHECK(vec_norm(vec_sub(vec_scale(b, 2), cell.b)) <= slack);
}

/* Whole triangles, then pieces of two of them. */
static void check_triangles(rng *r, int round) {
    model m = {0};
    hard_add_mesh(&m, r, (hard_mesh)(round % HARD_MESHES), 40);
    btg_part *part = model_part(&m);
    model_free(&m);
    static sampled of;
    uint32_t triangle[BTG_BLOCK], count = 1 + (uint32_t)rng_pick(r, BTG_BLOCK);
    for (int k = 0; k < BTG_BLOCK; k++)
        triangle[k] = (uint32_t)rng_pick(r, (int)part->triangle_count);
    btg_block_of_triangles(part, triangle, count, &of.block);
    for (int level = 0; level < 4; level++) {
        btg_piece piece[2];
        const btg_piece *both[2] = {&piece[0], &piece[1]};
        sample_triangles(part, &of);
        for (int i = 0; i < POSES; i++) {
            btg_tool tool = hard_tool(rng_pick(r, HARD_CUTTERS));
            check_pose(r, &of, &tool.element[0], i % 3 > 0);
        }
        for (int p = 0; p < 2; p++) {
            int k = rng_pick(r, (int)of.block.count);
            btg_block_quarter(part, &of.block, k, &piece[p]);
            check_triangle_piece(part, &of.block, k, &piece[p]);
        }
        btg_block_make(part, both, rng_pick(r, 4) > 0 ? 2 : 1, &of.block);
    }
    btg_part_destroy(part);
}

int main(void) {
    int rounds = hard_rounds(ROUNDS);
    for (int i = 0; i < rounds; i++) {
        rng r = rng_of(1, "block", (uint64_t)i);
        check_patch(&r, i);
        if (i % 4 == 0) check_triangles(&r, i / 4);
    }
    printf(
        "%ld bounds; of %ld small pieces near the tool %.1f %% lose less than %g of the radius\n",
        pieces, small, 100.0 * (double)well / (double)small, WASTE);

    CHECK((double)well >= WELL_SHARE * (double)small);
    return check_result();
}
