/* Cells of the search: pieces of patches and triangles. */
#include "core/cell.h"

static void from_tile(const btg_part *part, uint32_t tile, btg_cell *cell) {
    const btg_tile *t = &part->tiles[tile];
    cell->centre = t->centre;
    cell->a = vec(t->a[0], t->a[1], t->a[2]);
    cell->b = vec(t->b[0], t->b[1], t->b[2]);
    cell->bend_uu = t->bend_uu;
    cell->bend_uv = t->bend_uv;
    cell->bend_vv = t->bend_vv;
    cell->tile = tile;
}

void btg_cell_root(const btg_part *part, uint32_t item, btg_cell *cell) {
    cell->item = item;
    if (item < part->patch_count) {
        cell->u = cell->v = cell->hu = cell->hv = 0.5;
        from_tile(part, part->patch_root[item], cell);
        return;
    }
    btg_vec3 corner[3];
    btg_triangle_corners(part, item - part->patch_count, corner);
    cell->u = cell->v = 0;
    cell->hu = cell->hv = 1;
    cell->a = vec_sub(corner[1], corner[0]);
    cell->b = vec_sub(corner[2], corner[0]);
    cell->centre = vec_mad(corner[0], vec_add(cell->a, cell->b), 1.0 / 3);
    cell->bend_uu = cell->bend_uv = cell->bend_vv = 0;
    cell->tile = BTG_CELL_MADE;
}

static void split_triangle(const btg_cell *cell, btg_cell child[4]) {
    btg_vec3 a = vec_scale(cell->a, 0.5), b = vec_scale(cell->b, 0.5);
    double h = 0.5 * cell->hu;
    for (int i = 0; i < 4; i++) {
        child[i] = *cell;
        child[i].a = a;
        child[i].b = b;
        child[i].hu = child[i].hv = h;
    }
    btg_vec3 third = vec_scale(vec_add(a, b), 1.0 / 3); /* centroids stand this far apart */
    child[0].centre = vec_sub(cell->centre, third);
    child[1].centre = vec_add(child[0].centre, a);
    child[2].centre = vec_add(child[0].centre, b);
    child[1].u += h;
    child[2].v += h;
    child[3].u += h; /* the middle one, upside down, hangs on its far corner */
    child[3].v += h;
    child[3].hu = child[3].hv = -h;
    child[3].a = vec_scale(a, -1);
    child[3].b = vec_scale(b, -1);
}

static void make_half(const btg_part *part, const btg_cell *cell, bool along_u, int side,
                      btg_cell *child) {
    *child = *cell;
    child->tile = BTG_CELL_MADE;
    child->bend_uv = 0.5 * cell->bend_uv;
    if (along_u) {
        child->hu = 0.5 * cell->hu;
        child->u = cell->u + (side ? child->hu : -child->hu);
        child->bend_uu = 0.25 * cell->bend_uu;
    } else {
        child->hv = 0.5 * cell->hv;
        child->v = cell->v + (side ? child->hv : -child->hv);
        child->bend_vv = 0.25 * cell->bend_vv;
    }
    btg_surface_point s;
    btg_patch_evaluate(&part->patches[cell->item], child->u, child->v, &s);
    child->centre = s.s;
    child->a = vec_scale(s.su, child->hu);
    child->b = vec_scale(s.sv, child->hv);
}

static void take_half(const btg_part *part, const btg_cell *cell, int side, btg_cell *child) {
    uint32_t link = part->tiles[cell->tile].child;
    *child = *cell;
    if (link & BTG_TILE_SPLIT_V) {
        child->hv = 0.5 * cell->hv;
        child->v = cell->v + (side ? child->hv : -child->hv);
    } else {
        child->hu = 0.5 * cell->hu;
        child->u = cell->u + (side ? child->hu : -child->hu);
    }
    from_tile(part, (link & BTG_TILE_CHILD) + (uint32_t)side, child);
}

int btg_cell_split(const btg_part *part, const btg_cell *cell,
                   btg_cell child[BTG_CELL_CHILDREN_MAX]) {
    if (btg_cell_is_triangle(part, cell)) {
        split_triangle(cell, child);
        return 4;
    }
    bool stored = cell->tile != BTG_CELL_MADE && part->tiles[cell->tile].child != 0;
    /* A side counts with its bend: at a collapsed edge one side is nothing but bend. */
    bool along_u = vec_norm(cell->a) + cell->bend_uu >= vec_norm(cell->b) + cell->bend_vv;
    for (int side = 0; side < 2; side++) {
        if (stored)
            take_half(part, cell, side, &child[side]);
        else
            make_half(part, cell, along_u, side, &child[side]);
    }
    return 2;
}

double btg_cell_radius(const btg_part *part, const btg_cell *cell) {
    if (!btg_cell_is_triangle(part, cell)) {
        /* the longer diagonal */
        double p = vec_norm2(vec_add(cell->a, cell->b)), m = vec_norm2(vec_sub(cell->a, cell->b));
        return sqrt(p > m ? p : m) + btg_cell_bend(part, cell);
    }
    btg_vec3 third = vec_scale(vec_add(cell->a, cell->b), 1.0 / 3);
    double r0 = vec_norm2(third), r1 = vec_norm2(vec_sub(cell->a, third));
    double r2 = vec_norm2(vec_sub(cell->b, third));
    double most = r0 > r1 ? r0 : r1;
    return sqrt(most > r2 ? most : r2) + btg_cell_bend(part, cell);
}

double btg_cell_reach(const btg_part *part, const btg_cell *cell, btg_vec3 n) {
    double na = vec_dot(n, cell->a), nb = vec_dot(n, cell->b);
    if (!btg_cell_is_triangle(part, cell)) return fabs(na) + fabs(nb) + btg_cell_bend(part, cell);
    double most = na > nb ? na : nb;
    return (most > 0 ? most : 0) - (na + nb) / 3 + btg_cell_bend(part, cell);
}

btg_place btg_cell_place(const btg_part *part, const btg_cell *cell) {
    double third = btg_cell_is_triangle(part, cell) ? cell->hu / 3 : 0;
    return (btg_place){cell->item, cell->u + third, cell->v + third};
}
