/* S. K. Sharma, R. K. Duvedi, S. Bedi, S. Mann, "Numerical implementation of drop spin and tilt
 * method for five-axis tool positioning for tensor product surfaces", 2021. Its body was not at
 * hand: the figures are those of its abstract. */
#include "app/papers.h"
#include "core/part.h"

#include <stdlib.h>

#define DEGREE (BTG_PI / 180)

/* ---- seeds and iterations ----------------------------------------------------------------- */

static const char newton[] = "DST: Newton's method on the bicubic surfaces";
#define SAME_MM      1e-5
#define SAME_DEGREES 1e-4

static bool inside(const btg_contact *c) {
    return c->place.u > 0 && c->place.u < 1 && c->place.v > 0 && c->place.v < 1;
}

/* Share of the positions, their contacts not on the part's edge, that are the exact solver's. */
static double agreement(const btg_position *exact, const btg_position *by, size_t count) {
    double compared = 0, same = 0;
    for (size_t i = 0; i < count; i++) {
        const btg_position *a = &exact[i], *b = &by[i];
        bool two = a->status == BTG_OK && inside(&a->p) && inside(&a->q);
        if (!two && !(a->status == BTG_OSCULATING && inside(&a->p))) continue;
        compared++;
        same += fabs(a->tilt_rad - b->tilt_rad) <= SAME_DEGREES * DEGREE &&
                vec_norm(vec_sub(a->tip, b->tip)) <= SAME_MM;
    }
    return 100 * same / compared;
}

static void add_counts(papers *p, int surface, const btg_method_counts *c) {
    const char *item = papers_surface[surface];
    double drops = (double)(c->drops - c->drops_given_up);
    double tilts = (double)(c->tilts - c->tilts_given_up);
    papers_name(papers_add(p, newton, "", (double)c->drop_seeds / drops, 5), item, "seeds, drop");
    papers_name(papers_add(p, newton, "", (double)c->drop_last_iterations / drops, 20), item,
                "iterations, drop");
    papers_name(papers_add(p, newton, "", (double)c->tilt_seeds / tilts, 5), item, "seeds, tilt");
    papers_name(papers_add(p, newton, "", (double)c->tilt_last_iterations / tilts, 20), item,
                "iterations, tilt");
    papers_name(papers_add(p, newton, "", (double)c->tilt_iterations / tilts, NAN), item,
                "iterations of all seeds, tilt");
    papers_name(papers_add(p, newton, "%", 100 * (double)c->followed / tilts, NAN), item,
                "tilts from the last one's seed");
    papers_name(papers_add(p, newton, "", (double)c->drops_given_up, NAN), item, "drops given up");
    papers_name(papers_add(p, newton, "", (double)c->tilts_given_up, NAN), item, "tilts given up");
    papers_name(papers_add(p, newton, "", (double)c->gouged, NAN), item,
                "roots that gouge, thrown away");
}

static btg_status iterations(papers *p) {
    size_t count;
    double *xy = papers_footprint(p->quick ? 15 : 1, &count);
    btg_position *exact = malloc(2 * (xy ? count : 1) * sizeof *exact);
    btg_status status = xy && exact ? BTG_OK : BTG_ERROR_MEMORY;
    for (int surface = 0; surface < PAPERS_SURFACES && status == BTG_OK; surface++) {
        btg_method_def dst = papers_method("dst"), vcrf = papers_method("vcrf");
        btg_method_counts counts;
        papers_show(p, "Newton's seeds and iterations");
        status = papers_solve(p, surface, &vcrf, &p->solver, xy, count, exact, NULL, NULL);
        if (status == BTG_OK)
            status =
                papers_solve(p, surface, &dst, &p->solver, xy, count, exact + count, NULL, &counts);
        if (status != BTG_OK) break;
        add_counts(p, surface, &counts);
        papers_name(papers_add(p, newton, "%", agreement(exact, exact + count, count), NAN),
                    papers_surface[surface], "the closed form's position");
    }
    papers_note_add(
        p, newton,
        "%zu positions a surface. The paper: on average fewer than 5 seeds, fewer than 20 "
        "iterations but where the tool fits the part's curvature; here means of the answers found, "
        "iterations of the seed that led there. Given up are contacts "
        "on the part's edge, where there is no common normal, and osculating ones.",
        count);
    papers_note_add(p, newton,
                    "The same position: 1e-5 mm and 1e-4 deg, contacts not on the edge; the others "
                    "are roots that cut the part by less than the gouge grid of 48 x 36 shows.");
    free(xy);
    free(exact);
    return status;
}

/* ---- second contacts over the spin -------------------------------------------------------- */

static const char spread[] = "DST: second contacts over the spin";
#define FEET   6
#define SPINS  36
#define ALL    (FEET * SPINS)
#define GAP_MM 6.0

typedef struct cloud {
    double x[ALL], y[ALL];
} cloud;

static btg_status spin_round(papers *p, int surface, btg_position *out) {
    static const double xy[2 * FEET] = {40, 40, 40, 110, 75, 60, 80, 95, 110, 45, 112, 108};
    btg_method_def def = papers_method("vcrf");
    btg_status status = BTG_OK;
    for (int k = 0; k < SPINS && status == BTG_OK; k++) {
        btg_solver_def solver = p->solver;
        solver.spin = BTG_SPIN_FIXED;
        solver.spin_rad = (360.0 / SPINS * k - 180) * DEGREE;
        if (k == SPINS / 2) solver.spin = BTG_SPIN_NONE;
        status = papers_solve(p, surface, &def, &solver, xy, FEET, out + k * FEET, NULL, NULL);
    }
    return status;
}

static double mean_gap(const btg_position *of) {
    double sum = 0, n = 0;
    for (int i = 0; i < FEET; i++) {
        double gap = papers_gap(&of[i]);
        if (isnan(gap)) continue;
        sum += gap;
        n++;
    }
    return sum / n;
}

static void add_spread(papers *p, int surface, const btg_position *all, cloud *c) {
    double least = INFINITY, most = 0, lean[2] = {INFINITY, 0};
    const char *item = papers_surface[surface];
    for (int i = 0; i < ALL; i++) {
        double gap = papers_gap(&all[i]);
        c->x[i] = all[i].q.point.x - all[i].p.point.x;
        c->y[i] = all[i].q.point.y - all[i].p.point.y;
        if (isnan(gap)) continue;
        least = fmin(least, gap);
        most = fmax(most, gap);
        lean[0] = fmin(lean[0], all[i].inclination_rad / DEGREE);
        lean[1] = fmax(lean[1], all[i].inclination_rad / DEGREE);
    }
    papers_name(papers_add(p, spread, "mm", mean_gap(all + FEET * SPINS / 2), NAN), item,
                "|PQ|, spin 0 deg, mean");
    papers_name(papers_add(p, spread, "mm", mean_gap(all + FEET * SPINS * 3 / 4), NAN), item,
                "|PQ|, spin 90 deg, mean");
    papers_name(papers_add(p, spread, "mm", least, NAN), item, "|PQ|, all spins, from");
    papers_name(papers_add(p, spread, "mm", most, NAN), item, "|PQ|, all spins, to");
    papers_name(papers_add(p, spread, "deg", lean[0], NAN), item, "inclination, from");
    papers_name(papers_add(p, spread, "deg", lean[1], NAN), item, "inclination, to");
}

/* The paper's path of uniform contact spacing, which it made by hand: the policy `gap`. */
static btg_status uniform(papers *p, int surface, size_t *asked) {
    size_t count;
    double *xy = papers_footprint(p->quick ? 25 : 5, &count), met = 0, tilted = 0;
    *asked = count;
    btg_position *out = malloc((xy ? count : 1) * sizeof *out);
    btg_status status = xy && out ? BTG_OK : BTG_ERROR_MEMORY;
    btg_method_def def = papers_method("vcrf");
    btg_solver_def solver = p->solver;
    solver.spin = BTG_SPIN_GAP;
    solver.gap_mm = GAP_MM;
    if (status == BTG_OK)
        status = papers_solve(p, surface, &def, &solver, xy, count, out, NULL, NULL);
    for (size_t i = 0; i < count && status == BTG_OK; i++) {
        if (isnan(papers_gap(&out[i]))) continue;
        tilted++;
        met += out[i].spin_met != 0;
    }
    if (status == BTG_OK)
        papers_name(papers_add(p, spread, "%", 100 * met / tilted, NAN), papers_surface[surface],
                    "positions with |PQ| = 6 mm");
    free(xy);
    free(out);
    return status;
}

static btg_status spreads(papers *p) {
    size_t asked = 0;
    btg_position *all = malloc(ALL * sizeof *all);
    cloud *clouds = malloc(PAPERS_SURFACES * sizeof *clouds);
    btg_status status = all && clouds ? BTG_OK : BTG_ERROR_MEMORY;
    btg_chart_panel panels[PAPERS_SURFACES];
    for (int k = 0; k < PAPERS_SURFACES && status == BTG_OK; k++) {
        papers_show(p, "second contacts over the spin");
        status = spin_round(p, k, all);
        if (status != BTG_OK) break;
        add_spread(p, k, all, &clouds[k]);
        status = uniform(p, k, &asked);
        panels[k] = btg_chart_panel_of(papers_surface[k], "x of Q - P, mm", "y of Q - P, mm");
        panels[k].same_scale = true;
        panels[k].x_min = -14;
        panels[k].x_max = 14;
        btg_chart_add(&panels[k], BTG_CHART_DOTS, 1, NULL, clouds[k].x, clouds[k].y, ALL);
    }
    papers_note_add(p, spread,
                    "%d places a surface, %d spins of 10 deg each, in closed form. The paper turns "
                    "about two axes: the normal at P (spin) and the pseudo-insert's; the second "
                    "angle, here the inclination, is the one at which the tool touches again. "
                    "|PQ| = 6 mm is asked for at %zu positions a surface.",
                    FEET, SPINS, asked);
    if (status == BTG_OK)
        status = papers_chart(p, "dst-spread", "Second contacts about the first, all spins", panels,
                              PAPERS_SURFACES, PAPERS_SURFACES);
    free(all);
    free(clouds);
    return status;
}

btg_status papers_dst(papers *p) {
    btg_status status = iterations(p);
    if (status == BTG_OK) status = spreads(p);
    if (status == BTG_ERROR_MEMORY) btg_fail(&p->message, status, "bench: out of memory");
    return status;
}
