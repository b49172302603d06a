/* Pieces side by side: how they are cut and measured, and what is asked of all of them. */
#include "core/cell.h"

/* Sides whose ratio is more than this are cut by four along the longer one. */
#define LONG_SIDE 2.8

/* The next float up: bounds must not shrink. */
static float round_up(double x) {
    return (float)(x * (1 + 1e-7)) + BTG_THIRD_MIN;
}

void btg_piece_root(const btg_part *part, uint32_t item, btg_piece *piece) {
    const btg_patch *patch = &part->patches[item];
    *piece = (btg_piece){0.5, 0.5, 0.5, 0.5, {0}, item, patch->quarter, (btg_cut)patch->cut};
    for (int k = 0; k < 4; k++)
        piece->third[k] = round_up(0.125 * patch->third[k]); /* cubes of half sides */
}

/* By how much halving shrinks third derivatives, by cut. */
static const float third_scale[3][4] = {{0.125f, 0.125f, 0.125f, 0.125f},
                                        {1.0f / 64, 1.0f / 16, 0.25f, 1},
                                        {1, 0.25f, 1.0f / 16, 1.0f / 64}};

/* Bounds of the quarters' third derivatives, in units of their half sides: until they are measured
 * they wait where the last thing that is made of them will stand. */
static void set_thirds(const btg_part *part, const btg_piece *piece, int first, btg_block *block) {
    double *out[4] = {block->side_u2, block->bend, block->side_v2, block->radius};
    const float *scale = third_scale[piece->cut];
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            out[i][first + k] =
                (double)(piece->quarters ? part->quarters[piece->quarters].third[i][k]
                                         : scale[i] * piece->third[i]);
}

/* Parameters of the quarters, from number `first` on. */
static void place_quarters(const btg_piece *piece, int first, btg_block *block) {
    static const double side[3][2][4] = {{{-0.5, 0.5, -0.5, 0.5}, {-0.5, -0.5, 0.5, 0.5}},
                                         {{-0.75, -0.25, 0.25, 0.75}, {0, 0, 0, 0}},
                                         {{0, 0, 0, 0}, {-0.75, -0.25, 0.25, 0.75}}};
    static const double half[3][2] = {{0.5, 0.5}, {0.25, 1}, {1, 0.25}};
    const double *su = side[piece->cut][0], *sv = side[piece->cut][1];
    double hu = half[piece->cut][0] * piece->hu, hv = half[piece->cut][1] * piece->hv;
    for (int k = 0; k < 4; k++) {
        block->u[first + k] = piece->u + su[k] * piece->hu;
        block->v[first + k] = piece->v + sv[k] * piece->hv;
        block->hu[first + k] = hu;
        block->hv[first + k] = hv;
    }
}

/* By the squares of its sides. */
static btg_cut cut_of(double u2, double v2) {
    if (u2 > LONG_SIDE * LONG_SIDE * v2) return BTG_CUT_U;
    return v2 > LONG_SIDE * LONG_SIDE * u2 ? BTG_CUT_V : BTG_CUT_BOTH;
}

btg_cut btg_piece_cut(const btg_part *part, const btg_piece *piece) {
    btg_surface_point s;
    btg_patch_evaluate(&part->patches[piece->item], piece->u, piece->v, &s);
    double hu = piece->hu, hv = piece->hv;
    double uu = 0.5 * hu * vec_norm(s.suu), vv = 0.5 * hv * vec_norm(s.svv);
    return cut_of(hu * hu * (vec_norm2(s.su) + uu * uu), hv * hv * (vec_norm2(s.sv) + vv * vv));
}

static double turned(const btg_block *block, int k) {
    return block->turned >> k & 1 ? -1 : 1;
}

btg_place btg_block_place(const btg_block *block, int k, double a, double b) {
    double way = turned(block, k);
    return (btg_place){block->item[k], block->u[k] + way * a * block->hu[k],
                       block->v[k] + way * b * block->hv[k]};
}

void btg_block_quarter(const btg_part *part, const btg_block *block, int k, btg_piece *piece) {
    if (block->triangles) {
        double side = 2 * turned(block, k) * block->hu[k];
        *piece = (btg_piece){block->u[k] - 0.5 * side, block->v[k] - 0.5 * side, side, side,
                             .item = block->item[k]};
        return;
    }
    const btg_piece *whole = &block->whole[k / 4];
    piece->u = block->u[k];
    piece->v = block->v[k];
    piece->hu = block->hu[k];
    piece->hv = block->hv[k];
    piece->item = whole->item;
    piece->quarters = 0;
    if (whole->quarters) {
        const btg_quarters *stored = &part->quarters[whole->quarters];
        for (int i = 0; i < 4; i++)
            piece->third[i] = stored->third[i][k % 4];
        piece->quarters = stored->child[k % 4];
        piece->cut = (btg_cut)stored->cut[k % 4];
    } else {
        for (int i = 0; i < 4; i++) {
            float third = third_scale[whole->cut][i] * whole->third[i];
            piece->third[i] = third > BTG_THIRD_MIN ? third : BTG_THIRD_MIN;
        }
    }
    if (!piece->quarters) piece->cut = cut_of(block->side_u2[k], block->side_v2[k]);
}

static ALWAYS_INLINE lanes3 scale(lanes3_memory *v, int i, lanes by) {
    lanes3 scaled = lanes3_scale(lanes3_load(v, i), by);
    lanes3_store(v, i, scaled);
    return scaled;
}

/* Derivatives from number i on in units of half sides, and how far the pieces reach; error holds
 * the rounding of their points. */
static ALWAYS_INLINE void measure(int i, btg_block *block) {
    lanes hu = lanes_load(block->hu + i), hv = lanes_load(block->hv + i);
    lanes uu2 = lanes3_norm2(scale(&block->at.suu, i, lanes_mul(hu, hu)));
    lanes uv2 = lanes3_norm2(scale(&block->at.suv, i, lanes_mul(hu, hv)));
    lanes vv2 = lanes3_norm2(scale(&block->at.svv, i, lanes_mul(hv, hv)));
    lanes uu = lanes_sqrt(uu2), uv = lanes_sqrt(uv2), vv = lanes_sqrt(vv2);
    lanes3 a = scale(&block->at.su, i, hu), b = scale(&block->at.sv, i, hv);
    lanes over = lanes_all(1 + 1e-12), half = lanes_all(0.5), three = lanes_all(3);
    lanes sixth = lanes_all((1 + 1e-12) / 6);
    lanes uuu = lanes_load(block->side_u2 + i), uuv = lanes_load(block->bend + i);
    lanes uvv = lanes_load(block->side_v2 + i), vvv = lanes_load(block->radius + i);
    lanes rounding = lanes_load(block->error + i);
    lanes third_u = lanes_mad(uuu, three, uuv), third_v = lanes_mad(vvv, three, uvv);
    third_u = lanes_mul(third_u, sixth);
    third_v = lanes_mul(third_v, sixth);
    lanes error = lanes_add(lanes_add(third_u, third_v), rounding);
    lanes bend = lanes_mad(error, half, lanes_add(uu, vv));
    bend = lanes_mul(lanes_add(bend, uv), over);
    lanes aa = lanes3_dot(a, a), bb = lanes3_dot(b, b), ab = lanes_abs(lanes3_dot(a, b));
    lanes diagonal = lanes_sqrt(lanes_add(lanes_add(aa, bb), lanes_add(ab, ab)));
    lanes quarter = lanes_all(0.25);
    lanes_store(block->side_u2 + i, lanes_mad(lanes_mad(aa, third_u, third_u), quarter, uu2));
    lanes_store(block->side_v2 + i, lanes_mad(lanes_mad(bb, third_v, third_v), quarter, vv2));
    lanes_store(block->error + i, error);
    lanes_store(block->bend + i, bend);
    lanes_store(block->radius + i, lanes_mad(bend, diagonal, over));
}

static BTG_APART void measure_patches(btg_block *block) {
    for (uint32_t i = 0; i < block->count; i += BTG_LANES)
        measure((int)i, block);
}

/* Lanes that hold no piece hold numbers all the same. */
static uint32_t lanes_of(uint32_t count) {
    return (count + BTG_LANES - 1) / BTG_LANES * BTG_LANES;
}

/* The parameters of a piece of a triangle: its corner at (u, v), its sides along u and v. */
static void place_triangle(const btg_piece *piece, int k, btg_block *block) {
    double half = 0.5 * piece->hu;
    block->item[k] = piece->item;
    block->u[k] = piece->u + half;
    block->v[k] = piece->v + half;
    block->hu[k] = block->hv[k] = fabs(half);
    block->side_u2[k] = half;
    if (half < 0) block->turned |= 1u << k;
}

/* Pieces from number i on, the corners of their triangles standing for s, su and sv. */
static ALWAYS_INLINE void measure_triangles(double rounding, int i, btg_block *block) {
    lanes3 c = lanes3_load(&block->at.s, i), p = lanes3_load(&block->at.su, i);
    lanes3 q = lanes3_load(&block->at.sv, i);
    lanes u = lanes_load(block->u + i), v = lanes_load(block->v + i), all = lanes_all(rounding);
    lanes half = lanes_load(block->side_u2 + i), zero = lanes_all(0);
    lanes3 a = {lanes_sub(p.x, c.x), lanes_sub(p.y, c.y), lanes_sub(p.z, c.z)};
    lanes3 b = {lanes_sub(q.x, c.x), lanes_sub(q.y, c.y), lanes_sub(q.z, c.z)};
    c = (lanes3){lanes_mad(lanes_mad(c.x, a.x, u), b.x, v),
                 lanes_mad(lanes_mad(c.y, a.y, u), b.y, v),
                 lanes_mad(lanes_mad(c.z, a.z, u), b.z, v)};
    a = lanes3_scale(a, half);
    b = lanes3_scale(b, half);
    lanes squares = lanes_add(lanes3_norm2(a), lanes3_norm2(b)), ab = lanes_abs(lanes3_dot(a, b));
    lanes radius = lanes_sqrt(lanes_add(squares, lanes_add(ab, ab)));
    lanes3_store(&block->at.s, i, c);
    lanes3_store(&block->at.su, i, a);
    lanes3_store(&block->at.sv, i, b);
    lanes3 none = {zero, zero, zero};
    lanes3_store(&block->at.suu, i, none);
    lanes3_store(&block->at.suv, i, none);
    lanes3_store(&block->at.svv, i, none);
    lanes_store(block->error + i, all);
    lanes_store(block->bend + i, all);
    lanes_store(block->radius + i, lanes_add(radius, all));
}

/* The triangles of all lanes: their corners are fetched side by side, from far and wide. */
static void fetch_triangles(const btg_part *part, btg_block *block) {
    lanes3_memory *to[3] = {&block->at.s, &block->at.su, &block->at.sv};
    uint32_t count = lanes_of(block->count);
#if defined(__GNUC__)
    for (uint32_t k = 0; k < count; k++)
        for (int c = 0; c < 3; c++)
            __builtin_prefetch(
                &part->vertices[part->triangles[block->item[k] - part->patch_count][c]]);
#endif
    for (uint32_t k = 0; k < count; k++) {
        btg_vec3 corner[3];
        btg_triangle_corners(part, block->item[k] - part->patch_count, corner);
        for (int c = 0; c < 3; c++) {
            to[c]->at[0][k] = corner[c].x;
            to[c]->at[1][k] = corner[c].y;
            to[c]->at[2][k] = corner[c].z;
        }
    }
    for (uint32_t i = 0; i < count; i += BTG_LANES)
        measure_triangles(1e-14 * part->scale, (int)i, block);
}

static void begin_triangles(uint32_t count, btg_block *block) {
    block->count = count;
    block->triangles = true;
    block->turned = 0;
}

void btg_block_of_triangles(const btg_part *part, const uint32_t *triangles, uint32_t count,
                            btg_block *block) {
    begin_triangles(count, block);
    for (uint32_t k = 0; k < lanes_of(count); k++) {
        btg_piece whole;
        btg_triangle_root(part->patch_count + triangles[k < count ? k : 0], &whole);
        place_triangle(&whole, (int)k, block);
    }
    fetch_triangles(part, block);
}

static BTG_APART void cut_triangles(const btg_part *part, const btg_piece *const piece[],
                                    uint32_t pieces, btg_block *block) {
    btg_piece quarter[4];
    begin_triangles(4 * pieces, block);
    for (uint32_t k = 0; k < lanes_of(4 * pieces); k++) {
        if (k % 4 == 0) btg_triangle_cut(piece[k < 4 * pieces ? k / 4 : 0], quarter);
        place_triangle(&quarter[k % 4], (int)k, block);
    }
    fetch_triangles(part, block);
}

static BTG_APART void cut_patches(const btg_part *part, const btg_piece *const piece[],
                                  uint32_t pieces, btg_block *block) {
    const btg_patch *patch[BTG_PIECES];
    block->count = 4 * pieces;
    block->triangles = false;
    block->turned = 0;
    for (uint32_t p = 0; p < lanes_of(4 * pieces) / 4; p++) { /* the first stands for none */
        const btg_piece *whole = piece[p < pieces ? p : 0];
        int first = 4 * (int)p;
        patch[p] = &part->patches[whole->item];
        block->whole[p] = *whole;
        place_quarters(whole, first, block);
        set_thirds(part, whole, first, block);
        for (int k = 0; k < 4; k++) {
            block->item[first + k] = whole->item;
            block->error[first + k] = patch[p]->rounding;
        }
    }
    btg_patch_evaluate_block(patch, (int)pieces, block->u, block->v, &block->at);
    measure_patches(block);
}

void btg_block_make(const btg_part *part, const btg_piece *const piece[], uint32_t pieces,
                    btg_block *block) {
    if (piece[0]->item < part->patch_count)
        cut_patches(part, piece, pieces, block);
    else
        cut_triangles(part, piece, pieces, block);
}

static void widen(const float from[3][4], int first, lanes3_memory *to) {
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 4; k++)
            to->at[c][first + k] = (double)from[c][k];
}

void btg_block_of_nodes(const btg_node *const node[], uint32_t nodes, btg_block *block) {
    block->count = 4 * nodes;
    block->triangles = false;
    for (uint32_t p = 0; p < lanes_of(4 * nodes) / 4; p++) {
        const btg_node *n = node[p < nodes ? p : 0];
        int first = 4 * (int)p;
        widen(n->centre, first, &block->at.s);
        widen(n->a, first, &block->at.su);
        widen(n->b, first, &block->at.sv);
        widen(n->uu, first, &block->at.suu);
        widen(n->uv, first, &block->at.suv);
        widen(n->vv, first, &block->at.svv);
        for (int k = 0; k < 4; k++) {
            block->error[first + k] = (double)n->error[k];
            block->bend[first + k] = (double)n->bend[k];
            block->radius[first + k] = (double)n->radius[k];
        }
    }
}

/* ---- bits ---------------------------------------------------------------------------------- */

unsigned btg_block_small(const btg_block *block, double radius) {
    unsigned larger = 0;
    for (uint32_t i = 0; i < block->count; i += BTG_LANES)
        larger |= lanes_less(lanes_all(radius), lanes_load(block->radius + i)) << i;
    return btg_block_bits(block) & ~larger;
}

unsigned btg_block_near(const btg_block *block, btg_vec3 point, double gap) {
    unsigned far = 0;
    for (uint32_t i = 0; i < block->count; i += BTG_LANES) {
        lanes3 d = lanes3_load(&block->at.s, (int)i);
        d = (lanes3){lanes_sub(d.x, lanes_all(point.x)), lanes_sub(d.y, lanes_all(point.y)),
                     lanes_sub(d.z, lanes_all(point.z))};
        lanes reach = lanes_add(lanes_load(block->radius + i), lanes_all(gap));
        far |= lanes_less(lanes_mul(reach, reach), lanes3_norm2(d)) << i;
    }
    return btg_block_bits(block) & ~far;
}

unsigned btg_block_about(const btg_block *block, btg_place about, double speed_u, double speed_v,
                         double reach) {
    unsigned bits = 0, of = 0;
    for (uint32_t i = 0; i < block->count; i += BTG_LANES) {
        lanes u = lanes_abs(lanes_sub(lanes_load(block->u + i), lanes_all(about.u)));
        lanes v = lanes_abs(lanes_sub(lanes_load(block->v + i), lanes_all(about.v)));
        u = lanes_mul(lanes_add(u, lanes_load(block->hu + i)), lanes_all(speed_u));
        v = lanes_mul(lanes_add(v, lanes_load(block->hv + i)), lanes_all(speed_v));
        bits |= lanes_less(lanes_mad(lanes_mul(u, u), v, v), lanes_all(reach * reach)) << i;
    }
    for (uint32_t k = 0; k < block->count; k++)
        of |= (unsigned)(block->item[k] == about.item) << k;
    return bits & of;
}
