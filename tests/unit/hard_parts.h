/* Parts and tools that bounds find hard, for the tests of bounds. */
#ifndef BTG_TESTS_UNIT_HARD_PARTS_H
#define BTG_TESTS_UNIT_HARD_PARTS_H

#include "bitangent/bitangent.h"

#include "../conformance/model.h"
#include "../conformance/rng.h"

/* One Bezier patch of random degrees about `size` mm wide, now and then rational. */
typedef enum hard_patch {
    HARD_SMOOTH,
    HARD_SKEWED,    /* sides slanted and of unequal length */
    HARD_SPIKY,     /* one control point far out */
    HARD_COLLAPSED, /* one edge a point */
    HARD_RIPPLES,   /* degree 9 along u */
    HARD_FLAT,      /* but for 1e-5 mm */
    HARD_PATCHES
} hard_patch;
void hard_add_patch(model *m, rng *r, hard_patch kind, double size);

/* Some hundred triangles about `size` mm wide. */
typedef enum hard_mesh {
    HARD_TERRAIN,
    HARD_SOUP,
    HARD_NEEDLES,
    HARD_ONE_POINT, /* all triangles that point */
    HARD_RIDGE,     /* two equal creases */
    HARD_MESHES
} hard_mesh;
void hard_add_mesh(model *m, rng *r, hard_mesh kind, double size);

/* Cutters with round corners; those from HARD_CUTTERS on have a shank. */
#define HARD_CUTTERS 5
#define HARD_TOOLS   6
btg_tool hard_tool(int number);

btg_vec3 hard_unit(rng *r);

/* BTG_TEST_QUICK: a fifth of the rounds. */
int hard_rounds(int all);

#endif
