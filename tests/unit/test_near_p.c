/* The proven bound where several faces meet at the first contact: on seams of patches, on creases,
 * at vertices and edges of meshes, with steps, slivers and second sheets as near P as its
 * clearance. The bound is at most the tolerance asked, and nothing is deeper: dense samples say
 * so, about P at all scales. */
#include "check.h"
#include "core/ray.h"
#include "core/spin.h"
#include "hard_depth.h"
#include "hard_parts.h"

#include <stdlib.h>

#define ROUNDS 200
#define PLACES 3
#define SIZE   40.0 /* of a part, mm */
#define HEIGHT 5.0
#define BUDGET 20000
#define ITEMS  64 /* that meet a point, at most */
/* Rounding of the check itself, mm. */
#define ROUNDING 1e-12
/* An item meets a point that it comes this near to, mm. */
#define MEETS 1e-9
/* Rings of samples about P, mm. */
#define RING_LEAST 1e-7
#define RING_MOST  0.3
#define RING_STEP  2.0
#define SPOKES     12

/* Tops: rays start and end that far from P, in minor radii. */
#define TOPS       1500
#define TOP_FROM   2e-3
#define TOP_TO     0.03
#define TOP_STEP   1.1
#define TOP_SPOKES 60
#define TOP_SLACK  1e-7 /* rad */

typedef enum shape { SEAM, FAN, MICRO, LAYERS, STRIPS, SHAPES } shape;

typedef struct setting {
    btg_part *part;
    hard_field field;
    btg_tool tool;
    btg_solver_def solver;
    void *workspace;
    size_t size;
} setting;

static long tilts, at_place, several, osculating, short_of;
static double most_of_tolerance, most_of_bound;
static long tops, tops_at_edge;
static double most_missed;
static uint32_t most_nodes;
static double all_nodes;

/* Evenly spread over powers of ten. */
static double power(rng *r, double low, double high) {
    return pow(10, rng_range(r, low, high));
}

/* ---- parts: they meet at (0, 0, HEIGHT) --------------------------------------------------- */

/* A bicubic patch over [0, w] x [0, h] (w, h of any sign), its height a polynomial in x, y. */
static void add_graph(model *m, double w, double h, double a[4][4]) {
    static const double choose[4][4] = {{1}, {1, 1}, {1, 2, 1}, {1, 3, 3, 1}};
    model_surface s = model_bezier(m, 3, 3, false);
    for (int k = 0; k < 4; k++)
        for (int l = 0; l < 4; l++) {
            double z = 0;
            for (int i = 0; i <= k; i++)
                for (int j = 0; j <= l; j++)
                    z += choose[k][i] * choose[l][j] / (choose[3][i] * choose[3][j]) * a[i][j] *
                         pow(w, i) * pow(h, j);
            double *p = s.points + 3 * (4 * k + l);
            p[0] = w * k / 3;
            p[1] = h * l / 3;
            p[2] = HEIGHT + z;
        }
}

/* Four patches in one piece but for a crease and a jump of the curvature along either axis; some
 * creases are next to none. */
static void add_seam(model *m, rng *r) {
    double a[4][4] = {{0}}, crease[2] = {0, 0}, jump[2] = {0, 0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            if (i + j > 0) a[i][j] = rng_range(r, -1, 1) * 0.3 * pow(0.08, i + j - 1);
    a[2][0] -= 0.02;
    a[0][2] -= 0.02;
    int kind = rng_pick(r, 4);
    for (int k = 0; k < 2; k++) {
        if (kind == 1) crease[k] = -rng_range(r, 0, 0.5);
        if (kind == 2) crease[k] = -power(r, -9, -2);
        if (kind > 0) jump[k] = rng_range(r, -0.02, 0.02);
    }
    for (int side = 0; side < 4; side++) {
        double b[4][4];
        for (int i = 0; i < 16; i++)
            b[i / 4][i % 4] = a[i / 4][i % 4];
        int x = side % 2 ? 1 : -1, y = side / 2 ? 1 : -1;
        b[1][0] += x * crease[0];
        b[2][0] += x * jump[0];
        b[0][1] += y * crease[1];
        b[0][2] += y * jump[1];
        add_graph(m, x * SIZE / 2, y * SIZE / 2, b);
    }
}

/* Triangles about a vertex: a peak, a ridge's end, a saddle, or nearly flat; slivers and a spike
 * now and then. */
static void add_fan(model *m, rng *r) {
    enum { MOST = 12 };
    int count = 3 + rng_pick(r, MOST - 2), kind = rng_pick(r, 4);
    double steep = kind == 0 ? rng_range(r, 0.3, 4) : power(r, -9, 0), radius = SIZE / 2;
    if (kind == 1) radius = power(r, -4, 0);
    btg_vec3 centre = vec(0, 0, HEIGHT), ring[MOST];
    for (int i = 0; i < count; i++) {
        double turn = 2 * BTG_PI * (i + rng_range(r, -0.45, 0.45)) / count;
        if (kind == 3 && i % 2) turn = 2 * BTG_PI * (i - 1 + power(r, -6, -1)) / count;
        double fall = steep * rng_range(r, kind == 2 ? -0.2 : 0.1, 1) * radius;
        ring[i] = vec(radius * cos(turn), radius * sin(turn), HEIGHT - fall);
    }
    for (int i = 0; i < count; i++)
        model_triangle(m, centre, ring[i], ring[(i + 1) % count]);
    if (kind != 1) return;
    double low = HEIGHT - radius * steep - rng_range(r, 0.01, 3); /* what the small fan stands on */
    model_quad(m, vec(-SIZE, -SIZE, low), vec(-SIZE, SIZE, low), vec(SIZE, -SIZE, low),
               vec(SIZE, SIZE, low));
}

/* A grid as fine as the clearance about P, as rough as the tool's turn about P bends. */
static void add_micro(model *m, rng *r) {
    enum { SIDE = 10 };
    btg_vec3 p[SIDE + 1][SIDE + 1];
    double step = power(r, -5, -1), rough = step * step * power(r, -2, 1);
    double bend[3] = {rng_range(r, -0.02, 0.15), rng_range(r, -0.05, 0.05),
                      rng_range(r, -0.02, 0.15)};
    for (int i = 0; i <= SIDE; i++)
        for (int k = 0; k <= SIDE; k++) {
            double x = step * (i - SIDE / 2), y = step * (k - SIDE / 2);
            double z = -(bend[0] * x * x + bend[1] * x * y + bend[2] * y * y) / 2;
            p[i][k] = vec(x, y, HEIGHT + z + rough * rng_range(r, -1, 1));
        }
    for (int i = 0; i < SIDE; i++)
        for (int k = 0; k < SIDE; k++) {
            model_triangle(m, p[i][k], p[i + 1][k], p[i][k + 1]);
            model_triangle(m, p[i + 1][k], p[i + 1][k + 1], p[i][k + 1]);
        }
    double w = SIZE / 2;
    if (rng_pick(r, 2)) /* a pillar beside it, for Q */
        model_triangle(m, vec(w / 2, -w, HEIGHT - 1), vec(w / 2, w, HEIGHT - 1),
                       vec(w, 0, HEIGHT - 4));
}

/* A patch, and others just below that bend less: the tilted tool meets them near P. */
static void add_layers(model *m, rng *r) {
    double a[4][4] = {{0}};
    a[1][0] = rng_range(r, -0.5, 0.5);
    a[0][1] = rng_range(r, -0.5, 0.5);
    int count = 2 + rng_pick(r, 4);
    double bend = rng_range(r, 0.02, 0.12), gap = 0;
    for (int n = 0; n < count; n++) {
        a[0][0] = -gap;
        a[2][0] = -bend * rng_range(r, 0.5, 1) / 2;
        a[0][2] = -bend * rng_range(r, 0.5, 1) / 2;
        a[1][1] = bend * rng_range(r, -0.3, 0.3);
        add_graph(m, n % 2 ? -SIZE / 2 : SIZE / 2, n / 2 % 2 ? -SIZE / 2 : SIZE / 2, a);
        bend *= rng_range(r, 0.3, 1);
        gap += power(r, -9, -2);
    }
}

/* A bent strip in facets: long edges side by side, some all but none. */
static void add_strips(model *m, rng *r) {
    double x = -3, z = HEIGHT, slope = rng_range(r, 0, 0.6), w = SIZE / 2;
    double lean = rng_range(r, -0.2, 0.2);
    while (x < 3) {
        double width = power(r, -3, 0.5), next = x + width, low = z + slope * width;
        btg_vec3 c[4] = {vec(x, -w, z - lean * w), vec(x, w, z + lean * w),
                         vec(next, -w, low - lean * w), vec(next, w, low + lean * w)};
        if (rng_pick(r, 2)) {
            model_quad(m, c[0], c[1], c[2], c[3]);
        } else {
            model_triangle(m, c[0], c[2], c[1]);
            model_triangle(m, c[2], c[3], c[1]);
        }
        x = next;
        z = low;
        slope -= rng_pick(r, 3) ? rng_range(r, 0, 0.2) : power(r, -10, -3);
    }
}

static void open_model(setting *s, model *m) {
    s->part = model_part(m);
    model_free(m);
    s->field = hard_field_make(s->part);
    s->size = btg_workspace_size(s->part);
    s->workspace = malloc(s->size);
    if (!s->workspace) abort();
}

static void open_part(setting *s, rng *r, shape kind) {
    static void (*const add[SHAPES])(model *, rng *) = {add_seam, add_fan, add_micro, add_layers,
                                                        add_strips};
    model m = {0};
    add[kind](&m, r);
    open_model(s, &m);
}

static void close_part(setting *s) {
    free(s->workspace);
    hard_field_free(&s->field);
    btg_part_destroy(s->part);
}

static void choose_tool(setting *s, rng *r) {
    static const struct {
        double major, minor;
        btg_profile profile;
        btg_cylinder shank;
    } tools[] = {{6.7, 6, BTG_PROFILE_TOROIDAL, {0, 0, 0}},
                 {2, 5, BTG_PROFILE_TOROIDAL, {0, 0, 0}},
                 {10, 3, BTG_PROFILE_TOROIDAL, {0, 0, 0}},
                 {8, 2, BTG_PROFILE_BULLNOSE, {0, 0, 0}},
                 {0, 6, BTG_PROFILE_TOROIDAL, {0, 0, 0}},
                 {6.05, 6, BTG_PROFILE_TOROIDAL, {0, 0, 0}}, /* all but no hole */
                 {30, 200, BTG_PROFILE_TOROIDAL, {0, 0, 0}},
                 {200, 30, BTG_PROFILE_BULLNOSE, {0, 0, 0}},
                 {10, 0, BTG_PROFILE_BULLNOSE, {0, 0, 0}},
                 {10, 0.01, BTG_PROFILE_BULLNOSE, {0, 0, 0}},
                 {6.7, 6, BTG_PROFILE_TOROIDAL, {14, 0.5, 40}}};
    int which = rng_pick(r, (int)(sizeof tools / sizeof *tools));
    btg_tool_def def = btg_tool_def_default();
    def.major_radius_mm = tools[which].major;
    def.minor_radius_mm = tools[which].minor;
    def.profile = tools[which].profile;
    def.shank = tools[which].shank;
    if (btg_tool_init(&def, &s->tool, NULL) != BTG_OK) exit(2);
}

/* ---- places where items meet ------------------------------------------------------------- */

typedef struct meeting {
    btg_vec3 point;
    btg_place place[ITEMS]; /* one an item */
    int count;
} meeting;

static meeting meeting_at(const btg_part *part, btg_vec3 point, double gap) {
    meeting m = {.point = point};
    uint32_t items = part->patch_count + part->triangle_count;
    for (uint32_t i = 0; i < items && m.count < ITEMS; i++)
        m.count += hard_nearest(part, i, point, &m.place[m.count]) < gap;
    return m;
}

/* A corner or a place on a side of some item. */
static btg_vec3 border_point(const btg_part *part, rng *r) {
    btg_place at = {(uint32_t)rng_pick(r, (int)(part->patch_count + part->triangle_count)), 0, 0};
    double along = rng_pick(r, 2) ? power(r, -7, 0) : 0;
    int side = rng_pick(r, 3);
    if (side == 0) at.u = along;
    if (side == 1) at.v = along;
    if (side == 2) at.u = along, at.v = at.item < part->patch_count ? 1 : 1 - along;
    return hard_point(part, at);
}

static btg_vec3 up_normal(const btg_part *part, btg_place place) {
    btg_surface_point s;
    btg_part_point(part, place, &s);
    btg_vec3 n = vec_unit(vec_cross(s.su, s.sv));
    return n.z < 0 ? vec_scale(n, -1) : n;
}

/* The foot of a tool that, where nothing is in its way, comes down on the meeting with a normal
 * between those of its items. */
static void foot_over(const setting *s, rng *r, const meeting *m, double *x, double *y) {
    btg_vec3 n = vec(0, 0, 1e-9);
    int only = rng_pick(r, m->count + 2); /* now and then a face's own */
    for (int i = 0; i < m->count; i++) {
        double weight = rng_range(r, 0, 1);
        if (only < m->count && i != only) weight = 0;
        n = vec_mad(n, up_normal(s->part, m->place[i]), weight);
    }
    n = vec_unit(n);
    double ro = s->tool.def.major_radius_mm, ri = s->tool.def.minor_radius_mm;
    double turn = rng_range(r, 0, 2 * BTG_PI), level = norm2(n.x, n.y);
    btg_vec3 out = level > 1e-6 ? vec(n.x / level, n.y / level, 0) : vec(cos(turn), sin(turn), 0);
    bool hollow = s->tool.def.profile == BTG_PROFILE_TOROIDAL;
    double side = hollow && rng_pick(r, 3) == 0 ? -ro : ro;
    *x = m->point.x + ri * n.x + side * out.x;
    *y = m->point.y + ri * n.y + side * out.y;
}

/* ---- checks ------------------------------------------------------------------------------- */

/* The least distance on rings about one item's place, and downhill from there. */
static double least_about(const setting *s, const hard_pose *pose, btg_place at) {
    btg_surface_point f;
    btg_part_point(s->part, at, &f);
    double su = vec_norm(f.su), sv = vec_norm(f.sv), least = INFINITY, step = 0;
    bool triangle = at.item >= s->part->patch_count;
    btg_place from = at;
    if (!(su > 0 && sv > 0)) return INFINITY;
    for (double ring = RING_LEAST; ring < RING_MOST; ring *= RING_STEP)
        for (int k = 0; k < SPOKES; k++) {
            double turn = 2 * BTG_PI * k / SPOKES;
            btg_place to = {at.item, at.u + ring * cos(turn) / su, at.v + ring * sin(turn) / sv};
            to.u = min2(max2(to.u, 0), 1);
            to.v = min2(max2(to.v, 0), triangle ? 1 - to.u : 1);
            double d = hard_distance(&s->field, pose, to);
            if (!(d < least)) continue;
            least = d;
            from = to;
            step = ring / max2(su, sv);
        }
    return hard_descend(&s->field, pose, from, step);
}

static void check_pose(const setting *s, const hard_pose *pose, double bound, const meeting *at_p) {
    double depth = -hard_least_distance(&s->field, pose, NULL);
    for (int i = 0; i < at_p->count; i++)
        depth = max2(depth, -least_about(s, pose, at_p->place[i]));
    CHECK(bound >= 0 && bound <= s->solver.tolerance_mm + 1.1e-12 * s->part->scale);
    CHECK(depth <= bound + ROUNDING);
    if (!(depth <= bound + ROUNDING && bound <= s->solver.tolerance_mm + 1.1e-12 * s->part->scale))
        fprintf(
            stderr,
            "depth %.6g, bound %.6g, tolerance %g; tool %g %g, centre %a %a %a, axis %a %a %a\n",
            depth, bound, s->solver.tolerance_mm, s->tool.def.major_radius_mm,
            s->tool.def.minor_radius_mm, pose->centre.x, pose->centre.y, pose->centre.z,
            pose->axis.x, pose->axis.y, pose->axis.z);
    most_of_tolerance = max2(most_of_tolerance, bound / s->solver.tolerance_mm);
    most_of_bound = max2(most_of_bound, depth / bound);
}

static void check_foot(const setting *s, const meeting *m, double x, double y) {
    btg_drop_query query = btg_position_drop_query(x, y);
    btg_drop_result drop = {0};
    btg_tilt_query f;
    btg_tilt_result tilt = {0};
    btg_status status =
        btg_drop(s->part, &s->tool, &s->solver, &query, s->workspace, s->size, &drop);
    CHECK(status == BTG_OK || status == BTG_NO_CONTACT || status == BTG_BUDGET);
    if (status != BTG_OK) return;
    meeting at_p = meeting_at(s->part, drop.contact.point, 10 * RING_MOST);
    hard_pose pose = {&s->tool, vec(x, y, drop.height_mm), query.axis};
    check_pose(s, &pose, drop.bound_mm, &at_p);
    if (btg_position_tilt_query(&s->tool, &s->solver, &query, &drop, &f) != BTG_OK) return;
    status = btg_tilt(s->part, &s->tool, &s->solver, &f, s->workspace, s->size, &tilt);
    CHECK(status >= 0);
    if (status < 0) return;
    tilts++;
    bool here = vec_norm(vec_sub(drop.contact.point, m->point)) < 1e-6;
    at_place += here;
    several += here && m->count > 1;
    osculating += status == BTG_OSCULATING;
    short_of += status == BTG_BUDGET;
    if (tilt.nodes > most_nodes) most_nodes = tilt.nodes;
    all_nodes += tilt.nodes;
    btg_position_pose(&s->tool, &f, tilt.tilt_rad, &pose.centre, &pose.axis);
    check_pose(s, &pose, tilt.bound_mm, &at_p);
}

/* ---- tops near P ---- */

/* The largest value of the rays about P on a patch, and where. */
static double top_about(const setting *s, const btg_ray_query *q, btg_place at, btg_place *top) {
    double from = TOP_FROM * s->tool.def.minor_radius_mm, to_way = TOP_TO / TOP_FROM * from;
    btg_surface_point f;
    btg_part_point(s->part, at, &f);
    double su = vec_norm(f.su), sv = vec_norm(f.sv), most = -INFINITY;
    for (double ring = from; ring < to_way; ring *= TOP_STEP)
        for (int k = 0; k < TOP_SPOKES; k++) {
            double turn = 2 * BTG_PI * k / TOP_SPOKES;
            btg_place to = {at.item, at.u + ring * cos(turn) / su, at.v + ring * sin(turn) / sv};
            to.u = min2(max2(to.u, 0), 1);
            to.v = min2(max2(to.v, 0), 1);
            btg_vec3 point = hard_point(s->part, to);
            btg_ray_hit hit;
            if (vec_norm(vec_sub(point, q->p)) < from) continue;
            if (!btg_ray_cast(q, point, &hit) || !(hit.value > most)) continue;
            most = hit.value;
            *top = to;
        }
    return most;
}

/* A bent patch, and a foot that brings P close to its corner. */
static void open_corner(setting *s, rng *r, double *x, double *y) {
    double a[4][4] = {{0}};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            if (i + j > 0) a[i][j] = rng_range(r, -1, 1) * 0.3 * pow(0.1, i + j - 1);
    a[2][0] -= 0.05;
    a[0][2] -= 0.05;
    model m = {0};
    add_graph(&m, SIZE / 2, SIZE / 2, a);
    open_model(s, &m);
    s->tool = hard_tool(rng_pick(r, 3));
    double off = power(r, -2.5, -0.5) / SIZE;
    meeting at = {.count = 1, .place = {{0, off, off * rng_range(r, 0, 1)}}};
    at.point = hard_point(s->part, at.place[0]);
    foot_over(s, r, &at, x, y);
}

static void check_top(const setting *s, double x, double y) {
    btg_drop_query query = btg_position_drop_query(x, y);
    btg_drop_result drop;
    btg_tilt_query f;
    btg_tilt_result tilt;
    if (btg_drop(s->part, &s->tool, &s->solver, &query, s->workspace, s->size, &drop) != BTG_OK ||
        btg_position_tilt_query(&s->tool, &s->solver, &query, &drop, &f) != BTG_OK)
        return;
    btg_status status = btg_tilt(s->part, &s->tool, &s->solver, &f, s->workspace, s->size, &tilt);
    if (status != BTG_OK && status != BTG_OSCULATING) return;
    btg_ray_query q = btg_ray_query_tilt(&s->tool, &f);
    btg_place top = {0};
    /* above 0: what the drop's tolerance leaves */
    double missed = min2(top_about(s, &q, drop.contact.place, &top), 0) + tilt.tilt_rad;
    CHECK(missed <= TOP_SLACK);
    most_missed = max2(most_missed, missed);
    tops++;
    tops_at_edge += top.u == 0 || top.v == 0;
}

/* All but osculating tilts with P close to the corner of a patch: the value rises from P by less
 * than the search's clearance shows, to a top that may stand on the patch's edge. */
static void check_tops(rng *r) {
    setting s = {.solver = btg_solver_def_default()};
    double x, y;
    open_corner(&s, r, &x, &y);
    check_top(&s, x, y);
    close_part(&s);
}

int main(void) {
    static const double tolerance[] = {1e-3, 1e-5, 1e-6, 1e-7, 1e-9};
    int rounds = hard_rounds(ROUNDS);
    for (int i = 0; i < rounds; i++) {
        rng r = rng_of(1, "near p", (uint64_t)i);
        setting s = {.solver = btg_solver_def_default()};
        s.solver.node_budget = BUDGET;
        open_part(&s, &r, (shape)(i % SHAPES));
        for (int k = 0; k < PLACES; k++) {
            double x, y;
            choose_tool(&s, &r);
            meeting m = meeting_at(s.part, border_point(s.part, &r), MEETS);
            foot_over(&s, &r, &m, &x, &y);
            for (size_t t = 0; t < sizeof tolerance / sizeof *tolerance; t++) {
                s.solver.tolerance_mm = tolerance[t];
                check_foot(&s, &m, x, y);
            }
        }
        close_part(&s);
    }
    printf("%ld tilts, %ld with P where it was sought, %ld of them where items meet; %ld "
           "osculating, %ld out of budget\n",
           tilts, at_place, several, osculating, short_of);
    printf("bounds of at most %.3g of the tolerance, depths of at most %.3g of the bound\n",
           most_of_tolerance, most_of_bound);
    printf("%.4g nodes a tilt, at most %u\n", all_nodes / (double)tilts, most_nodes);
    CHECK(several > tilts / 4);
    for (int i = 0; i < hard_rounds(TOPS); i++) {
        rng r = rng_of(1, "top", (uint64_t)i);
        check_tops(&r);
    }
    printf("%ld tops near P, %ld on an edge, missed by at most %.3g rad\n", tops, tops_at_edge,
           most_missed);
    return check_result();
}
