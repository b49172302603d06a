/* The search tree holds the part: every point of a piece or triangle lies within the thickness of
 * the sheets of all its ancestors (core/sheet.c, core/tree_nodes.c), nothing is left out or told
 * twice, and the depths that bound the stack are right. */
#include "check.h"
#include "core/block.h"
#include "hard_parts.h"

#include <stdlib.h>

#define ROUNDS     160
#define DEPTH_MAX  64
#define PIECE_GRID 4 /* samples of a piece, either way */
#define STARTS     5 /* of the descent to the nearest point of a sheet, either way */
#define STEPS      40
/* Rounding of the test's own points, part of the coordinates' size. */
#define ROUNDING 2e-15

typedef struct sheet {
    btg_vec3 c, a, b, uu, uv, vv;
    double error, radius;
} sheet;

typedef struct walk {
    const btg_part *part;
    sheet above[DEPTH_MAX];
    uint32_t depth, deepest;
    uint32_t *node_seen, *piece_seen, *order_seen;
    long points;
} walk;

static btg_vec3 vector_of(const float from[3][4], int k) {
    return vec((double)from[0][k], (double)from[1][k], (double)from[2][k]);
}

static sheet sheet_of(const btg_node *node, int k) {
    return (sheet){vector_of(node->centre, k), vector_of(node->a, k),  vector_of(node->b, k),
                   vector_of(node->uu, k),     vector_of(node->uv, k), vector_of(node->vv, k),
                   (double)node->error[k],     (double)node->radius[k]};
}

static btg_vec3 arm_to(const sheet *q, double s, double t, btg_vec3 p) {
    btg_vec3 at = vec_mad(vec_mad(vec_sub(q->c, p), q->a, s), q->b, t);
    at = vec_mad(vec_mad(at, q->uu, 0.5 * s * s), q->uv, s * t);
    return vec_mad(at, q->vv, 0.5 * t * t);
}

static double clamp(double x) {
    return x < -1 ? -1 : x > 1 ? 1 : x;
}

/* Distance from p to some point of the sheet, after a damped Gauss-Newton descent over the
 * square. */
static double descend(const sheet *q, double s, double t, btg_vec3 p, double enough) {
    double best = vec_norm(arm_to(q, s, t, p)), damp = 1e-9;
    for (int i = 0; i < STEPS && best > enough; i++) {
        btg_vec3 d = arm_to(q, s, t, p);
        btg_vec3 ds = vec_mad(vec_mad(q->a, q->uu, s), q->uv, t);
        btg_vec3 dt = vec_mad(vec_mad(q->b, q->uv, s), q->vv, t);
        double gs = vec_dot(d, ds), gt = vec_dot(d, dt);
        double size = vec_norm2(ds) + vec_norm2(dt) + 1e-300, more = damp * size;
        double hss = vec_norm2(ds) + more, htt = vec_norm2(dt) + more, hst = vec_dot(ds, dt);
        bool hold_s = (s >= 1 && gs < 0) || (s <= -1 && gs > 0);
        bool hold_t = (t >= 1 && gt < 0) || (t <= -1 && gt > 0);
        double det = hss * htt - hst * hst, x, y;
        if (hold_s || hold_t || !(det > 0)) {
            x = hold_s ? 0 : -gs / hss;
            y = hold_t ? 0 : -gt / htt;
        } else {
            x = (hst * gt - htt * gs) / det;
            y = (hst * gs - hss * gt) / det;
        }
        x = clamp(s + x);
        y = clamp(t + y);
        double next = vec_norm(arm_to(q, x, y, p));
        if (next < best) {
            best = next;
            s = x;
            t = y;
            damp = max2(0.1 * damp, 1e-12);
        } else {
            damp = damp * 10 + 1e-6;
        }
    }
    return best;
}

static double distance(const sheet *q, btg_vec3 p, double enough) {
    double best = descend(q, 0, 0, p, enough);
    for (int i = 0; i < STARTS * STARTS && best > enough; i++) {
        double s = 2.0 * (i % STARTS) / (STARTS - 1) - 1, t = 2.0 * (i / STARTS) / (STARTS - 1) - 1;
        best = min2(best, descend(q, s, t, p, enough));
    }
    return best;
}

static void check_point(walk *w, btg_vec3 p) {
    double slack = ROUNDING * w->part->scale;
    w->points++;
    for (uint32_t i = 0; i < w->depth; i++) {
        const sheet *q = &w->above[i];
        double d = distance(q, p, q->error + slack);
        if (d > q->error + slack)
            fprintf(stderr, "level %u of %u: point %a %a %a, %.6g away from a sheet %.6g thick\n",
                    i, w->depth, p.x, p.y, p.z, d, q->error);
        CHECK(d <= q->error + slack);
        CHECK(vec_norm(vec_sub(p, q->c)) <= q->radius + slack);
    }
}

static void check_piece(walk *w, uint32_t index) {
    const btg_piece *piece = &w->part->pieces[index];
    w->piece_seen[index]++;
    for (int i = 0; i <= PIECE_GRID; i++)
        for (int k = 0; k <= PIECE_GRID; k++) {
            double u = piece->u + (2.0 * i / PIECE_GRID - 1) * piece->hu;
            double v = piece->v + (2.0 * k / PIECE_GRID - 1) * piece->hv;
            check_point(w, btg_patch_point(&w->part->patches[piece->item], u, v));
        }
}

static void check_triangle(walk *w, uint32_t at, rng *r) {
    btg_vec3 c[3];
    w->order_seen[at]++;
    btg_triangle_corners(w->part, w->part->order[at], c);
    for (int k = 0; k < 3; k++) {
        check_point(w, c[k]);
        check_point(w, vec_scale(vec_add(c[k], c[(k + 1) % 3]), 0.5));
    }
    for (int i = 0; i < 3; i++) {
        double u = rng_range(r, 0, 1), v = rng_range(r, 0, 1 - u);
        check_point(w, vec_mad(vec_mad(c[0], vec_sub(c[1], c[0]), u), vec_sub(c[2], c[0]), v));
    }
}

static void check_node(walk *w, uint32_t index, bool triangles, rng *r) {
    const btg_node *node = &w->part->nodes[index];
    w->node_seen[index]++;
    CHECK(node->kind[0] != BTG_CHILD_NONE);
    for (int k = 0; k < 4 && w->depth < DEPTH_MAX; k++) {
        w->above[w->depth] = sheet_of(node, k);
        CHECK(isfinite(w->above[w->depth].error) && isfinite(w->above[w->depth].radius));
        if (node->kind[k] == BTG_CHILD_NONE) continue;
        if (++w->depth > w->deepest) w->deepest = w->depth;
        if (node->kind[k] == BTG_CHILD_NODE) {
            check_node(w, node->child[k], triangles, r);
        } else if (node->kind[k] == BTG_CHILD_PIECE) {
            CHECK(!triangles);
            check_piece(w, node->child[k]);
        } else {
            CHECK(triangles && node->kind[k] == BTG_CHILD_TRIANGLES);
            CHECK(node->count[k] >= 1 && node->count[k] <= BTG_LEAF_TRIANGLES);
            for (uint32_t i = 0; i < node->count[k]; i++)
                check_triangle(w, node->child[k] + i, r);
        }
        w->depth--;
    }
}

static void all_once(const uint32_t *seen, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        CHECK(seen[i] == 1);
}

/* Levels of stored quarters below one piece. */
static uint32_t quarters_depth(const btg_part *part, uint32_t at) {
    uint32_t most = 0;
    for (int k = 0; k < 4 && at; k++) {
        uint32_t below = quarters_depth(part, part->quarters[at].child[k]);
        if (below > most) most = below;
    }
    return at ? most + 1 : 0;
}

/* The pieces of each patch are all of it. */
static void check_area(const btg_part *part) {
    for (uint32_t i = 0; i < part->patch_count; i++) {
        double area = 0;
        for (uint32_t k = 0; k < part->piece_count; k++)
            if (part->pieces[k].item == i) area += 4 * part->pieces[k].hu * part->pieces[k].hv;
        CHECK_NEAR(area, 1, 1e-12);
        CHECK(quarters_depth(part, part->patches[i].quarter) <= part->quarters_depth);
    }
}

static long check_part(const btg_part *part, rng *r) {
    walk w = {.part = part};
    w.node_seen = calloc(part->node_count + 1, sizeof(uint32_t));
    w.piece_seen = calloc(part->piece_count + 1, sizeof(uint32_t));
    w.order_seen = calloc(part->triangle_count + 1, sizeof(uint32_t));
    CHECK((part->root[0] == BTG_NODE_NONE) == (part->piece_count == 0));
    CHECK((part->root[1] == BTG_NODE_NONE) == (part->triangle_count == 0));
    for (int i = 0; i < 2; i++)
        if (part->root[i] != BTG_NODE_NONE) check_node(&w, part->root[i], i == 1, r);
    CHECK(w.depth == 0 && w.deepest == part->node_depth);
    all_once(w.node_seen, part->node_count);
    all_once(w.piece_seen, part->piece_count);
    all_once(w.order_seen, part->triangle_count);
    uint32_t *named = calloc(part->triangle_count + 1, sizeof(uint32_t));
    for (uint32_t i = 0; i < part->triangle_count; i++)
        named[part->order[i]]++;
    all_once(named, part->triangle_count);
    check_area(part);
    free(w.node_seen);
    free(w.piece_seen);
    free(w.order_seen);
    free(named);
    return w.points;
}

int main(void) {
    int rounds = hard_rounds(ROUNDS);
    long points = 0;
    for (int i = 0; i < rounds; i++) {
        rng r = rng_of(2, "sheet", (uint64_t)i);
        model m = {0};
        double size = rng_pick(&r, 3) ? 60 : 1e-3;
        int patches = i % 3 == 1 ? 0 : 1 + rng_pick(&r, 4);
        for (int k = 0; k < patches; k++)
            hard_add_patch(&m, &r, (hard_patch)((i + k) % HARD_PATCHES), size);
        if (i % 3 > 0) hard_add_mesh(&m, &r, (hard_mesh)(i % HARD_MESHES), size);
        if (i % 4 == 3) { /* far from the origin, where floats are coarse */
            motion far = {rng_range(&r, -3, 3), 1, false, vec(3e4, -7e4, 1e4)};
            model_move(&m, &far);
        }
        btg_part *part = model_part(&m);
        model_free(&m);
        points += check_part(part, &r);
        btg_part_destroy(part);
    }
    printf("%ld points in all sheets above them\n", points);
    return check_result();
}
