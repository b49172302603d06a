/* Sheets: quadratic pieces with a thickness, that hold triangles, patches and other sheets. What
 * the nodes of the search tree are made of. Internal; set-up only. */
#ifndef BTG_CORE_SHEET_H
#define BTG_CORE_SHEET_H

#include "core/block.h"

/* centre + a s + b t + (uu s^2 + 2 uv s t + vv t^2) / 2, |s|, |t| <= 1, up to error, mm. */
typedef struct btg_sheet {
    btg_vec3 centre, a, b, uu, uv, vv;
    double error;
    double radius; /* of a ball about the centre that holds all of it */
} btg_sheet;

/* The sheet of a patch's piece: the piece itself. */
void btg_sheet_of_piece(const btg_part *part, const btg_piece *piece, btg_sheet *sheet);

/* A sheet that holds triangles, given by their numbers. */
void btg_sheet_of_triangles(const btg_part *part, const uint32_t *triangles, uint32_t count,
                            btg_sheet *sheet);

/* A sheet that holds others. */
void btg_sheet_merge(const btg_sheet *of, int count, btg_sheet *sheet);

#endif
