/* `bitangent plan`: what its files share. plan.c works it out and measures, cmd_plan.c reads the
 * command line and prints. */
#ifndef BTG_APP_PLAN_H
#define BTG_APP_PLAN_H

#include "app/options.h"
#include "methods/method.h"

/* Rounding of a depth, a pixel and a point in single precision: parts of the part's size. */
#define PLAN_ROUNDING 3e-7

/* The part where it is about as steep: sine of its greatest slope, greatest curvature away from the
 * tool, 1/mm. */
typedef struct plan_ground {
    double sine, bulge;
} plan_ground;
#define PLAN_GROUNDS 16

/* What a part asks of sampling. */
typedef struct plan_part {
    double slope_rad; /* steepest of its normals against z */
    double radius_mm; /* smallest radius of curvature; INFINITY: flat facets alone */
    plan_ground ground[PLAN_GROUNDS]; /* by slope; zeros: none */
    double side_mm[2];                /* extent in x and y */
    double size_mm;                   /* the largest of x, y and z */
    bool triangles;                   /* it is facets already */
} plan_part;

/* One way to sample a drop by pixels, as fine as an error wants. */
typedef struct plan_way {
    int levels;
    uint32_t window; /* pixels of its side */
    double pitch_mm; /* of the last level */
    double bound_mm; /* no drop leaves the tool deeper in the part, on smooth ground */
    double pixels;   /* of a drop */
} plan_way;

typedef struct plan_facets {
    double length_mm;
    double count; /* along a circle of the tool; triangles in all */
    double triangles;
} plan_facets;

typedef struct plan_check {
    const char *backend; /* that made the drops; NULL: none could */
    size_t places;
    double measured_mm; /* deepest that a drop left the tool in the part */
    double share;       /* of its own bound that an error is at the most: above 1 breaks it */
    double seconds;     /* a position: drop and tilt */
} plan_check;

typedef struct plan {
    plan_part part;
    double pixel_share_mm, tool_share_mm, part_share_mm; /* of the tolerance */
    double rounding_mm; /* inside the pixels' share: of the device that draws; 0: of none */
    plan_way one, two;  /* levels */
    plan_facets insert, rim, surface;
    plan_way taken;   /* the cheaper one, its window widened until its errors keep the share */
    plan_check model; /* of one level, against its bounds */
    plan_check check; /* of the one taken, against the pixels' share */
} plan;

/* A window and its bound. */
plan_way plan_way_of(const btg_tool *tool, const plan *p, uint32_t window, int levels);

/* Greatest normal curvature at a place, either way, 1/mm; not finite where there is no normal. */
double plan_curvature(const btg_part *part, btg_place place);
plan_part plan_look(const btg_part *part);
/* Is there a back end here that draws depth images? */
bool plan_raster_ready(void);
/* All but the check. ERROR_ARGUMENT: no pixels are fine enough, the device rounds by more. */
btg_status plan_make(const btg_tool *tool, const plan_part *part, double tolerance_mm, plan *out,
                     btg_message *message);
/* Drops by `way` of a plan against exact ones, each against the bound of its own contact, at places
 * inside smooth surfaces, and the time of positions. check->backend NULL: no back end here drops
 * this part by pixels. */
btg_status plan_measure(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                        const plan *p, const plan_way *way, plan_check *check,
                        btg_message *message);

#endif
