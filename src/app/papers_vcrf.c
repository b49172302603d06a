/* M. Singh, S. Bedi, S. Mann, "Tool Positioning in Five Axis Machining on a Tensor Product Surface
 * using Circular Rays": tables 2 to 5, figure 10. The paper's figures stand here as printed. */
#include "app/papers.h"
#include "core/part.h"

#include <stdlib.h>

/* ---- tables 2, 3, 4 ----------------------------------------------------------------------- */

/* Places: three cross-sections, v in 0.2 .. 0.8, every 2 mm. */
#define SECTIONS 3
static const double section_x[SECTIONS] = {36, 72, 108};
#define SECTION_FROM 30.0
#define SECTION_TO   120.0
#define SECTION_FEET 46
#define QUICK_FEET   3

typedef enum measure { DROP, CONTACT, TILT, MEASURES } measure;

static const char *const measure_table[MEASURES] = {
    "VCRF table 2: differences of the drop", "VCRF table 3: differences of the first contact",
    "VCRF table 4: differences of the tilt"};
static const char *const measure_unit[MEASURES] = {"mm", "mm", "deg"};

/* max and mean, by measure, section and surface; "< 0.0001" stands as 0.0001. */
static const double printed[MEASURES][SECTIONS][PAPERS_SURFACES][2] = {
    {{{1e-4, 1e-4}, {1e-4, 1e-4}, {1e-4, 1e-4}},
     {{1.5e-4, 1e-4}, {1e-3, 1e-4}, {2e-4, 1e-4}},
     {{1e-4, 1e-4}, {1e-4, 1e-4}, {3e-4, 1e-4}}},
    {{{0.00860, 0.00258}, {0.0116, 0.00364}, {0.00581, 0.00183}},
     {{0.796, 0.0324}, {0.304, 0.0240}, {0.0934, 0.00605}},
     {{0.00798, 0.00288}, {0.130, 0.00688}, {0.173, 0.00864}}},
    {{{0.0904, 0.0516}, {0.332, 0.101}, {0.235, 0.137}},
     {{0.323, 0.0920}, {1.48, 0.165}, {0.421, 0.181}},
     {{0.0960, 0.0497}, {1.48, 0.254}, {0.363, 0.161}}}};

static double difference(measure m, const btg_position *a, const btg_position *b) {
    switch (m) {
    case DROP:
        return fabs(a->drop_z_mm - b->drop_z_mm);
    case CONTACT:
        return vec_norm(vec_sub(a->p.point, b->p.point));
    default:
        return fabs(a->tilt_rad - b->tilt_rad) * (180 / BTG_PI);
    }
}

static int section_feet(const papers *p) {
    return p->quick ? QUICK_FEET : SECTION_FEET;
}

static void max_and_mean(measure m, const btg_position *a, const btg_position *b, int count,
                         double out[2]) {
    out[0] = out[1] = 0;
    for (int i = 0; i < count; i++) {
        double d = difference(m, &a[i], &b[i]);
        out[0] = fmax(out[0], d);
        out[1] += d / count;
    }
}

enum { GRID, DRD, EXACT, COMPARED };

/* Of one surface. */
typedef struct section {
    btg_position by[COMPARED][SECTION_FEET];
} section;

static btg_status solve_sections(papers *p, int surface, section sections[SECTIONS]) {
    static const char *const name[COMPARED] = {"vcrf-grid", "drd", "vcrf"};
    double xy[2 * SECTIONS * SECTION_FEET];
    btg_position *out = malloc(SECTIONS * SECTION_FEET * sizeof *out);
    btg_status status = out ? BTG_OK : BTG_ERROR_MEMORY;
    int count = section_feet(p);
    for (int i = 0; i < SECTIONS * count; i++) {
        xy[2 * i] = section_x[i / count];
        xy[2 * i + 1] = SECTION_FROM + (SECTION_TO - SECTION_FROM) * (i % count) / (count - 1);
    }
    for (int k = 0; k < COMPARED && status == BTG_OK; k++) {
        btg_method_def def = papers_method(name[k]);
        status = papers_solve(p, surface, &def, &p->solver, xy, (size_t)(SECTIONS * count), out,
                              NULL, NULL);
        for (int i = 0; i < SECTIONS * count && status == BTG_OK; i++)
            sections[i / count].by[k][i % count] = out[i];
    }
    free(out);
    return status;
}

static void add_section(papers *p, measure m, int surface, int at, const section *s) {
    static const char *const word[2] = {"max", "mean"};
    double both[2], grid[2], drd[2];
    char item[64];
    max_and_mean(m, s->by[GRID], s->by[DRD], section_feet(p), both);
    max_and_mean(m, s->by[GRID], s->by[EXACT], section_feet(p), grid);
    max_and_mean(m, s->by[DRD], s->by[EXACT], section_feet(p), drd);
    snprintf(item, sizeof item, "%s, x = %g", papers_surface[surface], section_x[at]);
    for (int k = 0; k < 2; k++) {
        papers_row *row =
            papers_add(p, measure_table[m], measure_unit[m], both[k], printed[m][at][surface][k]);
        papers_name(row, item, "vcrf-grid to drd, %s", word[k]);
        row->exact[0] = grid[k];
        row->exact[1] = drd[k];
    }
}

/* Where the tilts differ most: how near to P the ray stood that won there. */
static void explain(papers *p, section sections[PAPERS_SURFACES][SECTIONS]) {
    double worst = 0, from_p = NAN, exact = NAN;
    for (int k = 0; k < SECTIONS * PAPERS_SURFACES; k++) {
        const section *s = &sections[k / SECTIONS][k % SECTIONS];
        for (int i = 0; i < section_feet(p); i++) {
            double d = difference(TILT, &s->by[GRID][i], &s->by[EXACT][i]);
            if (d <= worst) continue;
            worst = d;
            from_p = papers_gap(&s->by[GRID][i]);
            exact = papers_gap(&s->by[EXACT][i]);
        }
    }
    papers_note_add(
        p, measure_table[TILT],
        "Where it is worst here (%.2f deg) vcrf-grid's ray started %.3f mm from P, the "
        "exact Q is %.2f mm away. Beside P the ray's d and su^2 vanish together: a P "
        "that is 0.002 mm off turns the angle by degrees. The paper's greatest stand, it "
        "says, where P differs most too: the tilt is ill-posed unless P is exact, and at P unless "
        "its limit is taken in closed form.",
        worst, from_p, exact);
    papers_note_add(
        p, measure_table[CONTACT],
        "Contacts differ as far as rays are apart (0.004 mm on vcrf-grid's second level) "
        "and more where the drop is flat: a height off by 1e-6 mm moves P by 0.03 mm.");
    papers_note_add(
        p, measure_table[DROP],
        "The paper prints differences below 0.0001 mm as such: its ratio is a bound. Its "
        "programs ended where theirs was enough; drd is refined to 1e-11 mm here.");
}

static btg_status differences(papers *p) {
    section(*sections)[SECTIONS] = malloc(PAPERS_SURFACES * sizeof *sections);
    btg_status status = sections ? BTG_OK : BTG_ERROR_MEMORY;
    for (int k = 0; k < PAPERS_SURFACES && status == BTG_OK; k++) {
        papers_show(p, "tables 2, 3, 4: vcrf-grid, drd, exact");
        status = solve_sections(p, k, sections[k]);
    }
    for (int m = 0; m < MEASURES && status == BTG_OK; m++)
        for (int k = 0; k < SECTIONS * PAPERS_SURFACES; k++)
            add_section(p, m, k / SECTIONS, k % SECTIONS, &sections[k / SECTIONS][k % SECTIONS]);
    if (status == BTG_OK) explain(p, sections);
    free(sections);
    return status;
}

/* ---- table 5 ------------------------------------------------------------------------------ */

/* --quick: so many times fewer positions. */
#define QUICK_STRIDE 16

static const char table_5[] = "VCRF table 5: time of 760 positions";

/* `stride`: every so many positions are timed, and the time taken so many times. */
static const struct {
    const char *name;
    size_t stride;
    double seconds[PAPERS_SURFACES]; /* the paper's */
} timed[] = {
    {"direct", 1, {27, 2.1, 104}}, {"bisection", 8, {7.0, 6.1, 2.1}}, {"sr", 16, {498, 476, 491}},
    {"drd", 16, {180, 256, 193}},  {"vcrf-grid", 2, {10, 9, 10}},     {"vcrf", 1, {NAN, NAN, NAN}},
};

static size_t stride_of(const papers *p, size_t k) {
    return timed[k].stride * (p->quick && timed[k].stride > 1 ? QUICK_STRIDE : 1);
}

static btg_status time_method(papers *p, size_t k, int surface) {
    size_t count;
    double *xy = papers_footprint(stride_of(p, k), &count), seconds = 0;
    btg_position *out = malloc((xy ? count : 1) * sizeof *out);
    btg_status status = BTG_ERROR_MEMORY;
    btg_method_def def = papers_method(timed[k].name);
    char what[64];
    snprintf(what, sizeof what, "table 5: %s on %s", timed[k].name, papers_surface[surface]);
    papers_show(p, what);
    if (xy && out)
        status = papers_solve(p, surface, &def, &p->solver, xy, count, out, &seconds, NULL);
    if (status == BTG_OK) {
        double all = seconds * 760 / (double)count;
        papers_row *row = papers_add(p, table_5, "s", all, timed[k].seconds[surface]);
        papers_name(row, papers_surface[surface], "%s%s", timed[k].name,
                    timed[k].seconds[0] > 0 ? "" : ", the exact solver");
    }
    free(xy);
    free(out);
    return status;
}

static btg_status times(papers *p) {
    btg_status status = BTG_OK;
    for (int surface = 0; surface < PAPERS_SURFACES; surface++)
        for (size_t k = 0; k < sizeof timed / sizeof *timed && status == BTG_OK; k++)
            status = time_method(p, k, surface);
    papers_note_add(
        p, table_5,
        "One thread here, 2.7 and 2.8 GHz machines there. direct, bisection, sr and drd "
        "are reconstructions: what they do is the papers', how fast they do it is ours. "
        "bisection is timed on one position in %zu, sr and drd on one in %zu, vcrf-grid "
        "on one in %zu, direct and vcrf on all.",
        stride_of(p, 1), stride_of(p, 2), stride_of(p, 4));
    papers_note_add(p, table_5,
                    "direct spends its time on positions that have no root: contacts on the part's "
                    "edge, where all its seeds are tried.");
    return status;
}

/* ---- figure 10 ---------------------------------------------------------------------------- */

static const char figure_10[] = "VCRF figure 10: distance of the contacts, three passes";
#define PASS_FEET 76
#define FEET      (SECTIONS * PASS_FEET)
#define BINS      14 /* 1 mm each */

typedef struct contacts {
    double p[2][FEET], q[2][FEET], joins[2][2 * FEET];
    double middle[BINS], share[BINS];
} contacts;

static void gather(const btg_position *positions, contacts *c, double gaps[3]) {
    gaps[0] = gaps[1] = gaps[2] = 0;
    *c = (contacts){0};
    for (int i = 0; i < BINS; i++)
        c->middle[i] = i + 0.5;
    for (int i = 0; i < FEET; i++) {
        const btg_position *at = &positions[i];
        double gap = papers_gap(at);
        c->p[0][i] = c->joins[0][2 * i] = at->p.point.x;
        c->p[1][i] = c->joins[1][2 * i] = at->p.point.y;
        c->q[0][i] = c->joins[0][2 * i + 1] = at->q.point.x;
        c->q[1][i] = c->joins[1][2 * i + 1] = at->q.point.y;
        if (isnan(gap)) continue;
        c->share[gap < BINS ? (int)gap : BINS - 1]++;
        gaps[0] += gap / FEET;
        gaps[1] += gap < 1;
        gaps[2] = fmax(gaps[2], gap);
    }
}

static void draw_contacts(const contacts *c, int surface, btg_chart_panel panel[2]) {
    static char title[PAPERS_SURFACES][2][64];
    snprintf(title[surface][0], sizeof title[0][0], "%s: contacts from above",
             papers_surface[surface]);
    snprintf(title[surface][1], sizeof title[0][1], "%s: how far P and Q are apart",
             papers_surface[surface]);
    panel[0] = btg_chart_panel_of(title[surface][0], "x, mm", "y, mm");
    panel[0].same_scale = true;
    btg_chart_add(&panel[0], BTG_CHART_JOINS, 4, NULL, c->joins[0], c->joins[1], 2 * FEET);
    btg_chart_add(&panel[0], BTG_CHART_DOTS, 0, "P", c->p[0], c->p[1], FEET);
    btg_chart_add(&panel[0], BTG_CHART_DOTS, 1, "Q", c->q[0], c->q[1], FEET);
    panel[1] = btg_chart_panel_of(title[surface][1], "|PQ|, mm", "positions");
    btg_chart_add(&panel[1], BTG_CHART_BARS, 0, NULL, c->middle, c->share, BINS);
}

static btg_status contacts_of_passes(papers *p, btg_position *out, contacts *c) {
    double xy[2 * FEET];
    btg_chart_panel panels[2 * PAPERS_SURFACES];
    for (int i = 0; i < FEET; i++) {
        xy[2 * i] = section_x[i / PASS_FEET];
        xy[2 * i + 1] = 2.0 * (i % PASS_FEET);
    }
    for (int k = 0; k < PAPERS_SURFACES; k++) {
        btg_method_def def = papers_method("vcrf");
        double gaps[3];
        btg_status status = papers_solve(p, k, &def, &p->solver, xy, FEET, out, NULL, NULL);
        if (status != BTG_OK) return status;
        gather(out, &c[k], gaps);
        papers_name(papers_add(p, figure_10, "mm", gaps[0], NAN), papers_surface[k], "mean");
        papers_name(papers_add(p, figure_10, "mm", gaps[2], NAN), papers_surface[k], "greatest");
        papers_name(papers_add(p, figure_10, "%", 100 * gaps[1] / FEET, NAN), papers_surface[k],
                    "positions below 1 mm");
        draw_contacts(&c[k], k, &panels[2 * k]);
    }
    papers_note_add(p, figure_10,
                    "The paper has pictures alone, no numbers; --pictures draws ours.");
    return papers_chart(p, "vcrf-figure-10", "Contacts of three passes, x = 36, 72, 108 mm", panels,
                        2 * PAPERS_SURFACES, 2);
}

btg_status papers_vcrf(papers *p) {
    btg_position *out = malloc(FEET * sizeof *out);
    contacts *c = malloc(PAPERS_SURFACES * sizeof *c);
    btg_status status = out && c ? differences(p) : BTG_ERROR_MEMORY;
    if (status == BTG_OK) status = times(p);
    if (status == BTG_OK) status = contacts_of_passes(p, out, c);
    free(out);
    free(c);
    if (status == BTG_ERROR_MEMORY) btg_fail(&p->message, status, "bench: out of memory");
    return status;
}
