/* The cutter on triangles, one by one: closed form on faces and vertices, golden sections along
 * edges. The tilt is found as the depth method does, by dropping the turned tool again: no
 * circular rays. Nothing is shared with the library's solver but the vectors. */
#include "app/bench.h"
#include "core/vec.h"

#include <stdlib.h>
#include <string.h>

/* Samples of an edge: a few, and that many over the cutter's reach. */
#define EDGE_SAMPLES_MIN 4
#define EDGE_SAMPLES     64
#define GOLDEN           0.6180339887498949
#define GOLDEN_STEPS     44 /* 0.618^44 = 6e-10 of an edge: the height is then good to rounding */
/* A gouge of less, mm, is rounding. */
#define GOUGE_MIN 1e-9
/* First turn beyond a tilt, rad, in looking for where the tool gouges. */
#define TURN_MIN 1e-8

typedef struct cutter {
    double major, minor;
    bool hollow;
} cutter;

typedef struct rest {
    double height;
    btg_vec3 contact; /* in the cutter's frame */
} rest;

static cutter cutter_of(const btg_tool *tool) {
    const btg_tool_def *d = &tool->def;
    return (cutter){d->major_radius_mm, d->minor_radius_mm, d->profile == BTG_PROFILE_TOROIDAL};
}

/* Height of the torus centre over a point at that distance from the axis when both touch. */
static double rise(const cutter *c, double r) {
    if (r < c->major && !c->hollow) return c->minor;
    double d = c->minor * c->minor - (r - c->major) * (r - c->major);
    return d >= 0 ? sqrt(d) : -INFINITY;
}

static void meet(const cutter *c, btg_vec3 s, rest *best) {
    double height = s.z + rise(c, hypot(s.x, s.y));
    if (height > best->height) *best = (rest){height, s};
}

static double along(const cutter *c, btg_vec3 a, btg_vec3 d, double t) {
    return a.z + t * d.z + rise(c, hypot(a.x + t * d.x, a.y + t * d.y));
}

static void golden(const cutter *c, btg_vec3 a, btg_vec3 d, double lo, double hi, rest *best) {
    double x = hi - GOLDEN * (hi - lo), y = lo + GOLDEN * (hi - lo);
    double fx = along(c, a, d, x), fy = along(c, a, d, y);
    for (int i = 0; i < GOLDEN_STEPS; i++) {
        if (fx >= fy) {
            hi = y, y = x, fy = fx;
            x = hi - GOLDEN * (hi - lo);
            fx = along(c, a, d, x);
        } else {
            lo = x, x = y, fx = fy;
            y = lo + GOLDEN * (hi - lo);
            fy = along(c, a, d, y);
        }
    }
    meet(c, vec_mad(a, d, 0.5 * (lo + hi)), best);
}

/* Whether a point of the edge may rest higher than the best: the ring is nowhere nearer to the
 * edge than its ends are, less its length. */
static bool edge_may_win(const cutter *c, btg_vec3 a, btg_vec3 b, double length, double best) {
    double ra = hypot(a.x, a.y), rb = hypot(b.x, b.y);
    double away = fmin(fabs(ra - c->major), fabs(rb - c->major)) - length;
    bool flat = !c->hollow && fmin(ra, rb) - length < c->major;
    if (flat || away < 0) away = 0;
    if (away > c->minor) return false;
    return fmax(a.z, b.z) + sqrt(c->minor * c->minor - away * away) > best;
}

static void edge(const cutter *c, btg_vec3 a, btg_vec3 b, rest *best) {
    double reach = c->major + c->minor;
    btg_vec3 d = vec_sub(b, a);
    double length = hypot(d.x, d.y);
    if (length == 0 || !edge_may_win(c, a, b, length, best->height)) return;
    /* The part of the edge under the cutter. */
    double k = -(a.x * d.x + a.y * d.y) / (length * length);
    double off = hypot(a.x + k * d.x, a.y + k * d.y);
    if (off >= reach) return;
    double half = sqrt(reach * reach - off * off) / length;
    double lo = fmax(0, k - half), hi = fmin(1, k + half);
    if (lo >= hi) return;
    int n = EDGE_SAMPLES_MIN + (int)(EDGE_SAMPLES * (hi - lo) * length / reach);
    double step = (hi - lo) / n, before = -INFINITY, here = along(c, a, d, lo);
    for (int i = 0; i <= n; i++) {
        double after = i < n ? along(c, a, d, lo + (i + 1) * step) : -INFINITY;
        if (here >= before && here >= after && here > -INFINITY)
            golden(c, a, d, fmax(lo, lo + (i - 1) * step), fmin(hi, lo + (i + 1) * step), best);
        before = here;
        here = after;
    }
}

static double side_of(btg_vec3 a, btg_vec3 b, double x, double y) {
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

/* A plane touches the torus where both have one normal. */
static void face(const cutter *c, const btg_vec3 k[3], rest *best) {
    btg_vec3 n = vec_unit(vec_cross(vec_sub(k[1], k[0]), vec_sub(k[2], k[0])));
    if (n.z < 0) n = vec_scale(n, -1);
    double slope = hypot(n.x, n.y);
    if (n.z < 1e-9) return;
    btg_vec3 e = slope > 0 ? vec(n.x / slope, n.y / slope, 0) : vec(1, 0, 0);
    btg_vec3 s = vec_add(vec_scale(e, -c->major), vec_scale(n, -c->minor));
    double p = side_of(k[0], k[1], s.x, s.y), q = side_of(k[1], k[2], s.x, s.y);
    double r = side_of(k[2], k[0], s.x, s.y);
    if (!((p >= 0 && q >= 0 && r >= 0) || (p <= 0 && q <= 0 && r <= 0))) return;
    s.z = k[0].z - (n.x * (s.x - k[0].x) + n.y * (s.y - k[0].y)) / n.z;
    double height = s.z + c->minor * n.z;
    if (height > best->height) *best = (rest){height, s};
}

static bool near(const btg_vec3 k[3], double reach) {
    double x0 = fmin(k[0].x, fmin(k[1].x, k[2].x)), x1 = fmax(k[0].x, fmax(k[1].x, k[2].x));
    double y0 = fmin(k[0].y, fmin(k[1].y, k[2].y)), y1 = fmax(k[0].y, fmax(k[1].y, k[2].y));
    return x0 < reach && x1 > -reach && y0 < reach && y1 > -reach;
}

typedef struct frame {
    btg_vec3 origin, x, y, z;
} frame;

static void corners(const bench_mesh *mesh, const frame *f, size_t triangle, btg_vec3 k[3]) {
    for (int i = 0; i < 3; i++) {
        const double *s = mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + (size_t)i];
        btg_vec3 d = vec_sub(vec(s[0], s[1], s[2]), f->origin);
        k[i] = vec(vec_dot(d, f->x), vec_dot(d, f->y), vec_dot(d, f->z));
    }
}

double bench_brute_drop(const bench_mesh *mesh, const btg_tool *tool, btg_vec3 origin,
                        btg_vec3 axis, btg_vec3 *contact) {
    cutter c = cutter_of(tool);
    frame f = {origin, vec_perpendicular(axis), vec(0, 0, 0), axis};
    f.y = vec_cross(axis, f.x);
    rest best = {-INFINITY, vec(0, 0, 0)};
    /* Vertices and faces first: then few edges can rest higher. */
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < mesh->triangle_count; i++) {
            btg_vec3 k[3];
            corners(mesh, &f, i, k);
            if (!near(k, c.major + c.minor)) continue;
            if (pass == 0) face(&c, k, &best);
            for (int j = 0; j < 3; j++) {
                if (pass == 0) meet(&c, k[j], &best);
                if (pass == 1) edge(&c, k[j], k[(j + 1) % 3], &best);
            }
        }
    }
    if (contact) {
        *contact = vec_mad(origin, f.x, best.contact.x);
        *contact = vec_mad(*contact, f.y, best.contact.y);
        *contact = vec_mad(*contact, f.z, best.contact.z);
    }
    return best.height;
}

/* ---- the tilt ------------------------------------------------------------------------------ */

typedef struct turning {
    bench_mesh mesh; /* what the turning tool can reach */
    const btg_tool *tool;
    btg_vec3 u, v, w, o1;
} turning;

static void turned(const turning *t, double beta, btg_vec3 *centre, btg_vec3 *axis) {
    double c = cos(beta), s = sin(beta);
    btg_vec3 v = vec_sub(vec_scale(t->v, c), vec_scale(t->w, s));
    *axis = vec_add(vec_scale(t->w, c), vec_scale(t->v, s));
    *centre = vec_mad(t->o1, v, t->tool->def.major_radius_mm);
}

/* How deep the tool cuts along its axis, turned by beta; < 0: how far it is clear. */
static double depth(const turning *t, double beta, btg_vec3 *contact) {
    btg_vec3 centre, axis;
    turned(t, beta, &centre, &axis);
    return bench_brute_drop(&t->mesh, t->tool, centre, axis, contact);
}

static bool reachable(const bench_mesh *mesh, size_t triangle, btg_vec3 o1, double reach) {
    for (int axis = 0; axis < 3; axis++) {
        double lo = INFINITY, hi = -INFINITY;
        double middle = axis == 0 ? o1.x : axis == 1 ? o1.y : o1.z;
        for (size_t i = 0; i < 3; i++) {
            double x = mesh->positions[3 * (size_t)mesh->indices[3 * triangle + i] + (size_t)axis];
            lo = fmin(lo, x);
            hi = fmax(hi, x);
        }
        if (lo > middle + reach || hi < middle - reach) return false;
    }
    return true;
}

static bool gather(turning *t, const bench_mesh *mesh) {
    double reach = 2 * t->tool->def.major_radius_mm + t->tool->def.minor_radius_mm;
    size_t n = 0;
    for (size_t i = 0; i < mesh->triangle_count; i++)
        n += reachable(mesh, i, t->o1, reach);
    t->mesh = (bench_mesh){mesh->positions, malloc((n + 1) * 3 * sizeof *mesh->indices),
                           mesh->vertex_count, 0};
    if (!t->mesh.indices) return false;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        if (!reachable(mesh, i, t->o1, reach)) continue;
        memcpy(t->mesh.indices + 3 * t->mesh.triangle_count++, mesh->indices + 3 * i,
               3 * sizeof *mesh->indices);
    }
    return true;
}

/* The largest turn from beta on, up to `most`, before the tool gouges, and the place where it then
 * does. */
static double free_turn(const turning *t, double beta, double most, btg_vec3 *contact) {
    double clear = 0, turn = TURN_MIN;
    while (depth(t, fmin(beta + turn, most), contact) <= GOUGE_MIN) {
        if (beta + turn >= most) return most - beta;
        clear = turn;
        turn *= 2;
    }
    while (turn - clear > 1e-3 * turn && turn > TURN_MIN) {
        double middle = 0.5 * (clear + turn);
        if (depth(t, beta + middle, contact) <= GOUGE_MIN) {
            clear = middle;
        } else {
            turn = middle;
        }
    }
    depth(t, fmin(beta + turn, most), contact);
    return clear;
}

/* How fast the tool comes nearer to a point on it when it turns, mm a radian. */
static double lever(const turning *t, double beta, btg_vec3 point) {
    btg_vec3 centre, axis;
    turned(t, beta, &centre, &axis);
    btg_vec3 arm = vec_sub(point, centre);
    btg_vec3 radial = vec_unit(vec_mad(arm, axis, -vec_dot(arm, axis)));
    btg_vec3 n = vec_unit(vec_mad(arm, radial, -t->tool->def.major_radius_mm));
    return fabs(vec_dot(vec_cross(t->u, vec_sub(point, t->o1)), n));
}

static double tilt_error(const turning *t, const btg_solver_def *solver, const btg_position *p) {
    double minor = t->tool->def.minor_radius_mm;
    if (!vec_finite(p->tip) || !vec_finite(p->axis) || !isfinite(p->tilt_rad)) return INFINITY;
    bool single = p->status == BTG_SINGLE_CONTACT;
    double beta = single ? 0 : p->tilt_rad, most = solver->max_tilt_rad;
    btg_vec3 centre, axis, contact;
    turned(t, beta, &centre, &axis);
    double error = vec_norm(vec_sub(vec_mad(centre, axis, -minor), p->tip));
    double size = t->tool->def.major_radius_mm + minor;
    error = fmax(error, size * vec_norm(vec_sub(axis, p->axis)));
    error = fmax(error, depth(t, beta, NULL));
    double further = free_turn(t, beta, most, &contact);
    if (single) further = most - further; /* free all the way is right */
    if (further > 0) error = fmax(error, further * lever(t, beta + further, contact));
    return error;
}

bench_error bench_brute_error(const bench_mesh *mesh, const btg_tool *tool,
                              const btg_solver_def *solver, const btg_position *p) {
    btg_vec3 origin = vec(p->foot_x_mm, p->foot_y_mm, 0);
    double height = bench_brute_drop(mesh, tool, origin, vec(0, 0, 1), NULL);
    double drop = fabs(p->drop_z_mm - height);
    if (p->status == BTG_NO_CONTACT) drop = height > -INFINITY ? INFINITY : 0;
    bench_error error = {drop, drop};
    double major = tool->def.major_radius_mm, minor = tool->def.minor_radius_mm;
    if (!(drop < INFINITY) || major == 0 || minor == 0 || p->status == BTG_NO_CONTACT) return error;
    turning t = {.tool = tool, .w = vec(0, 0, 1)};
    btg_vec3 centre = vec(p->foot_x_mm, p->foot_y_mm, p->drop_z_mm);
    btg_vec3 arm = vec_sub(centre, p->p.point);
    arm.z = 0;
    /* A first contact on the flat leaves no tilt. */
    bool flat = tool->def.profile == BTG_PROFILE_BULLNOSE && vec_norm(arm) <= major;
    if (flat) return error;
    t.v = vec_unit(arm);
    t.u = vec_cross(t.v, t.w);
    t.o1 = vec_mad(centre, t.v, -major);
    error.position_mm = INFINITY;
    if (!gather(&t, mesh)) return error;
    error.position_mm = fmax(drop, tilt_error(&t, solver, p));
    free(t.mesh.indices);
    return error;
}
