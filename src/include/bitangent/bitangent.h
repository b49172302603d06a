/* Bitangent: two-contact, gouge-free positions of a milling cutter on freeform parts.
 *
 * The part frame is right-handed, in millimetres, z up; the tool comes from +z. Angles are
 * radians. A set-up call (create, init) may allocate, only through the caller's allocator; a run
 * call (drop, tilt, position) never allocates, locks, logs, or reads clock or environment.
 *
 * Every call that can fail returns a btg_status: 0 success, > 0 valid but notable, < 0 error.
 * Results come by pointer and are untouched on error. No global state; every function is
 * reentrant. Thread-safety is stated per object.
 *
 * The method is vertical and circular rays: M. Singh, S. Bedi, S. Mann, "Tool Positioning in
 * Five Axis Machining on a Tensor Product Surface using Circular Rays" (VCRF).
 */
#ifndef BITANGENT_BITANGENT_H
#define BITANGENT_BITANGENT_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define BTG_API
#elif defined(__GNUC__)
#define BTG_API __attribute__((visibility("default")))
#else
#define BTG_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define BTG_VERSION_MAJOR 0
#define BTG_VERSION_MINOR 1
#define BTG_VERSION_PATCH 0

/* "0.1.0"; static storage. */
BTG_API const char *btg_version(void);

/* ---- status ------------------------------------------------------------------------------ */

typedef enum btg_status {
    BTG_OK = 0,             /* a position with two contacts; elsewhere: done */
    BTG_OSCULATING = 1,     /* both contacts at one place: tool and part share a curvature */
    BTG_SINGLE_CONTACT = 2, /* no second contact up to the largest tilt; axis as dropped */
    BTG_NO_CONTACT = 3,     /* nothing of the part under the tool */
    BTG_BUDGET = 4,         /* the search was cut short: the pose is safe, but not the closest */

    BTG_ERROR_ARGUMENT = -1,    /* the caller's input is unusable (NULL, NaN, out of range) */
    BTG_ERROR_MEMORY = -2,      /* the allocator returned NULL, or a count is too large */
    BTG_ERROR_UNSUPPORTED = -3, /* known, but this build or back end cannot do it */
    BTG_ERROR_NOT_BUILT = -4,   /* the back end was left out of this build */
    BTG_ERROR_NO_DEVICE = -5,   /* the back end is built, but finds no device */
    BTG_ERROR_FILE = -6,        /* a file cannot be opened, read or written */
    BTG_ERROR_FORMAT = -7,      /* a file's content is malformed */
    BTG_ERROR_GOUGE = -8,       /* the asked start pose already cuts into the part */
    BTG_ERROR_DEVICE = -9       /* the device was lost, or did not answer in time */
} btg_status;

/* Short word for a status: "two-contact", "osculating", "single-contact", "no-contact",
 * "budget", or the
 * name of the error. Static storage. */
BTG_API const char *btg_status_name(btg_status status);

/* One line about what went wrong in a set-up call: the thing, the place, the reason, the remedy.
 * Filled on error when the pointer passed is not NULL; always terminated. */
typedef struct btg_message {
    char text[512];
} btg_message;

/* ---- memory ------------------------------------------------------------------------------ */

/* Set-up memory. Both hooks get `user` last. `allocate` returns memory aligned for any type, or
 * NULL. A zeroed struct means malloc and free. */
typedef struct btg_allocator {
    void *(*allocate)(size_t size, void *user);
    void (*release)(void *memory, void *user);
    void *user;
} btg_allocator;

/* ---- geometry ---------------------------------------------------------------------------- */

typedef struct btg_vec3 {
    double x, y, z;
} btg_vec3;

/* ---- tool -------------------------------------------------------------------------------- */

typedef enum btg_profile {
    BTG_PROFILE_TOROIDAL = 0, /* round inserts around a hollow middle: the torus alone */
    BTG_PROFILE_BULLNOSE = 1  /* the same corner, closed by a flat disc of the major radius */
} btg_profile;

#define BTG_HOLDER_MAX 8
#define BTG_LENGTH_MAX 1e6 /* mm: largest radius, height or coordinate accepted */

/* A cylinder about the tool axis; heights above the torus centre, mm, from < to. */
typedef struct btg_cylinder {
    double radius_mm;
    double from_mm;
    double to_mm;
} btg_cylinder;

/* Definition of a tool. Ball: major radius 0. Flat end mill: bullnose with minor radius 0.
 * The shank and the holder's cylinders collide like the cutter does; heights are >= 0. */
typedef struct btg_tool_def {
    uint32_t version;       /* set by btg_tool_def_default */
    btg_profile profile;    /* default toroidal */
    double major_radius_mm; /* >= 0, default 6.7 */
    double minor_radius_mm; /* >= 0, default 6; major and minor are not both 0 */
    btg_cylinder shank;     /* radius 0: none (default) */
    uint32_t holder_count;  /* 0 (default) to BTG_HOLDER_MAX */
    btg_cylinder holder[BTG_HOLDER_MAX];
} btg_tool_def;

BTG_API btg_tool_def btg_tool_def_default(void);

/* One solid of revolution of the tool: a disc (or, hollow, a circle) of ring_radius at height
 * from_mm, rounded by corner_radius; cylinders reach up to to_mm. */
typedef struct btg_tool_element {
    double ring_radius_mm;
    double corner_radius_mm;
    double from_mm;
    double to_mm;
    int hollow;
} btg_tool_element;

/* A checked tool. Plain data, copy freely; element 0 is the cutter, then shank and holder.
 * Thread-safety: read-only after init. Real-time: yes. */
typedef struct btg_tool {
    btg_tool_def def;
    uint32_t element_count;
    btg_tool_element element[2 + BTG_HOLDER_MAX];
} btg_tool;

/* Checks the definition. ERROR_ARGUMENT: a radius negative, not finite or above BTG_LENGTH_MAX,
 * both radii 0, toroidal with minor radius 0, a cylinder with from < 0 or from >= to. */
BTG_API btg_status btg_tool_init(const btg_tool_def *def, btg_tool *tool, btg_message *message);

/* ---- part -------------------------------------------------------------------------------- */

#define BTG_DEGREE_MAX 9

/* A tensor-product surface. controlPoints: 3 doubles (x, y, z) a point, count_u * count_v points,
 * v fastest. weights: count_u * count_v, > 0, or NULL. knots: count + degree + 1 numbers, not
 * decreasing, or both NULL for a Bezier patch (count = degree + 1). The domain is from
 * knots[degree] to knots[count]; interior knots repeat at most `degree` times. */
typedef struct btg_surface_def {
    int degree_u, degree_v; /* 1 .. BTG_DEGREE_MAX */
    int count_u, count_v;   /* > degree */
    const double *control_points;
    const double *weights;
    const double *knots_u;
    const double *knots_v;
} btg_surface_def;

/* Triangles as they are. positions: 3 doubles a vertex; indices: 3 a triangle. Triangles without
 * area are kept as the edges they are. Orientation does not matter. */
typedef struct btg_mesh_def {
    const double *positions;
    size_t vertex_count;
    const uint32_t *indices;
    size_t triangle_count;
} btg_mesh_def;

/* A part: any number of surfaces and meshes; at least one of either. The arrays are copied. */
typedef struct btg_part_def {
    uint32_t version;
    const btg_surface_def *surfaces;
    size_t surface_count;
    const btg_mesh_def *meshes;
    size_t mesh_count;
    btg_allocator allocator;
} btg_part_def;

BTG_API btg_part_def btg_part_def_default(void);

/* Surfaces, triangles and the search tree over them. Thread-safety: read-only after create, share
 * freely. Real-time: create and destroy no. */
typedef struct btg_part btg_part;

/* Errors: ERROR_ARGUMENT (message names surface or mesh and the entry), ERROR_MEMORY. */
BTG_API btg_status btg_part_create(const btg_part_def *def, btg_part **part, btg_message *message);
BTG_API void btg_part_destroy(btg_part *part); /* NULL is fine */

typedef struct btg_part_info {
    btg_vec3 box_min, box_max; /* of the surface itself, to 1e-6 of its size, mm */
    size_t surface_count;      /* as given */
    size_t patch_count;        /* Bezier patches they were cut into */
    size_t triangle_count;
    size_t memory_bytes;
} btg_part_info;

BTG_API void btg_part_get_info(const btg_part *part, btg_part_info *info);

/* ---- places on the part ------------------------------------------------------------------ */

/* A place on the part: item 0 .. patch_count-1 is a Bezier patch, u and v in 0..1; then follow
 * the triangles, whose point is A + u (B - A) + v (C - A), u, v >= 0, u + v <= 1. */
typedef struct btg_place {
    uint32_t item;
    double u, v;
} btg_place;

/* Point and derivatives at a place; mm, mm per unit parameter. */
typedef struct btg_surface_point {
    btg_vec3 s, su, sv, suu, suv, svv;
} btg_surface_point;

/* ERROR_ARGUMENT when the item does not exist or u, v are outside its domain. */
BTG_API btg_status btg_part_evaluate(const btg_part *part, btg_place place,
                                     btg_surface_point *point);

/* ---- the two questions ------------------------------------------------------------------- */

/* A contact. The normal is unit, from the part to the tool: the part's own inside a smooth face,
 * the tool's on edges and vertices of the part. */
typedef struct btg_contact {
    btg_place place;
    btg_vec3 point;
    btg_vec3 normal;
} btg_contact;

/* DROP: the tool's axis is the line through `origin` along unit `axis` (tip to holder). Sought is
 * the lowest height of the torus centre along it at which the tool is clear of the part:
 * max over the part of S.axis + g(r) (geometry: vertical rays). */
typedef struct btg_drop_query {
    btg_vec3 origin;
    btg_vec3 axis;
    int has_start; /* 1: the search starts at `start`, a place near the answer: quicker, and the */
    btg_place start; /* same answer to the tolerance whatever place is given */
} btg_drop_query;

typedef struct btg_drop_result {
    btg_status status;   /* BTG_OK, BTG_NO_CONTACT or BTG_BUDGET */
    double height_mm;    /* torus centre = origin + height * axis */
    btg_contact contact; /* P; all zero where the status is not BTG_OK */
    double bound_mm;     /* proven: the tool, so placed, is nowhere deeper in the part; at most the
                            tolerance, and 1e-12 of the part's size for rounding. NaN where the
                            back end proves nothing */
    uint32_t element;    /* element of the tool that touches */
    uint32_t nodes;      /* work done: tree nodes visited or surface points evaluated */
} btg_drop_result;

/* TILT: a frame {u, v, w} at the pseudo-insert's centre o1: w is the tool axis, v points from o1
 * to the tool axis, the torus centre is o1 + major_radius * v. Sought is the smallest turn of the
 * tool about u by -beta, 0 <= beta <= max_tilt, at which it meets the part. `p` is the first
 * contact: its point lies on the insert, o1 - minor_radius * normal, its normal at right angles
 * to u. */
typedef struct btg_tilt_query {
    btg_vec3 u, v, w;
    btg_vec3 o1;
    btg_contact p;
    double max_tilt_rad;
    int has_start; /* as for DROP: a place near Q */
    btg_place start;
} btg_tilt_query;

typedef struct btg_tilt_result {
    btg_status status;   /* BTG_OK, BTG_OSCULATING, BTG_SINGLE_CONTACT or BTG_BUDGET */
    double tilt_rad;     /* max_tilt when single-contact */
    btg_contact contact; /* Q; P again when osculating; all zero otherwise */
    double bound_mm;     /* as for DROP, where the start pose is as clear as DROP leaves it */
    uint32_t element;
    uint32_t nodes;
} btg_tilt_result;

/* ---- solver ------------------------------------------------------------------------------ */

/* How the tool is turned about the normal at P before it tilts (drop-spin-tilt). The spin is
 * counter-clockwise seen from the tool, -pi .. pi; 0 is the tool as dropped. Any spin leaves P
 * where it is and the tool nowhere in the part; it moves Q.
 *
 * The last three search: GAP takes about 4 tilts a position instead of one, ACROSS 8, WIDEST 13,
 * none more than 24. Q jumps where two places of the part come into question at once, so that there
 * need not be a spin that meets the aim. The answer is then the one that comes nearest of those
 * tried, with its status as usual and spin_met 0. Where no spin gives two contacts it is the
 * position without spin. Of several spins that meet the aim, the answer is one near the spin to
 * begin with: 0, or the neighbour's (btg_position_follow). The strip of WIDEST is never narrower
 * than without spin; nine times in ten no other spin gives one wider by 1 %. */
typedef enum btg_spin {
    BTG_SPIN_NONE = 0,   /* as dropped (VCRF) */
    BTG_SPIN_FIXED = 1,  /* by spin_rad; a tool that cuts the part however far it is laid over
                            stays unspun, as dropped, with one contact */
    BTG_SPIN_GAP = 2,    /* |PQ| = gap_mm: uniform spacing of the contacts */
    BTG_SPIN_ACROSS = 3, /* PQ at right angles to the feed, as it is seen from above */
    BTG_SPIN_WIDEST = 4  /* the widest strip inside scallop_mm (btg_position_strip) */
} btg_spin;

typedef struct btg_solver_def {
    uint32_t version;
    double tolerance_mm; /* error allowed in height and contact clearance; default 0.001,
                            1e-9 .. 1 */
    double max_tilt_rad; /* 0 .. pi/2, default pi/4 */
    btg_spin spin;       /* default none */
    double spin_rad;
    uint32_t node_budget;  /* most tree nodes a drop or a tilt may visit; default 1000000, >= 1.
                              When it is spent the answer is the nearest pose proven clear */
    double gap_mm;         /* GAP: |PQ| asked, > 0; met within 1e-4 mm */
    double feed_x, feed_y; /* ACROSS, WIDEST: direction of the feed in the part frame, any length;
                              both 0 (default): +y, along the passes of a footprint. ACROSS is met
                              within 1e-3 degrees */
    double scallop_mm;     /* WIDEST: material that may stay on the part; 0 (default): 0.01 mm */
} btg_solver_def;

BTG_API btg_solver_def btg_solver_def_default(void);

/* One finished position. Directions unit, NaN where a value does not exist (q and nq of a
 * single contact; everything but status and footprint when no contact). */
typedef struct btg_position {
    btg_status status;
    btg_vec3 tip;  /* CL point: torus centre - minor_radius * axis */
    btg_vec3 axis; /* unit, tip to holder */
    btg_contact p, q;
    double foot_x_mm, foot_y_mm;
    double drop_z_mm;       /* z of the torus centre after the vertical drop */
    double tilt_rad;        /* beta >= 0 */
    double spin_rad;        /* alpha */
    double inclination_rad; /* lambda: angle from nP to the axis in the pseudo-insert's plane */
    double bound_mm;        /* proven: nowhere deeper in the part than this; NaN: not proven */
    int spin_met; /* 1: the spin is the one asked for; WIDEST: there is a strip to compare */
} btg_position;

/* Bytes of workspace a run call needs for this part; the caller owns the memory, one workspace a
 * thread, aligned like malloc's. Depends on the part alone. */
BTG_API size_t btg_workspace_size(const btg_part *part);

/* The exact search: a tree of second-order bounds, then polish. Answers are within
 * solver->tolerance_mm: the tool, so placed, is nowhere deeper in the part.
 * Real-time: no allocation, lock or system call. Thread-safety: one workspace a thread.
 * Errors: ERROR_ARGUMENT (NULL, not finite, axis or frame not unit, workspace too small). */
BTG_API btg_status btg_drop(const btg_part *part, const btg_tool *tool,
                            const btg_solver_def *solver, const btg_drop_query *query,
                            void *workspace, size_t workspace_size, btg_drop_result *result);
BTG_API btg_status btg_tilt(const btg_part *part, const btg_tool *tool,
                            const btg_solver_def *solver, const btg_tilt_query *query,
                            void *workspace, size_t workspace_size, btg_tilt_result *result);

/* The same for btg_position_solve and _follow with a spin that is searched for (GAP, ACROSS,
 * WIDEST); the others need no more than btg_workspace_size. */
BTG_API size_t btg_position_workspace_size(const btg_part *part);

/* drop, spin and tilt over one footprint point: the whole position. Returns what
 * position->status holds, or an error. */
BTG_API btg_status btg_position_solve(const btg_part *part, const btg_tool *tool,
                                      const btg_solver_def *solver, double foot_x_mm,
                                      double foot_y_mm, void *workspace, size_t workspace_size,
                                      btg_position *position);

/* The same, started from the contacts of a neighbour on the path: quicker; the answer is the same
 * to the tolerance. A spin that is searched for starts from the neighbour's: quicker as well, and
 * of several spins that meet the aim it stays with the neighbour's; WIDEST then looks for the
 * widest strip near that spin alone. NULL or a neighbour without contacts: as btg_position_solve.
 */
BTG_API btg_status btg_position_follow(const btg_part *part, const btg_tool *tool,
                                       const btg_solver_def *solver, double foot_x_mm,
                                       double foot_y_mm, const btg_position *neighbour,
                                       void *workspace, size_t workspace_size,
                                       btg_position *position);

/* Width of the strip that a position machines, with feed and scallop of the solver. Cut the part by
 * vertical planes along the feed: a plane belongs to the strip when the part in it comes within
 * scallop_mm of the cutter. The strip is all such planes from P outward, and from Q, measured
 * horizontally across the feed, as side steps are; what lies between P and Q and is farther from
 * the cutter does not count. It is what one pass leaves within the scallop as long as the tool
 * stays to the part as it is.
 * Followed along the surface of each contact, over the patches of a B-spline, to the surface's
 * edge: another surface does not count, and a triangle stands for its plane. Within 1 % where the
 * strip ends inside a smooth surface. OSCULATING and SINGLE_CONTACT have the strip about P; without
 * contact the width is 0. Real-time: yes. ERROR_ARGUMENT as for the run calls. */
BTG_API btg_status btg_position_strip(const btg_part *part, const btg_tool *tool,
                                      const btg_solver_def *solver, const btg_position *position,
                                      double *width_mm);

/* ---- composing DROP and TILT (for back ends and batches) ---------------------------------- */

/* The DROP query over a footprint point: axis +z through (x, y, 0). */
BTG_API btg_drop_query btg_position_drop_query(double foot_x_mm, double foot_y_mm);

/* From a drop to the TILT query after it, spun where the spin is FIXED; a spin that is searched for
 * (GAP, ACROSS, WIDEST) is left to btg_position_solve and btg_backend_positions: these two calls
 * then are those of NONE. SINGLE_CONTACT: this first contact leaves no tilt (on
 * the flat, on the axis, by the shank, or by a ball); *tilt is then untouched. */
BTG_API btg_status btg_position_tilt_query(const btg_tool *tool, const btg_solver_def *solver,
                                           const btg_drop_query *query, const btg_drop_result *drop,
                                           btg_tilt_query *tilt);

/* Puts the answers together. `tilt` may be NULL: then a single contact, as dropped. */
BTG_API btg_status btg_position_assemble(const btg_tool *tool, const btg_solver_def *solver,
                                         double foot_x_mm, double foot_y_mm,
                                         const btg_drop_query *drop_query,
                                         const btg_drop_result *drop,
                                         const btg_tilt_query *tilt_query,
                                         const btg_tilt_result *tilt, btg_position *position);

/* Signed distance of a point to the placed tool, mm: < 0 inside. Torus, flat, shank and holder. */
BTG_API double btg_tool_distance(const btg_tool *tool, btg_vec3 torus_centre, btg_vec3 axis,
                                 btg_vec3 point);

/* ---- footprint --------------------------------------------------------------------------- */

typedef enum btg_footprint_kind {
    BTG_FOOTPRINT_PARALLEL = 0, /* passes along +y at xmin, xmin+side, ..., and a last at xmax */
    BTG_FOOTPRINT_ZIGZAG = 1,   /* the same, every second pass along -y */
    BTG_FOOTPRINT_ONE_WAY = 2   /* parallel, with a lift at both ends of each pass */
} btg_footprint_kind;

typedef struct btg_footprint_def {
    uint32_t version;
    btg_footprint_kind kind; /* default parallel */
    double x_min_mm, x_max_mm, y_min_mm, y_max_mm;
    double side_step_mm;    /* > 0, default 18 */
    double forward_step_mm; /* > 0, default 2 */
} btg_footprint_def;

BTG_API btg_footprint_def btg_footprint_def_default(void);

typedef struct btg_footprint_point {
    uint32_t pass, point; /* from 0; a lift carries the numbers of the point it belongs to */
    double x_mm, y_mm;
    int lift; /* 1: retract above this point */
} btg_footprint_point;

#define BTG_FOOTPRINT_MAX 100000000 /* points; more is refused: a step is too small */

/* Number of points; ERROR_ARGUMENT with a message when a step is not positive and finite, the
 * rectangle is not finite or reversed, or there are more than BTG_FOOTPRINT_MAX. */
BTG_API btg_status btg_footprint_count(const btg_footprint_def *def, size_t *count,
                                       btg_message *message);
/* Writes exactly that many points. */
BTG_API btg_status btg_footprint_fill(const btg_footprint_def *def, btg_footprint_point *points,
                                      size_t capacity);

#ifdef __cplusplus
}
#endif
#endif
