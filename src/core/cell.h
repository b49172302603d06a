/* A cell: what the search looks at, a piece of a patch or of a triangle that halves as often as
 * asked. Stored tiles come first, then cells made on the way. Internal. */
#ifndef BTG_CORE_CELL_H
#define BTG_CORE_CELL_H

#include "core/part.h"

/* Patch piece: centre + a s + b t, |s|, |t| <= 1, up to `bend`; parameters u +- hu, v +- hv.
 * Triangle piece: corners x, x + a, x + b with centre = x + (a + b) / 3, exact; parameters
 * (u, v), (u + hu, v), (u, v + hu), hu signed. */
typedef struct btg_cell {
    btg_vec3 centre, a, b;
    double u, v, hu, hv;
    double bend_uu, bend_uv, bend_vv;
    uint32_t item;
    uint32_t tile; /* stored tile this is; BTG_CELL_MADE when made on the way */
} btg_cell;

#define BTG_CELL_MADE         UINT32_MAX
#define BTG_CELL_CHILDREN_MAX 4

void btg_cell_root(const btg_part *part, uint32_t item, btg_cell *cell);

/* Cuts the cell; returns the number of children, 2 for a patch piece, 4 for a triangle's. */
int btg_cell_split(const btg_part *part, const btg_cell *cell,
                   btg_cell child[BTG_CELL_CHILDREN_MAX]);

static inline bool btg_cell_is_triangle(const btg_part *part, const btg_cell *cell) {
    return cell->item >= part->patch_count;
}

/* Error of the cell's plane figure, and the rounding of its points. */
static inline double btg_cell_bend(const btg_part *part, const btg_cell *cell) {
    return cell->bend_uu + cell->bend_uv + cell->bend_vv + 1e-14 * part->scale;
}

/* Radius of a ball about the centre that holds the cell. */
double btg_cell_radius(const btg_part *part, const btg_cell *cell);

/* The largest n . (s - centre) over the cell. */
double btg_cell_reach(const btg_part *part, const btg_cell *cell, btg_vec3 n);

/* Parameters of the centre. */
btg_place btg_cell_place(const btg_part *part, const btg_cell *cell);

#endif
