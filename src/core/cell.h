/* A cell: one piece of the part by itself, for the tests that look at one at a time. Internal. */
#ifndef BTG_CORE_CELL_H
#define BTG_CORE_CELL_H

#include "core/block.h"

/* Patch piece: centre + a s + b t, |s|, |t| <= 1, up to `bend`; parameters u +- hu, v +- hv.
 * Triangle piece: corners x, x + a, x + b with centre = x + (a + b) / 3, exact; parameters
 * (u, v), (u + hu, v), (u, v + hu), hu signed. */
typedef struct btg_cell {
    btg_vec3 centre, a, b;
    double u, v, hu, hv;
    double bend;   /* rounding of its points included */
    uint32_t item; /* BTG_CELL_MANY: a sheet over several; it has no parameters */
    bool triangle;
} btg_cell;

#define BTG_CELL_MANY UINT32_MAX

/* Piece k of a block: of a patch, or of a node's children. */
void btg_cell_of_block(const btg_block *block, int k, btg_cell *cell);
void btg_cell_of_child(const btg_block *block, int k, btg_cell *cell);

/* A triangle's piece from its parameters: u, v and hu of `piece`. */
void btg_cell_of_triangle(const btg_part *part, const btg_piece *piece, btg_cell *cell);

/* A whole triangle, and the four its piece is cut into. */
void btg_triangle_root(uint32_t item, btg_piece *piece);
void btg_triangle_cut(const btg_piece *piece, btg_piece quarter[4]);

static inline bool btg_is_triangle(const btg_part *part, uint32_t item) {
    return item >= part->patch_count;
}

/* Radius of a ball about the centre that holds the cell. */
double btg_cell_radius(const btg_cell *cell);

/* The largest n . (s - centre) over the cell. */
double btg_cell_reach(const btg_cell *cell, btg_vec3 n);

/* Parameters of the centre. */
btg_place btg_cell_place(const btg_cell *cell);

#endif
