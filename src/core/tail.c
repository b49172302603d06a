/* The patch's polynomial along a direction, moved to a place and scaled to a piece: the sum of what
 * its coefficients of third and higher order can be. */
#include "core/tail.h"

#include <math.h>

typedef struct grid {
    double *at; /* v fastest */
    int n, m;   /* degrees */
} grid;

/* p(x) -> p(x + by), coefficients `step` apart. */
static void move(double *p, int degree, int step, double by) {
    for (int k = 0; k < degree; k++)
        for (int i = degree - 1; i >= k; i--)
            p[i * step] += by * p[(i + 1) * step];
}

static void move_and_scale(grid g, double u, double v, double hu, double hv) {
    for (int i = 0; i <= g.n; i++)
        move(g.at + i * (g.m + 1), g.m, 1, v - 0.5);
    for (int j = 0; j <= g.m; j++)
        move(g.at + j, g.n, g.m + 1, u - 0.5);
    double row = 1;
    for (int i = 0; i <= g.n; i++, row *= hu) {
        double scale = row;
        for (int j = 0; j <= g.m; j++, scale *= hv)
            g.at[i * (g.m + 1) + j] *= scale;
    }
}

static double at(grid g, int i, int j) {
    return i >= 0 && j >= 0 && i <= g.n && j <= g.m ? g.at[i * (g.m + 1) + j] : 0;
}

/* All that W can differ from its value at the place. */
static double spread_of(grid w) {
    double sum = 0;
    for (int k = 1; k < (w.n + 1) * (w.m + 1); k++)
        sum += fabs(w.at[k]);
    return sum;
}

/* Of n . W (S - S0) - W taylor, which begins with third order, over W. */
static double rational_tail(grid g, grid w, const btg_taylor *t) {
    double least = w.at[0] - spread_of(w), sum = 0;
    if (!(least > 0)) return INFINITY;
    for (int i = 0; i <= g.n + 2; i++)
        for (int j = i < 3 ? 3 - i : 0; j <= g.m + 2; j++)
            sum += fabs(at(g, i, j) - t->a * at(w, i - 1, j) - t->b * at(w, i, j - 1) -
                        0.5 * t->uu * at(w, i - 2, j) - t->uv * at(w, i - 1, j - 1) -
                        0.5 * t->vv * at(w, i, j - 2));
    return sum / least;
}

static double polynomial_tail(grid g) {
    double sum = 0;
    for (int i = 0; i <= g.n; i++)
        for (int j = i < 3 ? 3 - i : 0; j <= g.m; j++)
            sum += fabs(g.at[i * (g.m + 1) + j]);
    return sum;
}

double btg_patch_tail(const btg_patch *patch, btg_vec3 n, double u, double v, double hu, double hv,
                      const btg_taylor *taylor, btg_tail_room *room) {
    grid g = {room->along, patch->degree_u, patch->degree_v};
    grid w = {room->weight, patch->degree_u, patch->degree_v};
    int count = (g.n + 1) * (g.m + 1);
    for (int k = 0; k < count; k++) {
        const double *p = patch->power + 4 * k;
        g.at[k] = n.x * p[0] + n.y * p[1] + n.z * p[2];
        w.at[k] = p[3];
    }
    double tail;
    if (patch->rational) {
        btg_surface_point s;
        btg_patch_evaluate(patch, u, v, &s);
        double here = vec_dot(n, vec_sub(s.s, patch->origin));
        for (int k = 0; k < count; k++)
            g.at[k] -= here * w.at[k];
        move_and_scale(w, u, v, hu, hv);
    }
    move_and_scale(g, u, v, hu, hv);
    tail = patch->rational ? rational_tail(g, w, taylor) : polynomial_tail(g);
    return tail * (1 + 1e-12) + patch->rounding;
}
