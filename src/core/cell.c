/* Cells of the search: pieces of patches and triangles. */
#include "core/cell.h"

/* Rounding of a triangle's points, part of the part's scale. */
#define ROUNDING 1e-14

void btg_cell_of_child(const btg_block *block, int k, btg_cell *cell) {
    *cell = (btg_cell){.centre = btg_block_vector(&block->at.s, k),
                       .a = btg_block_vector(&block->at.su, k),
                       .b = btg_block_vector(&block->at.sv, k),
                       .bend = block->bend[k],
                       .item = BTG_CELL_MANY};
}

void btg_cell_of_block(const btg_block *block, int k, btg_cell *cell) {
    btg_cell_of_child(block, k, cell);
    cell->u = block->u[k];
    cell->v = block->v[k];
    cell->hu = block->hu[k];
    cell->hv = block->hv[k];
    cell->item = block->item[k];
}

void btg_cell_of_triangle(const btg_part *part, const btg_piece *piece, btg_cell *cell) {
    btg_vec3 c[3];
    btg_triangle_corners(part, piece->item - part->patch_count, c);
    btg_vec3 a = vec_sub(c[1], c[0]), b = vec_sub(c[2], c[0]);
    cell->u = piece->u;
    cell->v = piece->v;
    cell->hu = cell->hv = piece->hu;
    cell->item = piece->item;
    cell->triangle = true;
    cell->bend = ROUNDING * part->scale;
    cell->a = vec_scale(a, piece->hu);
    cell->b = vec_scale(b, piece->hu);
    double third = piece->hu / 3;
    cell->centre = vec_mad(vec_mad(c[0], a, piece->u + third), b, piece->v + third);
}

void btg_triangle_root(uint32_t item, btg_piece *piece) {
    *piece = (btg_piece){.hu = 1, .hv = 1, .item = item};
}

void btg_triangle_cut(const btg_piece *piece, btg_piece quarter[4]) {
    double h = 0.5 * piece->hu;
    for (int k = 0; k < 4; k++) {
        quarter[k] = *piece;
        quarter[k].hu = quarter[k].hv = h;
    }
    quarter[1].u += h;
    quarter[2].v += h;
    quarter[3].u += h; /* the middle one, upside down, hangs on its far corner */
    quarter[3].v += h;
    quarter[3].hu = quarter[3].hv = -h;
}

double btg_cell_radius(const btg_cell *cell) {
    if (!cell->triangle) {
        /* the longer diagonal */
        double p = vec_norm2(vec_add(cell->a, cell->b)), m = vec_norm2(vec_sub(cell->a, cell->b));
        return sqrt(p > m ? p : m) + cell->bend;
    }
    btg_vec3 third = vec_scale(vec_add(cell->a, cell->b), 1.0 / 3);
    double r0 = vec_norm2(third), r1 = vec_norm2(vec_sub(cell->a, third));
    double r2 = vec_norm2(vec_sub(cell->b, third));
    double most = r0 > r1 ? r0 : r1;
    return sqrt(most > r2 ? most : r2) + cell->bend;
}

double btg_cell_reach(const btg_cell *cell, btg_vec3 n) {
    double na = vec_dot(n, cell->a), nb = vec_dot(n, cell->b);
    if (!cell->triangle) return fabs(na) + fabs(nb) + cell->bend;
    double most = na > nb ? na : nb;
    return (most > 0 ? most : 0) - (na + nb) / 3 + cell->bend;
}

btg_place btg_cell_place(const btg_cell *cell) {
    double third = cell->triangle ? cell->hu / 3 : 0;
    return (btg_place){cell->item, cell->u + third, cell->v + third};
}
