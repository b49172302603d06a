/* A search ends long before its budget, also where it is hardest: nearly osculating contacts, whose
 * valley from P to Q is as shallow as the search's clearance, and collapsed edges (poles), where
 * one parameter leads nowhere, and sides that the tool just grazes. Effort is counted in nodes. */
#include "../conformance/rng.h"
#include "check.h"
#include "core/part.h"
#include "hard_parts.h"

#include <math.h>
#include <stdlib.h>

/* Ten times the most that was seen, and far below the budget of a million. */
#define NODES_MOST  30000
#define RANDOM_FEET 1500
/* In the mean: a quarter above what they take on the worst of these surfaces. */
#define DROP_NODES_MOST 110
#define TILT_NODES_MOST 165
/* The same for drops of a flat end mill. */
#define FLAT_NODES_MOST 10000
#define FLAT_FEET       300

/* Squares along a side of a mesh, and the most nodes that its drops may take in the mean: a quarter
 * above what they take. */
#define MESH_SIDE       200
#define MESH_FEET       300
#define MESH_NODES_MOST 400

/* Feet whose tilt spent the whole budget once. */
static const struct {
    int paper;
    double x, y;
} hard_feet[] = {
    {0, 75.948675519346764, 134.42012973593793}, {0, 70.70801184553045, 70.675669503493609},
    {0, 75.010505438310034, 68.202492204590342}, {0, 73.428729904526477, 106.31080830711541},
    {0, 70.560654225218244, 72.032437667544698}, {0, 71.307140757807346, 69.945481871444755},
    {0, 74.710864712960969, 81.69599702441208},  {1, 12.640732567409573, 137.63881580323874},
    {1, 23.925180240316934, 125.84207501831641}, {1, 20.332566467170142, 129.4199629071899},
    {1, 68.372635424135225, 114.03673564363619}, {1, 14.783128182313121, 18.441372141168888},
    {1, 73.436323616670805, 76.526772299370137}, {1, 52.859344973891567, 52.681111633570985},
    {1, 79.667292832215963, 67.296171061239562}, {1, 12.397451558363015, 137.37927896282423},
    {2, 56.383787243447649, 98.996894640408655}, {2, 46.466836599585179, 122.79032887526063},
    {2, 60.258559880953143, 123.16369149202887}, {2, 49.768960120367858, 122.32256461314756},
    {2, 51.369637359433327, 122.30160518069724},
};

typedef struct setting {
    btg_part *part;
    btg_tool tool;
    btg_solver_def solver;
    void *workspace;
    size_t size;
    uint32_t most;       /* nodes of a question */
    double drops, tilts; /* nodes of all */
} setting;

static void open_setting(setting *s, const model *m) {
    btg_tool_def tool = btg_tool_def_default();
    *s = (setting){.part = model_part(m), .solver = btg_solver_def_default()};
    s->solver.tolerance_mm = 1e-6;
    if (!s->part || btg_tool_init(&tool, &s->tool, NULL) != BTG_OK) exit(2);
    s->size = btg_workspace_size(s->part);
    s->workspace = malloc(s->size);
    if (!s->workspace) exit(2);
}

static void close_setting(setting *s) {
    free(s->workspace);
    btg_part_destroy(s->part);
}

static void check_place(setting *s, double x, double y) {
    btg_drop_query query = btg_position_drop_query(x, y);
    btg_drop_result drop = {0};
    btg_tilt_query frame;
    btg_tilt_result tilt = {0};
    btg_drop(s->part, &s->tool, &s->solver, &query, s->workspace, s->size, &drop);
    bool tilts = btg_position_tilt_query(&s->tool, &s->solver, &query, &drop, &frame) == BTG_OK;
    if (tilts) btg_tilt(s->part, &s->tool, &s->solver, &frame, s->workspace, s->size, &tilt);
    if (drop.nodes > s->most) s->most = drop.nodes;
    if (tilt.nodes > s->most) s->most = tilt.nodes;
    s->drops += drop.nodes;
    s->tilts += tilt.nodes;
    CHECK(drop.status != BTG_BUDGET && tilt.status != BTG_BUDGET);
    CHECK(drop.nodes < NODES_MOST && tilt.nodes < NODES_MOST);
}

static void check_papers(int number) {
    model m = {0};
    setting s;
    model_paper(&m, number);
    open_setting(&s, &m);
    for (size_t i = 0; i < sizeof hard_feet / sizeof *hard_feet; i++)
        if (hard_feet[i].paper == number) check_place(&s, hard_feet[i].x, hard_feet[i].y);
    rng r = rng_of(1, model_paper_name[number], 0);
    s.drops = s.tilts = 0;
    for (int i = 0; i < RANDOM_FEET; i++) {
        double x = rng_range(&r, 0, 150), y = rng_range(&r, 0, 150);
        check_place(&s, x, y);
    }
    s.drops /= RANDOM_FEET;
    s.tilts /= RANDOM_FEET;
    printf("%s: at most %u nodes; in the mean %.0f a drop and %.0f a tilt\n",
           model_paper_name[number], (unsigned)s.most, s.drops, s.tilts);
    CHECK(s.drops < DROP_NODES_MOST && s.tilts < TILT_NODES_MOST);
    close_setting(&s);
    model_free(&m);
}

/* A dome of four bicubic patches, each with one edge collapsed at the flat top; every second foot
 * is such that the tool touches near there, others are about where it only grazes the side. */
static void dome_patch(model *m, double turn) {
    static const double profile[4][2] = {{0, 8}, {12, 8}, {22, 5}, {28, 0}};
    const double k = 0.5522847498307936; /* of a quarter circle */
    const double arc[4][2] = {{1, 0}, {1, k}, {k, 1}, {0, 1}};
    double c = cos(turn), s = sin(turn);
    model_surface f = model_bezier(m, 3, 3, false);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double *p = f.points + 3 * (4 * i + j), r = profile[j][0];
            p[0] = r * (c * arc[i][0] - s * arc[i][1]);
            p[1] = r * (s * arc[i][0] + c * arc[i][1]);
            p[2] = profile[j][1];
        }
}

static void check_dome(void) {
    model m = {0};
    setting s;
    for (int i = 0; i < 4; i++)
        dome_patch(&m, 0.5 * i * BTG_PI);
    open_setting(&s, &m);
    rng r = rng_of(1, "dome", 0);
    for (int i = 0; i < 600; i++) {
        double radius = rng_range(&r, 0, i % 2 ? 9 : 42), turn = rng_range(&r, 0, 2 * BTG_PI);
        check_place(&s, radius * cos(turn), radius * sin(turn));
    }
    printf("dome: at most %u nodes\n", (unsigned)s.most);
    close_setting(&s);
    model_free(&m);
}

static btg_drop_result random_drop(setting *s, rng *r) {
    double x = rng_range(r, 0, 150), y = rng_range(r, 0, 150);
    btg_drop_query query = btg_position_drop_query(x, y);
    btg_drop_result drop = {0};
    btg_drop(s->part, &s->tool, &s->solver, &query, s->workspace, s->size, &drop);
    return drop;
}

/* Drops of a flat end mill: its rim stands on the surface at one point, and no bend of the tool
 * tells how its surroundings clear it. */
static void check_flat(int number) {
    model m = {0};
    setting s;
    btg_tool_def tool = btg_tool_def_default();
    tool.profile = BTG_PROFILE_BULLNOSE;
    tool.major_radius_mm = 10;
    tool.minor_radius_mm = 0;
    model_paper(&m, number);
    open_setting(&s, &m);
    if (btg_tool_init(&tool, &s.tool, NULL) != BTG_OK) exit(2);
    rng r = rng_of(1, model_paper_name[number], 1);
    for (int i = 0; i < FLAT_FEET; i++) {
        btg_drop_result drop = random_drop(&s, &r);
        if (drop.nodes > s.most) s.most = drop.nodes;
        CHECK(drop.status == BTG_OK || drop.status == BTG_NO_CONTACT);
        CHECK(drop.nodes < FLAT_NODES_MOST);
    }
    printf("%s, flat end mill: at most %u nodes a drop\n", model_paper_name[number],
           (unsigned)s.most);
    close_setting(&s);
    model_free(&m);
}

/* A paper's part as triangles. */
static void add_mesh(model *m, int number) {
    model paper = {0};
    model_paper(&paper, number);
    btg_part *part = model_part(&paper);
    if (!part) exit(2);
    const double h = 1.0 / MESH_SIDE;
    for (int i = 0; i < MESH_SIDE; i++)
        for (int k = 0; k < MESH_SIDE; k++) {
            btg_vec3 a = btg_patch_point(&part->patches[0], i * h, k * h);
            btg_vec3 b = btg_patch_point(&part->patches[0], (i + 1) * h, k * h);
            btg_vec3 c = btg_patch_point(&part->patches[0], (i + 1) * h, (k + 1) * h);
            btg_vec3 d = btg_patch_point(&part->patches[0], i * h, (k + 1) * h);
            model_triangle(m, a, b, c);
            model_triangle(m, a, c, d);
        }
    btg_part_destroy(part);
    model_free(&paper);
}

/* A drop on triangles begins well when its first contact is near the last one. */
static void check_mesh(int number) {
    model m = {0};
    setting s;
    double nodes = 0;
    add_mesh(&m, number);
    open_setting(&s, &m);
    rng r = rng_of(1, model_paper_name[number], 2);
    for (int i = 0; i < MESH_FEET; i++) {
        btg_drop_result drop = random_drop(&s, &r);
        CHECK(drop.status == BTG_OK);
        nodes += drop.nodes;
    }
    nodes /= MESH_FEET;
    printf("%s as triangles: %.0f nodes a drop\n", model_paper_name[number], nodes);
    CHECK(nodes < MESH_NODES_MOST);
    close_setting(&s);
    model_free(&m);
}

int main(void) {
    for (int i = 0; i < MODEL_PAPERS; i++) {
        check_papers(i);
        check_flat(i);
        check_mesh(i);
    }
    check_dome();
    return check_result();
}
