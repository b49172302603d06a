/* The exact search: the largest value (ray.h) over the whole part. Internal.
 *
 * A walk, nearest first, through the part's trees. A region is left as soon as it is proven clear
 * of the tool placed at the best value so far, by up to `tolerance`: what is left cannot beat that
 * value without cutting deeper than the tolerance. Regions that are not clear offer their centre
 * as a better value, which is then polished. */
#ifndef BTG_CORE_SEARCH_H
#define BTG_CORE_SEARCH_H

#include "core/cell.h"
#include "core/ray.h"
#include "core/tail.h"

/* Sheets that meet P and whose limit there has been taken. */
#define BTG_SHEETS_MAX 32

/* One of the part's items that meet P: its place there and its speeds, mm. */
typedef struct btg_sheet {
    btg_place place;
    double speed_u, speed_v;
    double reach, way; /* pieces of it up to those steps from the place, and up to that way from P,
                          were left to the limits there */
    bool close;        /* no more is left than search.deep_at_p allows */
} btg_sheet;

/* A cell and the radius of the ball about its centre that holds it. */
typedef struct btg_region {
    btg_cell cell;
    double radius;
} btg_region;

/* What waits on the stack. */
typedef struct btg_entry {
    double key; /* the smaller, the sooner it is looked at */
    btg_vec3 centre;
    double radius;   /* of the ball about centre that holds it; infinite: not known */
    btg_piece piece; /* of a patch or triangle */
    uint32_t node;   /* to be opened; BTG_NODE_NONE: the piece */
    uint32_t count;  /* of triangles in order, from piece.quarters on, where piece.item is
                        BTG_CELL_MANY */
} btg_entry;

/* The neighbourhood of a contact, in its item's parameters, that is proven clear of an element of
 * the tool as placed (basin.c): steps up to `reach`, in mm at the contact's speeds. */
typedef struct btg_basin {
    btg_place place;
    double speed_u, speed_v;
    double reach; /* 0: none */
    double deep;  /* no point of it is deeper in the tool, mm */
    uint32_t element;
} btg_basin;

/* Wedges of the ring that may stay open. */
#define BTG_RING_OPEN 12

/* A wedge about the tool's axis: what is outside of one of its two sides, by their normals. */
typedef struct btg_wedge {
    double low[2], high[2];
} btg_wedge;

/* A contact on the ring: where it is about the axis, and the angle of its wedge's half. */
typedef struct btg_ring_contact {
    double cosine, sine, radius, height, half;
    bool proven;
} btg_ring_contact;

/* TILT: what is proven of one patch all along the tool's ring (ring.c): what is within `wide` of a
 * middle in radius and height about the axis is clear, but for open wedges. */
typedef struct btg_ring {
    bool stale, stands;
    bool closed; /* it stands, and nothing is open at the contacts */
    uint32_t item;
    double u, v, half_u, half_v; /* of all parameters in that box */
    btg_vec3 x, y;               /* directions that wedges are measured by: P's, and ahead of it */
    double radius, height, wide;
    btg_ring_contact p, q;
    double step[4]; /* parameters of steps of 1 mm at P: along the ring, outward */
    uint32_t open;
    btg_wedge wedge[BTG_RING_OPEN];
} btg_ring;

typedef struct btg_search {
    const btg_part *part;
    btg_ray_query query;
    double tolerance; /* mm of clearance */
    double rounding;  /* of a distance to the tool, mm; at most the tolerance */

    /* The best so far; `found` false: value is what an answer must beat. */
    bool found, osculating;
    bool settled; /* a polish came to its end there */
    double value;
    double gouge, touch; /* TILT: as deep, mm, may the start pose be in the part with the cutter,
                            and with the rest, that does not touch it at P */
    bool gouges;         /* it is deeper: there is no answer */
    bool spent;          /* the budget ran out: nothing of the part has a value above `bound` */
    double bound;
    double deepest;   /* what was left is nowhere deeper in the tool, mm */
    btg_placement at; /* the tool placed there */
    btg_place place;
    btg_vec3 point;
    uint32_t element;
    uint32_t nodes, budget;
    btg_basin basin[2]; /* about the best contact; TILT: about P */
    bool basin_stale;
    btg_ring ring;

    btg_place p_place; /* TILT: place of the first contact */
    bool has_start;
    btg_place start;                 /* near the answer, says the caller */
    btg_sheet sheet[BTG_SHEETS_MAX]; /* one an item */
    uint32_t sheet_count;
    double near_p2;   /* squared way from P within which values may be nothing but rounding, mm^2 */
    double sheet_gap; /* an item that comes this close to P meets it, mm */
    double left_p2;   /* squared way from P within which its limits speak for the part, mm^2 */
    double deep_at_p; /* what is left to them may be that deep, half the tolerance asked, mm */
    double other_way; /* as btg_sheet's: of items that do not meet P */
    bool other_close;

    /* from here on nothing holds before it is set */
    btg_tail_room tail_room;
    btg_block block; /* that is being looked at */
    btg_block_bound bounds;
    btg_region region;             /* one of its pieces */
    btg_ray_distance near;         /* to the tool, of the place that is being looked at */
    btg_surface_point here, there; /* that are being looked at: off the stack */
    size_t top, stack_size;
    btg_entry *stack;
} btg_search;

/* Entries the stack must hold for this part. */
size_t btg_search_stack_size(const btg_part *part);

/* Runs the search from the state set up by the caller: part, query, tolerance, stack, and for
 * DROP value -INFINITY, for TILT -max_tilt, with p_place. */
void btg_search_run(btg_search *search);

/* TILT: the top that is uphill from the start, or the limits at P, and no more: nothing is proven.
 */
void btg_search_run_near(btg_search *search);

/* Follows the value uphill from a place to its local maximum and keeps it when it beats the best.
 * (polish.c) */
void btg_search_polish(btg_search *search, btg_place from);

/* From a place on a sharp rim of the tool to the contact on it. (rim.c) */
void btg_search_polish_rim(btg_search *search, btg_place from, uint32_t element);

/* Takes a value as the best when it beats it; false: it does not. */
bool btg_search_offer(btg_search *search, double value, btg_place place, btg_vec3 point,
                      uint32_t element, bool osculating);

/* TILT: a point of a positive value, met by an element, is deeper in that as it starts than it may
 * be. */
bool btg_search_start_gouges(const btg_search *search, btg_vec3 point, uint32_t element);

/* TILT, near P, where the value depends on the direction alone (limits.c): the limits of the
 * tool and of the sheet of P. */
void btg_search_near_p(btg_search *search);
/* After the walk: the contact that may stand so near P that the walk did not see it. */
void btg_search_climb_ridges(btg_search *search);
/* Bits of the pieces of search->block whose balls reach P and that are small enough to tell where
 * their item comes nearest; and the limit of such an item, if it meets P. */
unsigned btg_search_reaching_p(const btg_search *search);
void btg_search_sheet_at_p(btg_search *search, const btg_region *region);

/* The region is clear of the tool placed at the best value by `tolerance`, and was all the way
 * there (bounds.c). */
bool btg_search_clear(btg_search *search, const btg_region *region);
/* Of the pieces of search->block in `bits`, those that are not; with the bounds of their distances
 * to the cutter, NULL where it is sharp. `pieces`: of items, else children of nodes. */
unsigned btg_search_left(btg_search *search, const btg_block_bound *bound, unsigned bits,
                         bool pieces);
/* Piece k of search->block by itself: in search->region. */
const btg_region *btg_search_region(btg_search *search, int k, bool pieces);
/* TILT: the region is so near P that the limits there speak for it; `at_the_end`: it will not be
 * cut any more, however deep it may be. (basin.c) */
bool btg_search_left_to_p(btg_search *search, const btg_region *region, bool at_the_end);
/* No tool as dropped is deeper in the part than this many clearances of the search. */
#define BTG_BEGUN 2
/* No point of what was left to P is deeper in the tool as placed, mm. */
double btg_search_deep_at_p(btg_search *search);
/* Where that may be too deep no more shall be left than may; false: it is not too deep, or that was
 * said before. */
bool btg_search_come_close_to_p(btg_search *search);

/* basin.c: the basin of a contact of the tool placed at the best value; a region inside it; and a
 * single cell clear of an element by the Taylor polynomial at its centre. */
void btg_basin_make(btg_search *search, btg_place place, uint32_t element, btg_basin *basin);
/* Any of the basins of the placed tool covers it; they are made when first asked for. */
bool btg_basins_cover(btg_search *search, const btg_region *region, uint32_t element);
/* Of the quarters of search->block in `bits`, those that a basin of the cutter covers. */
unsigned btg_basins_covering(btg_search *search, unsigned bits);
/* ring.c: a place that the tool as placed cuts into under its ring, where the way to the second
 * contact may begin; false: none is known. */
bool btg_ring_start(btg_search *search, btg_place *place);
/* Proves what it can. */
void btg_ring_prove(btg_search *search);
/* The same; what waits and is covered is left. (ring_cover.c) */
void btg_ring_make(btg_search *search);
/* The ring stands, the tool has no more than its cutter, and what waits is covered. (ring_cover.c)
 */
bool btg_ring_covers(const btg_search *search, const btg_entry *entry);
/* Of the pieces of search->block in `bits`, those that the ring covers. (ring_cover.c) */
unsigned btg_ring_covering(const btg_search *search, unsigned bits);
bool btg_cell_clear_to_second_order(btg_search *search, const btg_region *region,
                                    const btg_tool_element *e);

#endif
