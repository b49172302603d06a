#include "hard_parts.h"

#include <stdio.h>
#include <stdlib.h>

static void put(double *at, btg_vec3 p) {
    at[0] = p.x;
    at[1] = p.y;
    at[2] = p.z;
}

void hard_add_patch(model *m, rng *r, hard_patch kind, double size) {
    bool ripples = kind == HARD_RIPPLES, rational = rng_pick(r, 3) == 0;
    int nu = ripples ? 9 : 1 + rng_pick(r, 9), nv = 1 + rng_pick(r, ripples ? 3 : 9);
    model_surface s = model_bezier(m, nu, nv, rational);
    double height = kind == HARD_FLAT ? 1e-5 : size * rng_range(r, 0, ripples ? 0.5 : 0.3);
    double slant = kind == HARD_SKEWED ? rng_range(r, -2, 2) : 0;
    double width = kind == HARD_SKEWED ? size * rng_range(r, 0.02, 1) : size;
    for (int i = 0; i <= nu; i++)
        for (int k = 0; k <= nv; k++) {
            int at = i * (nv + 1) + k;
            double x = size * i / nu, y = width * k / nv, z = rng_range(r, -1, 1) * height;
            if (ripples) z = i % 2 ? height : -height;
            if (kind == HARD_COLLAPSED && i == 0) y = z = 0;
            put(s.points + 3 * at, vec(x + slant * y, y, z));
            if (rational) s.weights[at] = rng_range(r, 0.4, 2.5);
        }
    if (kind == HARD_SPIKY) s.points[3 * rng_pick(r, (nu + 1) * (nv + 1)) + 2] += 3 * size;
}

static btg_vec3 random_point(rng *r, double size) {
    double q[3];
    for (int i = 0; i < 3; i++)
        q[i] = rng_range(r, 0, size);
    return vec(q[0], q[1], 0.3 * q[2]);
}

static void add_grid(model *m, rng *r, double size, bool ridge) {
    enum { SIDE = 12 };
    btg_vec3 p[SIDE + 1][SIDE + 1];
    for (int i = 0; i <= SIDE; i++)
        for (int k = 0; k <= SIDE; k++) {
            double z = ridge ? fabs(fabs(i - 0.5 * SIDE) - 3) * -0.05 * size
                             : rng_range(r, -0.03, 0.03) * size + 0.1 * size * sin(0.6 * i);
            p[i][k] = vec(size * i / SIDE, size * k / SIDE, z);
        }
    for (int i = 0; i < SIDE; i++)
        for (int k = 0; k < SIDE; k++) {
            model_triangle(m, p[i][k], p[i + 1][k], p[i][k + 1]);
            model_triangle(m, p[i + 1][k], p[i + 1][k + 1], p[i][k + 1]);
        }
}

void hard_add_mesh(model *m, rng *r, hard_mesh kind, double size) {
    if (kind == HARD_TERRAIN || kind == HARD_RIDGE) {
        add_grid(m, r, size, kind == HARD_RIDGE);
        return;
    }
    btg_vec3 one = random_point(r, size);
    int count = 20 + rng_pick(r, 200);
    for (int i = 0; i < count; i++) {
        btg_vec3 a = random_point(r, size), b = random_point(r, size), c = random_point(r, size);
        if (kind == HARD_SOUP) {
            b = vec_mad(a, vec_sub(b, a), 0.3);
            c = vec_mad(a, vec_sub(c, a), 0.3);
        }
        if (kind == HARD_NEEDLES) c = vec_mad(b, hard_unit(r), rng_range(r, 0, 1e-6));
        if (kind == HARD_ONE_POINT) a = b = c = one;
        model_triangle(m, a, b, c);
    }
}

btg_tool hard_tool(int number) {
    static const struct {
        double major, minor;
        btg_profile profile;
    } tools[HARD_TOOLS] = {{6.7, 6, BTG_PROFILE_TOROIDAL}, {2, 5, BTG_PROFILE_TOROIDAL},
                           {10, 3, BTG_PROFILE_TOROIDAL},  {8, 2, BTG_PROFILE_BULLNOSE},
                           {0, 6, BTG_PROFILE_TOROIDAL},   {6.7, 6, BTG_PROFILE_TOROIDAL}};
    btg_tool_def def = btg_tool_def_default();
    def.major_radius_mm = tools[number].major;
    def.minor_radius_mm = tools[number].minor;
    def.profile = tools[number].profile;
    if (number >= HARD_CUTTERS) def.shank = (btg_cylinder){14, 5, 60};
    btg_tool tool;
    btg_message message;
    if (btg_tool_init(&def, &tool, &message) == BTG_OK) return tool;
    fprintf(stderr, "hard_tool: %s\n", message.text);
    exit(2);
}

btg_vec3 hard_unit(rng *r) {
    for (;;) {
        double q[3];
        for (int i = 0; i < 3; i++)
            q[i] = rng_range(r, -1, 1);
        btg_vec3 a = vec(q[0], q[1], q[2]);
        double n = vec_norm(a);
        if (n > 0.1 && n < 1) return vec_scale(a, 1 / n);
    }
}

int hard_rounds(int all) {
    const char *quick = getenv("BTG_TEST_QUICK");
    return quick && *quick && *quick != '0' ? (all + 4) / 5 : all;
}
