/* Kinematics of every kind against a chain of 4 x 4 matrices written here, and what is refused. */
#include "../conformance/rng.h"
#include "../unit/check.h"
#include "bitangent/post.h"
#include "core/vec.h"

#include <stdlib.h>
#include <string.h>

#define POSES 20000
/* Coordinates of a few hundred mm, some twenty roundings. */
#define LIMIT_MM  1e-9
#define LIMIT_RAD 1e-12

#define RADIANS(x) ((x) * (BTG_PI / 180))

typedef struct matrix {
    double m[4][4];
} matrix;

static matrix product(matrix a, matrix b) {
    matrix r = {{{0}}};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            for (int k = 0; k < 4; k++)
                r.m[i][j] += a.m[i][k] * b.m[k][j];
    return r;
}

static matrix shift(double x, double y, double z) {
    return (matrix){{{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}, {0, 0, 0, 1}}};
}

static matrix about(char letter, double q) {
    double s = sin(q), c = cos(q);
    if (letter == 'A') return (matrix){{{1, 0, 0, 0}, {0, c, -s, 0}, {0, s, c, 0}, {0, 0, 0, 1}}};
    if (letter == 'B') return (matrix){{{c, 0, s, 0}, {0, 1, 0, 0}, {-s, 0, c, 0}, {0, 0, 0, 1}}};
    return (matrix){{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
}

static btg_vec3 apply(matrix a, btg_vec3 p, double w) {
    double in[4] = {p.x, p.y, p.z, w}, out[3] = {0};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 4; k++)
            out[i] += a.m[i][k] * in[k];
    return vec(out[0], out[1], out[2]);
}

/* A rotary axis as the test knows it: a main axis, leaning by `nutation` about x and reversed where
 * `sign` is -1. */
typedef struct joint {
    char letter;
    int in_head;
    double nutation, sign;
    btg_vec3 pivot;
} joint;

static matrix motion(const joint *j, double q) {
    matrix turn = about(j->letter, j->sign * q);
    turn = product(product(about('A', j->nutation), turn), about('A', -j->nutation));
    matrix there = shift(j->pivot.x, j->pivot.y, j->pivot.z);
    return product(product(there, turn), shift(-j->pivot.x, -j->pivot.y, -j->pivot.z));
}

typedef struct kind {
    const char *name;
    joint joints[2];
} kind;

static const kind kinds[] = {
    {"table-table AC", {{'A', 0, 0, 1, {0, 0, 0}}, {'C', 0, 0, 1, {0, 0, 0}}}},
    {"table-table BC, ISO", {{'B', 0, 0, -1, {0, 0, 0}}, {'C', 0, 0, -1, {0, 0, 0}}}},
    {"table-table, nutating", {{'B', 0, RADIANS(45), 1, {0, 0, 0}}, {'C', 0, 0, -1, {0, 0, 0}}}},
    {"head-table BC", {{'B', 1, 0, 1, {0, 0, 0}}, {'C', 0, 0, 1, {0, 0, 0}}}},
    {"table-head CA", {{'C', 0, 0, -1, {0, 0, 0}}, {'A', 1, 0, 1, {0, 0, 0}}}},
    {"head-head CA", {{'C', 1, 0, 1, {0, 0, 0}}, {'A', 1, 0, 1, {0, 0, 0}}}},
    {"head-head AB", {{'A', 1, 0, 1, {0, 0, 0}}, {'B', 1, 0, -1, {0, 0, 0}}}},
    {"head-head, nutating", {{'C', 1, 0, 1, {0, 0, 0}}, {'B', 1, RADIANS(50), 1, {0, 0, 0}}}},
};

static btg_vec3 any_point(rng *r, double size) {
    double x = rng_range(r, -size, size), y = rng_range(r, -size, size);
    return vec(x, y, rng_range(r, -size, size));
}

static btg_machine machine_of(const kind *k, btg_vec3 origin, double length) {
    btg_machine_def def = btg_machine_def_default();
    btg_machine machine = {.def = def};
    btg_message message = {""};
    for (int i = 0; i < 2; i++) {
        const joint *j = &k->joints[i];
        btg_vec3 axis = vec(j->letter == 'A', j->letter == 'B', j->letter == 'C');
        btg_vec3 leaning = apply(about('A', j->nutation), axis, 0);
        def.rotary[i].letter = j->letter;
        def.rotary[i].in_head = j->in_head;
        def.rotary[i].direction = vec_scale(leaning, 3 * j->sign);
        def.rotary[i].pivot = j->pivot;
    }
    def.part_origin = origin;
    def.tool_length_mm = length;
    if (btg_machine_init(&def, &machine, &message) != BTG_OK) {
        fprintf(stderr, "%s: %s\n", k->name, message.text);
        CHECK(0);
    }
    return machine;
}

/* T(tip) = J + H(tool), and the same for the axis. */
static void check_joints(const kind *k, const btg_machine *m, const btg_joints *q, btg_vec3 tip,
                         btg_vec3 axis) {
    matrix table = shift(0, 0, 0), head = table;
    for (int i = 0; i < 2; i++) {
        matrix one = motion(&k->joints[i], q->rotary_rad[i]);
        if (k->joints[i].in_head) head = product(head, one);
        if (!k->joints[i].in_head) table = product(table, one);
    }
    btg_vec3 part = apply(table, vec_add(tip, m->def.part_origin), 1);
    btg_vec3 tool = apply(head, vec(0, 0, -m->def.tool_length_mm), 1);
    tool = vec_add(tool, vec(q->linear_mm[0], q->linear_mm[1], q->linear_mm[2]));
    CHECK_NEAR(vec_norm(vec_sub(part, tool)), 0, LIMIT_MM);
    btg_vec3 turned = apply(table, axis, 0), spindle = apply(head, vec(0, 0, 1), 0);
    CHECK_NEAR(vec_norm(vec_sub(turned, spindle)), 0, LIMIT_RAD);
    btg_vec3 back, direction;
    CHECK(btg_machine_forward(m, q, &back, &direction) == BTG_OK);
    CHECK_NEAR(vec_norm(vec_sub(back, tip)), 0, LIMIT_MM);
    CHECK_NEAR(vec_norm(vec_sub(direction, axis)), 0, LIMIT_RAD);
}

static btg_vec3 any_axis(rng *r) {
    double lean = rng_range(r, 0, 1) < 0.3 ? pow(10, rng_range(r, -8, 0)) : rng_range(r, 0, 1.3);
    double round = rng_range(r, -BTG_PI, BTG_PI);
    return vec(sin(lean) * cos(round), sin(lean) * sin(round), cos(lean));
}

static void test_kind(const kind *given) {
    rng r = rng_of(7, given->name, 0);
    kind k = *given;
    int reached = 0;
    btg_machine m = machine_of(&k, vec(0, 0, 0), 0);
    for (int i = 0; i < POSES; i++) {
        if (i % 500 == 0) {
            k.joints[0].pivot = any_point(&r, 200);
            k.joints[1].pivot = any_point(&r, 200);
            btg_vec3 origin = any_point(&r, 200);
            m = machine_of(&k, origin, rng_range(&r, 0, 200));
        }
        btg_vec3 tip = any_point(&r, 200), axis = any_axis(&r);
        btg_joints q[2];
        btg_status status = btg_machine_inverse(&m, tip, axis, q);
        if (status == BTG_ERROR_UNSUPPORTED) continue;
        CHECK(status == BTG_OK);
        reached++;
        for (int s = 0; s < 2; s++)
            check_joints(&k, &m, &q[s], tip, axis);
        CHECK(fabs(q[0].rotary_rad[0]) <= BTG_PI && fabs(q[0].rotary_rad[1]) <= BTG_PI);
    }
    /* A nutating axis reaches a part of all directions; the others reach all. */
    bool nutating = given->joints[0].nutation > 0 || given->joints[1].nutation > 0;
    CHECK(nutating ? reached > POSES / 2 : reached == POSES);
}

/* Right on the pole: the joint that may stand anyhow is 0, and the pose is right. */
static void test_pole(void) {
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        const kind *k = &kinds[i];
        btg_machine m = machine_of(k, vec(1, 2, 3), 50);
        btg_joints q[2];
        CHECK(btg_machine_inverse(&m, vec(4, 5, 6), vec(0, 0, 1), q) == BTG_OK);
        for (int s = 0; s < 2; s++)
            check_joints(k, &m, &q[s], vec(4, 5, 6), vec(0, 0, 1));
    }
}

static void test_out_of_reach(void) {
    btg_machine m = machine_of(&kinds[2], vec(0, 0, 0), 50);
    btg_joints q[2];
    btg_vec3 tip, axis;
    CHECK(btg_machine_inverse(&m, vec(0, 0, 0), vec(0, 0, -1), q) == BTG_ERROR_UNSUPPORTED);
    CHECK(btg_machine_inverse(&m, vec(0, 0, 0), vec(0, 0, 2), q) == BTG_ERROR_ARGUMENT);
    CHECK(btg_machine_inverse(&m, vec(0, NAN, 0), vec(0, 0, 1), q) == BTG_ERROR_ARGUMENT);
    CHECK(btg_machine_inverse(&m, vec(0, 0, 0), vec(NAN, 0, 1), q) == BTG_ERROR_ARGUMENT);
    CHECK(btg_machine_inverse(NULL, vec(0, 0, 0), vec(0, 0, 1), q) == BTG_ERROR_ARGUMENT);
    q[0] = (btg_joints){{0, INFINITY, 0}, {0, 0}};
    CHECK(btg_machine_forward(&m, &q[0], &tip, &axis) == BTG_ERROR_ARGUMENT);
}

/* ---- what is refused ---------------------------------------------------------------------- */

static void refuse(const btg_machine_def *def, const char *say) {
    btg_machine machine;
    btg_message message = {""};
    bool refused = btg_machine_init(def, &machine, &message) == BTG_ERROR_ARGUMENT;
    bool said = strstr(message.text, say) != NULL;
    if (!refused || !said) fprintf(stderr, "wanted '%s', got '%s'\n", say, message.text);
    CHECK(refused && said);
}

static btg_machine_def good(const char *name) {
    btg_machine_def def = btg_machine_def_default();
    CHECK(btg_machine_find(name, &def) == BTG_OK);
    return def;
}

#define REFUSE(change, say)                                                                        \
    do {                                                                                           \
        btg_machine_def d = good("xyzac-trt");                                                     \
        change;                                                                                    \
        refuse(&d, say);                                                                           \
    } while (0)

static void test_refusals(void) {
    REFUSE(d.version = 0, "version");
    REFUSE(d.rotary[0].letter = 'X', "rotary[0].axis");
    REFUSE(d.rotary[1].letter = 'A', "rotary[1].axis: the same letter");
    REFUSE(d.rotary[0].direction = vec(0, 0, 0), "rotary[0].direction");
    REFUSE(d.rotary[0].direction = vec(0, NAN, 0), "rotary[0].direction");
    REFUSE(d.rotary[1].direction = vec(-2, 0, 0), "rotary[1].direction: parallel");
    REFUSE(d.rotary[0].direction = vec(0, 0, 1), "rotary[1].direction: parallel");
    REFUSE(d.rotary[0].direction = vec(0, 0, 1);
           d.rotary[1].direction = vec(1, 0, 0), "rotary[0].direction: parallel to the spindle");
    REFUSE(d.rotary[0].in_head = d.rotary[1].in_head = 1,
           "rotary[1].direction: parallel to the sp");
    REFUSE(d.rotary[1].pivot.y = INFINITY, "rotary[1].pivot_mm");
    REFUSE(d.rotary[1].min_rad = 5; d.rotary[1].max_rad = 4, "rotary[1].limits_deg");
    REFUSE(d.rotary[1].min_rad = NAN, "rotary[1].limits_deg");
    REFUSE(d.rotary[1].min_rad = 4; d.rotary[1].max_rad = 5, "rotary[1].limits_deg");
    REFUSE(d.rotary[0].speed_rad_per_s = 0, "rotary[0].speed_deg_per_s");
    REFUSE(d.rotary[0].acceleration_rad_per_s2 = -1, "rotary[0].acceleration_deg_per_s2");
    REFUSE(d.linear[0].min_mm = 600, "linear.X.limits_mm");
    REFUSE(d.linear[1].speed_mm_per_s = NAN, "linear.Y.speed_mm_per_s");
    REFUSE(d.linear[2].acceleration_mm_per_s2 = 0, "linear.Z.acceleration_mm_per_s2");
    REFUSE(d.part_origin.x = 1e9, "part_origin_mm");
    REFUSE(d.tool_length_mm = -1, "tool_length_mm");
    REFUSE(d.retract_z_mm = INFINITY, "retract_z_mm");
    REFUSE(d.control = (btg_control)9, "program.control");
    REFUSE(d.vectors = 1, "program.orientation");
    btg_machine_def def;
    CHECK(btg_machine_find("lathe", &def) == BTG_ERROR_ARGUMENT);
    CHECK(btg_machine_at(5, &def) == BTG_ERROR_ARGUMENT);
}

/* ---- reach -------------------------------------------------------------------------------- */

static double max_tilt(const char *name, double low, double high, int other, double at) {
    btg_machine_def def;
    btg_machine m;
    CHECK(btg_machine_find(name, &def) == BTG_OK);
    def.rotary[0].min_rad = RADIANS(low);
    def.rotary[0].max_rad = RADIANS(high);
    def.rotary[1].min_rad = other ? -at : -INFINITY;
    def.rotary[1].max_rad = other ? at : INFINITY;
    CHECK(btg_machine_init(&def, &m, NULL) == BTG_OK);
    return btg_machine_max_tilt(&m, RADIANS(80));
}

/* A table A that carries a table C leans the axis by A, either way; C turns the lean anywhere, or,
 * where it makes no whole turn, anywhere that A's other sign does not. */
static void test_max_tilt(void) {
    CHECK_NEAR(max_tilt("xyzac-trt", -110, 30, 0, 0), RADIANS(80), 1e-9);
    CHECK_NEAR(max_tilt("xyzac-trt", -33.3, 12, 0, 0), RADIANS(33.3), 1e-8);
    CHECK_NEAR(max_tilt("xyzac-trt", -5, 21.7, 0, 0), RADIANS(21.7), 1e-8);
    CHECK_NEAR(max_tilt("xyzbc-trt", -40.2, 40.2, 1, RADIANS(95)), RADIANS(40.2), 1e-8);
    CHECK_NEAR(max_tilt("xyzac-trt", -40, 11.1, 1, RADIANS(95)), RADIANS(11.1), 1e-8);
    CHECK(max_tilt("xyzac-trt", -40, 40, 1, RADIANS(80)) == 0);
    CHECK(max_tilt("xyzac-trt", -40, 0, 1, RADIANS(95)) == 0);
}

int main(void) {
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        test_kind(&kinds[i]);
    test_pole();
    test_out_of_reach();
    test_refusals();
    test_max_tilt();
    return check_result();
}
