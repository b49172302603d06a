/* Verification: a path is cut into a stock and what is left is compared with the part.
 *
 * The stock is a field of heights over the part's extent in x and y. The tool is cut into it as it
 * moves, not only where it stands: between two poses the tip runs straight and the axis turns
 * evenly in the plane of both. That motion is taken in steps so short that the tools at them, put
 * together, miss less of the swept tool than def.sweep_error_mm (stock.c has the proof).
 *
 * Heights are compared along z, at cell centres, and taken as distances from the part by the z of
 * the part's normal there: exact on a plane, to first order elsewhere. Beside the field, DROP gives
 * at each of the steps, against the exact part, overhangs included, a proven bound of the gouge. */
#ifndef BITANGENT_VERIFY_H
#define BITANGENT_VERIFY_H

#include "bitangent/bitangent.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct btg_verify_def {
    uint32_t version;
    double cell_mm;        /* 0 (default): 0.1, or more where that would be over 16 million cells */
    double sweep_error_mm; /* > 0, default 0.001 */
    double stock_mm;       /* top of the block over the part's highest point, >= 0, default 5 */
    double gouge_mm;       /* deeper than this counts as gouged area; default 0.01 */
    double scallop_mm;     /* up to this counts as finished strip; default 0.01 */
    double tolerance_mm;   /* of the proven bounds; default 0.0001 */
    uint32_t threads;      /* 0 (default): as many as the machine has */
    int prove;             /* 1 (default): bounds and collisions by DROP too */
    btg_allocator allocator;
    double pose_error_mm; /* how far the poses may tell the motion wrong: part of sweep_error_mm and
                             less than it; default 0 */
} btg_verify_def;

BTG_API btg_verify_def btg_verify_def_default(void);

#define BTG_VERIFY_CELLS_MAX 200000000 /* 24 bytes each */

/* A tool pose of the path. */
typedef struct btg_verify_pose {
    btg_vec3 tip, axis; /* axis is unit, from tip to holder; z above 0 */
    int link;           /* 1: the tool moves here from the pose before */
    uint32_t pass, point;
    uint64_t line; /* of the file it is from; the three are told back, no more */
    int between;   /* 1: no position of the path, but on the way to the next one */
} btg_verify_pose;

/* Where something happens: the pose it is at or nearest to. */
typedef struct btg_verify_place {
    uint64_t position; /* from 1, in the order added; 0: nowhere */
    uint64_t line;
    uint32_t pass, point;
    btg_vec3 at; /* on the part, mm */
} btg_verify_place;

typedef struct btg_verify_result {
    uint64_t positions, steps; /* of the path; poses the motion was taken in */
    uint64_t cells, part_cells;
    double cell_mm, sweep_error_mm;

    double max_gouge_mm; /* deepest cell; 0: none */
    btg_verify_place gouge;
    double gouge_area_mm2; /* deeper than def.gouge_mm, of the part's surface */

    double max_scallop_mm; /* most that is left on a cell, uncut ones included */
    btg_verify_place scallop;
    double mean_scallop_mm;
    double percentile_mm[4]; /* 50, 90, 99 and 99.9 % of the part's cells have at most this left */
    double uncut_mm2;        /* of the part's surface: no pose came over it */
    double strip_width_mm;   /* surface with at most def.scallop_mm left, by length of the path */
    double length_mm;        /* of the moves that cut */
    double removed_mm3;

    /* Proven, without the field: the cutter is nowhere deeper in the part than this. NaN: not
     * asked for. */
    double position_bound_mm; /* at the poses */
    double motion_bound_mm;   /* between them too */
    btg_verify_place bound;   /* the greatest of both */
    uint64_t collisions;      /* poses, or moves to them, where shank or holder are in the part,
                                or a search of bounded length could not prove that they are not */
    double collision_mm;      /* the farthest the tool must back out along its axis */
    btg_verify_place collision;
} btg_verify_result;

/* One verification. Thread-safety: one thread at a time. Real-time: no. */
typedef struct btg_verify btg_verify;

/* The part must outlive it. All memory is allocated here: it depends on part and cell, not on the
 * path. Errors: ERROR_ARGUMENT, ERROR_MEMORY. */
BTG_API btg_status btg_verify_create(const btg_verify_def *def, const btg_part *part,
                                     const btg_tool *tool, btg_verify **verify,
                                     btg_message *message);
BTG_API void btg_verify_destroy(btg_verify *verify); /* NULL is fine */

/* Threads in use. */
BTG_API uint32_t btg_verify_threads(const btg_verify *verify);

/* The next pose. ERROR_ARGUMENT: not finite, axis not unit or not upward. */
BTG_API btg_status btg_verify_add(btg_verify *verify, const btg_verify_pose *pose);
BTG_API btg_status btg_verify_end(btg_verify *verify, btg_verify_result *result);

/* The field, after btg_verify_end: column i, row j stands at x_mm + i * cell_mm, y_mm + j *
 * cell_mm, index j * width + i. */
typedef struct btg_verify_map {
    uint32_t width, height;
    double x_mm, y_mm, cell_mm, top_mm;
    const double *part_z_mm;  /* highest point of the part; -INFINITY: none */
    const float *normal_z;    /* of the part's normal there, 0 .. 1 */
    const double *stock_z_mm; /* what is left; top_mm: uncut */
} btg_verify_map;

BTG_API btg_verify_map btg_verify_get_map(const btg_verify *verify);
/* Distance of the stock's top from the part, mm: < 0 gouged; NaN where there is no part. */
BTG_API double btg_verify_deviation(const btg_verify_map *map, size_t index);

/* ---- side step of a scallop height --------------------------------------------------------- */

#define BTG_SIDE_STEP_SCALLOP_MIN 1e-3 /* mm: finer trials would take hours */

typedef struct btg_side_step_def {
    uint32_t version;
    btg_footprint_def footprint; /* rectangle and forward step; passes are taken as parallel */
    double scallop_mm;           /* default 0.01: what may be left between passes */
    double share;                /* 0 .. 1, default 0.99: of the area a tool's radius inside the
                                    part's extent, where no more than that may be left */
    uint32_t threads;            /* of the cutting; 0 (default): as many as the machine has */
    /* Positions over `count` points (x, y pairs); what it returns below 0 ends the search. */
    btg_status (*solve)(const double *foot_xy_mm, size_t count, btg_position *positions,
                        void *user);
    void *user;
    btg_allocator allocator;
} btg_side_step_def;

BTG_API btg_side_step_def btg_side_step_def_default(void);

/* The widest side step, to 2 %, from a twentieth of the tool's diameter to the whole, found by
 * cutting some ten trial paths. ERROR_ARGUMENT with a message: none is narrow enough, or bad input;
 * ERROR_MEMORY; and what `solve` returns. */
BTG_API btg_status btg_side_step(const btg_side_step_def *def, const btg_part *part,
                                 const btg_tool *tool, double *step_mm, btg_message *message);

#ifdef __cplusplus
}
#endif
#endif
