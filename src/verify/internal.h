/* What verification is made of. Internal. */
#ifndef BTG_VERIFY_INTERNAL_H
#define BTG_VERIFY_INTERNAL_H

#include "bitangent/verify.h"
#include "core/part.h"

/* Side of a tile, cells; rows of the field that one thread works on at a time. */
#define BTG_TILE      8
#define BTG_BAND_ROWS 32
/* Steps cut into the field together: many enough that starting threads costs nothing. */
#define BTG_STEPS_MAX 4096

/* What the stock of some cells is nowhere above: a plane, height at the tile's middle and slopes.
 * One array each: many tiles are looked at side by side. */
typedef struct btg_tiles {
    uint32_t width, height; /* tiles; those at the upper ends may have fewer cells */
    double *z, *along_x, *along_y;
    uint8_t *stale; /* the stock was cut since */
} btg_tiles;

typedef struct btg_field {
    uint32_t width, height;
    double x, y, cell;  /* centre of the first cell */
    double top, bottom; /* of the block, mm */
    double *part_z, *stock_z;
    float *normal_z;
    btg_tiles tiles;
} btg_field;

/* The tool at one moment of the path. */
typedef struct btg_step {
    btg_vec3 centre, axis;  /* of the torus */
    uint32_t order;         /* how far from a step the others leave gaps: cut low ones first */
    btg_verify_place place; /* of the nearest pose */
} btg_step;

/* ---- crew.c: threads ---------------------------------------------------------------------- */

/* Calls work(job, i, thread) for i in 0 .. count - 1, threads side by side; 0 <= thread < threads.
 */
void btg_crew_run(uint32_t threads, size_t count,
                  void (*work)(void *job, size_t i, uint32_t thread), void *job);
uint32_t btg_crew_threads(uint32_t wanted);

/* ---- under.c: the lower side of a placed cutter -------------------------------------------- */

typedef struct btg_cutter {
    double major, minor;
    bool hollow;
} btg_cutter;

/* Lowest height at which the vertical line at (x, y) from the torus centre meets the cutter, from
 * that centre, to 1e-10 of its size. False: never. axis.z > 0. */
bool btg_cutter_under(const btg_cutter *cutter, btg_vec3 axis, double x, double y, double *z);

/* The same from a height near it, where the line can meet the cutter's lower side but once. False:
 * not found, search. */
bool btg_cutter_under_near(const btg_cutter *cutter, btg_vec3 axis, double x, double y, double near,
                           double *z);

/* ---- field.c ------------------------------------------------------------------------------ */

/* Heights and normals of the part's upper side in the rows of a band. */
void btg_field_part(btg_field *field, const btg_part *part, uint32_t first_row, uint32_t end_row);

/* ---- tiles.c ------------------------------------------------------------------------------ */

/* Planes of the stale tiles of a row of them, from tile `first` to `end` - 1. */
void btg_tiles_refresh(btg_field *field, uint32_t row, uint32_t first, uint32_t end);
/* room[i - first] < 0: the cutter, centre of its torus at `centre`, cuts no cell of tile i. */
void btg_tiles_measure(const btg_field *field, const btg_cutter *cutter, btg_vec3 centre,
                       btg_vec3 axis, uint32_t row, uint32_t first, uint32_t end, double *room);

/* ---- stock.c ------------------------------------------------------------------------------ */

/* The deepest gouge so far in one band. */
typedef struct btg_band {
    double gouge; /* mm, > 0 */
    btg_verify_place place;
} btg_band;

void btg_stock_cut(btg_field *field, const btg_cutter *cutter, const btg_step *steps, size_t count,
                   uint32_t first_row, uint32_t end_row, btg_band *band);

/* Number of steps from one pose to the next that keep the error of the swept cutter. `turn` is the
 * angle between the axes, `way` the distance of the tips. */
uint32_t btg_stock_steps(const btg_cutter *cutter, double way, double turn, double error);

/* ---- result.c ----------------------------------------------------------------------------- */

void btg_result_of_field(const btg_field *field, const btg_verify_def *def,
                         btg_verify_result *result);

#endif
