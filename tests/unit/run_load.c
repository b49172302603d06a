#include "run_load.h"

#include "../conformance/model.h"

#include <stdio.h>
#include <stdlib.h>

/* ---- parts -------------------------------------------------------------------------------- */

#define MESH_SIDE 60 /* squares, two triangles each */

static btg_vec3 wave(int i, int k) {
    double x = 150.0 * i / MESH_SIDE, y = 150.0 * k / MESH_SIDE;
    return vec(x, y, 80 + 9 * sin(x / 17) * cos(y / 23) + (i * k % 7 == 3 ? 1.5 : 0));
}

static void mesh(model *m) {
    for (int i = 0; i < MESH_SIDE; i++)
        for (int k = 0; k < MESH_SIDE; k++) {
            model_triangle(m, wave(i, k), wave(i + 1, k), wave(i, k + 1));
            model_triangle(m, wave(i + 1, k), wave(i + 1, k + 1), wave(i, k + 1));
        }
}

/* Degree 9 both ways, rational: the longest evaluation there is. */
static void degree_nine(model *m) {
    rng r = {9};
    model_surface s = model_bezier(m, BTG_DEGREE_MAX, BTG_DEGREE_MAX, true);
    for (int i = 0; i <= BTG_DEGREE_MAX; i++)
        for (int k = 0; k <= BTG_DEGREE_MAX; k++) {
            int at = i * (BTG_DEGREE_MAX + 1) + k;
            s.points[3 * at] = 12 * i + rng_range(&r, -2, 2);
            s.points[3 * at + 1] = 12 * k + rng_range(&r, -2, 2);
            s.points[3 * at + 2] = rng_range(&r, -30, 30);
            s.weights[at] = rng_range(&r, 0.5, 2);
        }
}

/* Patches that overlap, spikes and triangles without area among them. */
static void jumble(model *m) {
    rng r = {4};
    for (int n = 0; n < 6; n++) {
        model_surface s = model_spline(m, 1 + n % 4, 3, 6, 7, n % 2);
        double x = rng_range(&r, 0, 60), y = rng_range(&r, 0, 60);
        for (int i = 0; i < 42; i++) {
            s.points[3 * i] = x + 8 * (i / 7);
            s.points[3 * i + 1] = y + 8 * (i % 7);
            s.points[3 * i + 2] = rng_range(&r, -6, 6);
        }
    }
    /* One number a statement: C leaves open in which order arguments are drawn. */
    for (int n = 0; n < 60; n++) {
        double q[6];
        for (int i = 0; i < 6; i++)
            q[i] = rng_range(&r, 0, 1);
        btg_vec3 a = vec(100 * q[0], 100 * q[1], 10 * q[2] - 5);
        btg_vec3 b = vec(a.x + 18 * q[3] - 9, a.y + 18 * q[4] - 9, a.z);
        model_triangle(m, a, b, n % 5 ? vec(a.x, b.y, a.z + 20 * q[5]) : b);
    }
}

static const char *const part_names[RUN_PARTS] = {"convex", "concave",  "saddle",
                                                  "mesh",   "degree 9", "jumble"};

static btg_part *make_part(int number) {
    model m = {0};
    if (number < MODEL_PAPERS)
        model_paper(&m, number);
    else if (number == 3)
        mesh(&m);
    else if (number == 4)
        degree_nine(&m);
    else
        jumble(&m);
    btg_part *part = model_part(&m);
    model_free(&m);
    return part;
}

/* ---- tools -------------------------------------------------------------------------------- */

static const struct {
    const char *name;
    double major, minor;
    btg_profile profile;
    bool held; /* with shank and holder */
} tools[RUN_TOOLS] = {
    {"toroidal", 6.7, 6, BTG_PROFILE_TOROIDAL, false},
    {"toroidal, held", 6.7, 6, BTG_PROFILE_TOROIDAL, true},
    {"bullnose", 8, 2, BTG_PROFILE_BULLNOSE, false},
    {"bullnose, held", 8, 2, BTG_PROFILE_BULLNOSE, true},
    {"flat", 6, 0, BTG_PROFILE_BULLNOSE, false},
    {"ball", 0, 6, BTG_PROFILE_TOROIDAL, false},
};

static btg_tool make_tool(int number) {
    btg_tool_def def = btg_tool_def_default();
    def.major_radius_mm = tools[number].major;
    def.minor_radius_mm = tools[number].minor;
    def.profile = tools[number].profile;
    if (tools[number].held) {
        def.shank = (btg_cylinder){11, 4, 30};
        def.holder_count = BTG_HOLDER_MAX;
        for (int i = 0; i < BTG_HOLDER_MAX; i++)
            def.holder[i] = (btg_cylinder){16 + 3 * i, 20 + 6 * i, 60 + 6 * i};
    }
    btg_tool tool;
    btg_message message;
    if (btg_tool_init(&def, &tool, &message) < 0) {
        fprintf(stderr, "run_load: %s\n", message.text);
        exit(2);
    }
    return tool;
}

/* Hard positions may take a million nodes; they take no other way than the first thousands. */
#define NODES_MAX 1000

/* ---- steps -------------------------------------------------------------------------------- */

void run_load_open(run_load *load, int number) {
    int part = number / RUN_TOOLS, tool = number % RUN_TOOLS;
    if (!load->part || load->part_number != part) {
        run_load_close(load);
        load->part = make_part(part);
        load->part_number = part;
        load->part_name = part_names[part];
        load->workspace_size = btg_position_workspace_size(load->part);
        load->workspace = malloc(load->workspace_size);
        if (!load->workspace) exit(2);
    }
    load->tool = make_tool(tool);
    load->tool_name = tools[tool].name;
    btg_part_info info;
    btg_part_get_info(load->part, &info);
    const double width = 15;
    load->low = vec(info.box_min.x - width, info.box_min.y - width, 0);
    load->high = vec(info.box_max.x + width, info.box_max.y + width, 0);
    load->numbers = rng_of(1, load->part_name, (uint64_t)tool);
    load->at = (btg_position){.status = BTG_NO_CONTACT}; /* no neighbour yet */
    load->at.p.point = load->at.q.point = vec_nan();
}

void run_load_close(run_load *load) {
    btg_part_destroy(load->part);
    free(load->workspace);
    *load = (run_load){0};
}

void run_load_prepare(run_load *load, int kind) {
    rng *r = &load->numbers;
    load->before = load->at;
    load->at.foot_x_mm = rng_range(r, load->low.x, load->high.x);
    load->at.foot_y_mm = rng_range(r, load->low.y, load->high.y);
    load->drop_query = btg_position_drop_query(load->at.foot_x_mm, load->at.foot_y_mm);
    load->solver = btg_solver_def_default();
    load->solver.spin = kind == 2 ? BTG_SPIN_FIXED : BTG_SPIN_NONE;
    load->solver.spin_rad = rng_range(r, -BTG_PI, BTG_PI);
    load->solver.node_budget = NODES_MAX;
    uint32_t few = 1 + (uint32_t)rng_pick(r, 60);
    if (kind == 3) load->solver.node_budget = few;
    if (kind != 5) return;
    load->solver.spin = (btg_spin)(BTG_SPIN_GAP + rng_pick(r, 3));
    load->solver.gap_mm = rng_range(r, 0.5, 8);
    load->solver.feed_x = rng_range(r, -1, 1);
}

static btg_status drop_and_tilt(run_load *l) {
    btg_status status = btg_drop(l->part, &l->tool, &l->solver, &l->drop_query, l->workspace,
                                 l->workspace_size, &l->drop);
    if (status < 0) return status;
    if (btg_position_tilt_query(&l->tool, &l->solver, &l->drop_query, &l->drop, &l->tilt_query) !=
        BTG_OK)
        return status;
    status = btg_tilt(l->part, &l->tool, &l->solver, &l->tilt_query, l->workspace,
                      l->workspace_size, &l->tilt);
    return status == BTG_ERROR_GOUGE ? BTG_OK : status;
}

btg_status run_load_step(run_load *l, int kind) {
    if (kind == 4) return drop_and_tilt(l);
    double x = l->at.foot_x_mm, y = l->at.foot_y_mm;
    if (kind == 1)
        return btg_position_follow(l->part, &l->tool, &l->solver, x, y, &l->before, l->workspace,
                                   l->workspace_size, &l->at);
    btg_status status = btg_position_solve(l->part, &l->tool, &l->solver, x, y, l->workspace,
                                           l->workspace_size, &l->at);
    if (kind != 5 || status < 0) return status;
    return btg_position_strip(l->part, &l->tool, &l->solver, &l->at, &l->strip_mm);
}
