/* The reference back end: dense sampling, then sections; in double, never optimised.
 *
 * The part is covered by charts: the faces of patches and triangles, and their edges. A chart is
 * cut into cells, each within a ball about its middle. No point of the ball meets the tool before
 * the middle meets the tool thickened by the ball's radius: a cell that cannot beat the best
 * answer even so is left out. In all others sections in both parameters look for the cell's own
 * best, and Newton's method on the tangency of tool and part settles the contact. No tree, and
 * nothing shared with the core's search but the rays. */
#include "backend/internal.h"

#include "core/part.h"
#include "core/ray.h"

#include <string.h>

/* Cells are that much smaller than the cutter's radius, and patches have that many a degree. */
#define CELLS_PER_RADIUS 8
#define CELLS_PER_DEGREE 4
/* Most cells of a part (40 bytes each); beyond it they grow, and are halved while searching. */
#define CELLS_MAX 2000000
/* The ball of a patch's cell, in distances of its middle to its corners: such small cells are
 * nearly parallelograms. */
#define BALL_MARGIN 1.25
/* A cell is halved that often, to see whether any piece of it may still win. */
#define HALVINGS 2
/* Even samples of a section, before Brent's method. */
#define SECTION_STEPS 5
/* Where sections end, in lengths of the section: in cells, and around the best of all. */
#define SECTION_END 1e-6
#define FINAL_END   1e-8
/* Margin of a cell, in its lengths: so wide that a best sample at its end is not in the cell. */
#define OVERLAP 0.5
/* A sheet contains P when it comes that close, in reaches of the tool. */
#define SAME_POINT 1e-9
/* A point that near a sharp rim (part of its radius) is on it, and is put that far inside. */
#define RIM_MARGIN 1e-4
#define RIM_INSIDE 1e-13

/* P is on an edge that comes that close, in clearances. */
#define ON_EDGE 0.01

typedef enum side { FACE, EDGE_A, EDGE_B, EDGE_C, EDGE_D } side;

/* A face by two parameters 0..1, or an edge by the first of them. */
typedef struct chart {
    uint32_t item;
    side side;
    int na, nb;
    size_t first; /* cell */
} chart;

typedef struct cell {
    btg_vec3 centre;
    double radius;
} cell;

typedef struct box {
    double a0, a1, b0, b1;
} box;

typedef struct samples {
    const btg_part *part;
    double spacing; /* mm */
    chart *charts;
    size_t chart_count;
    cell *cells;
    size_t cell_count;
} samples;

/* ---- charts ------------------------------------------------------------------------------- */

static btg_place place_at(const btg_part *part, const chart *c, double a, double b) {
    if (c->item < part->patch_count) {
        switch (c->side) {
        case FACE:
            return (btg_place){c->item, a, b};
        case EDGE_A:
            return (btg_place){c->item, a, 0};
        case EDGE_B:
            return (btg_place){c->item, a, 1};
        case EDGE_C:
            return (btg_place){c->item, 0, a};
        default:
            return (btg_place){c->item, 1, a};
        }
    }
    switch (c->side) {
    case FACE:
        return (btg_place){c->item, a, b * (1 - a)};
    case EDGE_A:
        return (btg_place){c->item, a, 0};
    case EDGE_B:
        return (btg_place){c->item, 0, a};
    default:
        return (btg_place){c->item, 1 - a, a};
    }
}

static btg_vec3 point_at(const samples *data, const chart *c, double a, double b) {
    btg_place place = place_at(data->part, c, a, b);
    if (place.item < data->part->patch_count)
        return btg_patch_point(&data->part->patches[place.item], place.u, place.v);
    btg_vec3 k[3];
    btg_triangle_corners(data->part, place.item - data->part->patch_count, k);
    btg_vec3 s = vec_mad(k[0], vec_sub(k[1], k[0]), place.u);
    return vec_mad(s, vec_sub(k[2], k[0]), place.v);
}

static box cell_box(const chart *c, int i, int j) {
    return (box){(double)i / c->na, (i + 1.0) / c->na, (double)j / c->nb, (j + 1.0) / c->nb};
}

/* The ball about the middle of a box that holds the chart's points there. */
static cell ball(const samples *data, const chart *c, box x) {
    double a = 0.5 * (x.a0 + x.a1), b = 0.5 * (x.b0 + x.b1);
    cell out = {point_at(data, c, a, b), 0};
    for (int i = 0; i < 4; i++) {
        btg_vec3 s = point_at(data, c, i & 1 ? x.a1 : x.a0, i & 2 ? x.b1 : x.b0);
        out.radius = fmax(out.radius, vec_norm(vec_sub(s, out.centre)));
    }
    out.radius = BALL_MARGIN * out.radius + 1e-14 * data->part->scale;
    return out;
}

/* Longest way across the chart along one parameter, over a coarse grid of chords. */
static double chart_length(const samples *data, const chart *c, bool along_a) {
    enum { LINES = 9, CHORDS = 16 };
    double longest = 0;
    for (int line = 0; line <= LINES; line++) {
        double across = (double)line / LINES, length = 0;
        btg_vec3 last = vec(0, 0, 0);
        for (int k = 0; k <= CHORDS; k++) {
            double t = (double)k / CHORDS;
            btg_vec3 s = along_a ? point_at(data, c, t, across) : point_at(data, c, across, t);
            if (k > 0) length += vec_norm(vec_sub(s, last));
            last = s;
        }
        longest = fmax(longest, length);
    }
    return longest;
}

static int cell_count(double length, double spacing, int least) {
    double n = ceil(length / spacing);
    return n > 1e4 ? 10000 : n > least ? (int)n : least;
}

static void chart_divide(const samples *data, double spacing, chart *c) {
    int least_a = 1, least_b = 1;
    if (c->item < data->part->patch_count) {
        const btg_patch *patch = &data->part->patches[c->item];
        least_a = CELLS_PER_DEGREE * patch->degree_u;
        least_b = CELLS_PER_DEGREE * patch->degree_v;
        if (c->side == EDGE_C || c->side == EDGE_D) least_a = least_b;
    }
    c->na = cell_count(chart_length(data, c, true), spacing, least_a);
    c->nb = 1;
    if (c->side == FACE) c->nb = cell_count(chart_length(data, c, false), spacing, least_b);
}

/* Divides all charts, ever more coarsely until the cells are few enough. */
static void divide(samples *data) {
    for (double spacing = data->spacing;; spacing *= 2) {
        data->cell_count = 0;
        for (size_t i = 0; i < data->chart_count; i++) {
            chart *c = &data->charts[i];
            chart_divide(data, spacing, c);
            c->first = data->cell_count;
            data->cell_count += (size_t)c->na * (size_t)c->nb;
        }
        if (data->cell_count <= CELLS_MAX || spacing > BTG_LENGTH_MAX) return;
    }
}

/* ---- one query ---------------------------------------------------------------------------- */

typedef struct search {
    const samples *data;
    btg_ray_query query;
    btg_ray_query wide_query; /* of the thickened tool */
    btg_tool wide_tool;
    double reach; /* of the tool, from its axis (DROP) or from o1 (TILT) */
    double found; /* best value so far: what others must beat */
    btg_ray_hit best;
    const chart *best_chart; /* NULL: nothing found */
    double best_a, best_b;
    btg_placement placement; /* of the tool at the best value */
    bool nearest;            /* look for the point next to P instead */
    double same_point;       /* mm */
    bool on_rim;             /* the best is on a sharp rim */
    double asked;            /* TILT: as deep in the part as that may the start pose be, mm */
    bool gouges;             /* it is deeper */
    uint32_t points;
} search;

/* How good a point is. One that the tool never meets counts by its distance to the best
 * placement, so that sections find their way to the tool. */
typedef struct score {
    bool hit;
    double value;
} score;

static bool better(score a, score b) {
    return a.hit != b.hit ? a.hit : a.value > b.value;
}

static void set_found(search *s, double value) {
    s->found = value;
    if (s->nearest) return;
    s->placement = btg_ray_place(&s->query, fmax(value, -10 * BTG_LENGTH_MAX));
}

static void search_init(search *s, const samples *data, btg_ray_query query, double found) {
    memset(s, 0, sizeof *s);
    s->data = data;
    s->query = s->wide_query = query;
    s->wide_tool = *query.tool;
    s->wide_query.p_clearance2 = 0;
    double major = query.tool->element[0].ring_radius_mm;
    for (uint32_t i = 0; i < query.tool->element_count; i++) {
        const btg_tool_element *e = &query.tool->element[i];
        double r = e->ring_radius_mm + e->corner_radius_mm;
        if (query.op == BTG_OP_TILT) r = hypot(major + r, i > 0 ? e->to_mm : 0);
        s->reach = fmax(s->reach, r);
    }
    s->same_point = SAME_POINT * s->reach + 1e-13 * data->part->scale;
    set_found(s, found);
}

/* The number to be maximised at one point; false: the tool never meets it. */
static bool value_at(const search *s, btg_vec3 point, btg_ray_hit *hit) {
    if (!s->nearest) return btg_ray_cast(&s->query, point, hit);
    *hit = (btg_ray_hit){.value = -vec_norm(vec_sub(point, s->query.p))};
    return true;
}

static score score_at(search *s, const chart *c, double a, double b) {
    btg_vec3 point = point_at(s->data, c, a, b);
    s->points++;
    btg_ray_hit hit;
    if (value_at(s, point, &hit)) {
        if (hit.value > s->found) {
            s->best = hit;
            s->best_chart = c;
            s->best_a = a;
            s->best_b = b;
            set_found(s, hit.value);
        }
        return (score){true, hit.value};
    }
    double least = INFINITY;
    for (uint32_t i = 0; i < s->query.tool->element_count; i++) {
        const btg_tool_element *e = &s->query.tool->element[i];
        least = fmin(least, btg_ray_tool_distance(e, s->placement, point).distance);
    }
    return (score){false, -least};
}

/* Whether any point of the ball may beat the best so far: the ball's middle against the tool
 * thickened by its radius. */
static bool may_win(search *s, const cell *x) {
    double r = x->radius;
    btg_vec3 d = vec_sub(x->centre, s->query.o);
    if (s->query.op == BTG_OP_DROP) d = vec_mad(d, s->query.w, -vec_dot(d, s->query.w));
    double away = vec_norm(d), corner = s->query.tool->element[0].corner_radius_mm;
    if (away > s->reach + r) return false;
    if (s->query.op == BTG_OP_TILT && away < corner + r) return true;
    for (uint32_t i = 0; i < s->wide_tool.element_count; i++) {
        const btg_tool_element *from = &s->query.tool->element[i];
        btg_tool_element *to = &s->wide_tool.element[i];
        if (i == 0) {
            to->corner_radius_mm = from->corner_radius_mm + r;
        } else {
            to->ring_radius_mm = from->ring_radius_mm + r;
            to->from_mm = from->from_mm - r;
            to->to_mm = from->to_mm + r;
        }
    }
    s->wide_query.tool = &s->wide_tool;
    s->wide_query.p = vec_mad(s->query.p, s->query.n, -r);
    btg_ray_hit hit;
    return btg_ray_cast(&s->wide_query, x->centre, &hit) && hit.value > s->found;
}

static bool pieces_may_win(search *s, const chart *c, box x, int halvings) {
    cell around = ball(s->data, c, x);
    if (!may_win(s, &around)) return false;
    if (halvings == 0) return true;
    double a = 0.5 * (x.a0 + x.a1), b = 0.5 * (x.b0 + x.b1);
    if (c->side != FACE)
        return pieces_may_win(s, c, (box){x.a0, a, x.b0, x.b1}, halvings - 1) ||
               pieces_may_win(s, c, (box){a, x.a1, x.b0, x.b1}, halvings - 1);
    return pieces_may_win(s, c, (box){x.a0, a, x.b0, b}, halvings - 1) ||
           pieces_may_win(s, c, (box){a, x.a1, x.b0, b}, halvings - 1) ||
           pieces_may_win(s, c, (box){x.a0, a, b, x.b1}, halvings - 1) ||
           pieces_may_win(s, c, (box){a, x.a1, b, x.b1}, halvings - 1);
}

/* ---- one variable after the other --------------------------------------------------------- */

/* A line across a box: one parameter runs, the other is fixed or itself the best of a line. */
typedef struct line {
    search *s;
    const chart *chart;
    box box;
    double a, end;
} line;

typedef score (*line_score)(line *l, double t);

/* Brent's method (R. P. Brent, "Algorithms for Minimization without Derivatives", 1973, chapter
 * 5): golden sections, and parabolas through the best three where the value is smooth. */
typedef struct brent {
    double lo, hi, x, w, v; /* w and v: second and third best */
    score fx, fw, fv;
    double step, before;
} brent;

static bool parabola(brent *m, double end) {
    if (fabs(m->before) <= end || !m->fx.hit || !m->fw.hit || !m->fv.hit) return false;
    double r = (m->x - m->w) * (m->fx.value - m->fv.value);
    double q = (m->x - m->v) * (m->fx.value - m->fw.value);
    double p = (m->x - m->v) * q - (m->x - m->w) * r;
    q = 2 * (q - r);
    if (q > 0) p = -p;
    q = fabs(q);
    if (fabs(p) >= fabs(0.5 * q * m->before) || p <= q * (m->lo - m->x) || p >= q * (m->hi - m->x))
        return false;
    m->before = m->step;
    m->step = p / q;
    double t = m->x + m->step;
    if (t - m->lo < 2 * end || m->hi - t < 2 * end)
        m->step = copysign(end, 0.5 * (m->lo + m->hi) - m->x);
    return true;
}

static void brent_insert(brent *m, double t, score f) {
    if (!better(m->fx, f)) {
        *(t >= m->x ? &m->lo : &m->hi) = m->x;
        m->v = m->w, m->fv = m->fw;
        m->w = m->x, m->fw = m->fx;
        m->x = t, m->fx = f;
        return;
    }
    *(t < m->x ? &m->lo : &m->hi) = t;
    if (!better(m->fw, f) || m->w == m->x) {
        m->v = m->w, m->fv = m->fw;
        m->w = t, m->fw = f;
    } else if (!better(m->fv, f) || m->v == m->x || m->v == m->w) {
        m->v = t, m->fv = f;
    }
}

static score brent_best(line *l, line_score at, brent m, double end) {
    for (int i = 0; i < 100; i++) {
        double middle = 0.5 * (m.lo + m.hi);
        if (fabs(m.x - middle) <= 2 * end - 0.5 * (m.hi - m.lo)) break;
        if (!parabola(&m, end)) {
            m.before = m.x < middle ? m.hi - m.x : m.lo - m.x;
            m.step = 0.38196601125010515 * m.before;
        }
        double t = m.x + (fabs(m.step) >= end ? m.step : copysign(end, m.step));
        brent_insert(&m, t, at(l, t));
    }
    return m.fx;
}

/* The best of a few even samples, then Brent's method between its neighbours. `open`: bits that
 * say the box goes on beyond t0 (1) or t1 (2); a best sample there is another cell's business. */
static score section(line *l, line_score at, double t0, double t1, int open) {
    double step = (t1 - t0) / SECTION_STEPS;
    int best_i = 0;
    score best = at(l, t0);
    for (int i = 1; i <= SECTION_STEPS; i++) {
        score x = at(l, i == SECTION_STEPS ? t1 : t0 + i * step);
        if (!better(x, best)) continue;
        best = x;
        best_i = i;
    }
    if ((best_i == 0 && (open & 1)) || (best_i == SECTION_STEPS && (open & 2))) return best;
    double t = best_i == SECTION_STEPS ? t1 : t0 + best_i * step;
    brent m = {fmax(t0, t - step), fmin(t1, t + step), t, t, t, best, best, best, 0, 0};
    return brent_best(l, at, m, l->end * (t1 - t0));
}

static score inner_score(line *l, double b) {
    return score_at(l->s, l->chart, l->a, b);
}

static score outer_score(line *l, double a) {
    l->a = a;
    if (l->chart->side != FACE) return score_at(l->s, l->chart, a, 0);
    return section(l, inner_score, l->box.b0, l->box.b1, 0);
}

/* The best of a cell, with a margin that neighbours share. */
static void zoom(search *s, const chart *c, box x) {
    double da = OVERLAP * (x.a1 - x.a0), db = OVERLAP * (x.b1 - x.b0);
    box wide = {fmax(0, x.a0 - da), fmin(1, x.a1 + da), fmax(0, x.b0 - db), fmin(1, x.b1 + db)};
    line l = {s, c, wide, 0, SECTION_END};
    section(&l, outer_score, wide.a0, wide.a1, (x.a0 > 0 ? 1 : 0) | (x.a1 < 1 ? 2 : 0));
}

/* Once more around the best, to the end. */
static void zoom_best(search *s) {
    const chart *c = s->best_chart;
    double a = s->best_a, b = s->best_b, da = 0.02 / c->na, db = 0.02 / c->nb;
    box near = {fmax(0, a - da), fmin(1, a + da), fmax(0, b - db), fmin(1, b + db)};
    line l = {s, c, near, 0, FINAL_END};
    section(&l, outer_score, near.a0, near.a1, 0);
}

/* ---- the whole part ----------------------------------------------------------------------- */

/* Cells of parts too large for fine ones are halved here. */
static void visit(search *s, const chart *c, box x, const cell *around) {
    if (!may_win(s, around)) return;
    if (around->radius <= s->data->spacing) {
        if (pieces_may_win(s, c, x, HALVINGS)) zoom(s, c, x);
        return;
    }
    double a = 0.5 * (x.a0 + x.a1), b = 0.5 * (x.b0 + x.b1);
    box piece[4] = {{x.a0, a, x.b0, x.b1}, {a, x.a1, x.b0, x.b1}};
    if (c->side == FACE) {
        piece[0].b1 = piece[1].b1 = b;
        piece[2] = (box){x.a0, a, b, x.b1};
        piece[3] = (box){a, x.a1, b, x.b1};
    }
    for (int i = 0; i < (c->side == FACE ? 4 : 2); i++) {
        cell smaller = ball(s->data, c, piece[i]);
        visit(s, c, piece[i], &smaller);
    }
}

static btg_vec3 chart_tangent(const search *s, const btg_surface_point *at) {
    const chart *c = s->best_chart;
    bool patch = c->item < s->data->part->patch_count;
    if (!patch && c->side == EDGE_C) return vec_sub(at->sv, at->su);
    bool along_v = patch ? c->side == EDGE_C || c->side == EDGE_D : c->side == EDGE_B;
    return along_v ? at->sv : at->su;
}

/* Two numbers that vanish at the contact. A round tool: derivatives of its distance along the
 * chart, the tool placed at the point itself. A sharp rim: the point is on the rim, and the rim
 * runs along the part. */
static bool tangency(search *s, double a, double b, double residual[2]) {
    btg_surface_point at;
    btg_part_point(s->data->part, place_at(s->data->part, s->best_chart, a, b), &at);
    btg_ray_query query = s->query;
    btg_tool tool = *query.tool;
    query.tool = &tool;
    if (s->on_rim) tool.element[s->best.element].ring_radius_mm *= 1 + RIM_MARGIN;
    btg_ray_hit hit;
    if (!btg_ray_cast(&query, at.s, &hit) || hit.element != s->best.element) return false;
    const btg_tool_element *e = &s->query.tool->element[hit.element];
    btg_placement placement = btg_ray_place(&query, hit.value);
    btg_ray_distance d = btg_ray_tool_distance(e, placement, at.s);
    bool face = s->best_chart->side == FACE;
    if (s->on_rim) {
        btg_vec3 arm = vec_sub(at.s, placement.centre);
        double r = vec_norm(vec_mad(arm, placement.axis, -vec_dot(arm, placement.axis)));
        residual[0] = r / e->ring_radius_mm - (1 - RIM_INSIDE);
        residual[1] = vec_dot(vec_unit(vec_cross(at.su, at.sv)), d.ring_tangent);
    } else {
        residual[0] = vec_dot(chart_tangent(s, &at), d.normal);
        residual[1] = vec_dot(at.sv, d.normal);
    }
    if (!face) residual[1] = 0;
    return true;
}

/* One step of Newton's method on the tangency, by central differences. */
static bool newton_step(search *s, double *a, double *b) {
    const double h = 1e-6;
    double r[2], al[2], ah[2], bl[2], bh[2];
    if (!tangency(s, *a, *b, r) || !tangency(s, *a - h, *b, al) || !tangency(s, *a + h, *b, ah) ||
        !tangency(s, *a, *b - h, bl) || !tangency(s, *a, *b + h, bh))
        return false;
    double aa = (ah[0] - al[0]) / (2 * h), ba = (ah[1] - al[1]) / (2 * h);
    double ab = (bh[0] - bl[0]) / (2 * h), bb = (bh[1] - bl[1]) / (2 * h);
    if (s->best_chart->side != FACE) ba = ab = 0, bb = 1;
    double det = aa * bb - ab * ba;
    if (det == 0) return false;
    *a -= (r[0] * bb - r[1] * ab) / det;
    *b -= (r[1] * aa - r[0] * ba) / det;
    return true;
}

static bool is_on_rim(const search *s) {
    const btg_tool_element *e = &s->query.tool->element[s->best.element];
    btg_vec3 arm =
        vec_sub(point_at(s->data, s->best_chart, s->best_a, s->best_b), s->placement.centre);
    double z = vec_dot(arm, s->placement.axis);
    double r = vec_norm(vec_mad(arm, s->placement.axis, -z)), near = RIM_MARGIN * e->ring_radius_mm;
    return e->corner_radius_mm == 0 && fabs(r - e->ring_radius_mm) < near &&
           fabs(z - e->from_mm) < near;
}

/* Sections find the best value; where it is lies in their rounding, some 1e-8 of the part. */
static void settle(search *s) {
    double a = s->best_a, b = s->best_b, slack = 1e-13 * (1 + s->data->part->scale);
    s->on_rim = is_on_rim(s);
    for (int i = 0; i < 8; i++) {
        if (!newton_step(s, &a, &b) || !(a >= 0 && a <= 1 && b >= 0 && b <= 1)) return;
        btg_ray_hit hit;
        btg_vec3 point = point_at(s->data, s->best_chart, a, b);
        if (!btg_ray_cast(&s->query, point, &hit) || hit.value < s->found - slack) continue;
        s->best = hit;
        s->best_a = a;
        s->best_b = b;
    }
}

typedef void (*cell_visit)(search *s, const chart *c, box x, const cell *around);

static void for_each_cell(search *s, cell_visit each) {
    for (size_t i = 0; i < s->data->chart_count; i++) {
        const chart *c = &s->data->charts[i];
        const cell *at = s->data->cells + c->first;
        for (int ia = 0; ia < c->na; ia++)
            for (int ib = 0; ib < c->nb; ib++)
                each(s, c, cell_box(c, ia, ib), at++);
    }
}

static void sample(search *s, const chart *c, box x, const cell *around) {
    if (may_win(s, around)) score_at(s, c, 0.5 * (x.a0 + x.a1), 0.5 * (x.b0 + x.b1));
}

/* Samples first, then the best one's cell, then every cell that may still win. */
static bool solve(search *s) {
    for_each_cell(s, sample);
    if (s->best_chart) {
        const chart *c = s->best_chart;
        int ia = (int)(s->best_a * c->na), ib = (int)(s->best_b * c->nb);
        zoom(s, c, cell_box(c, ia, ib));
    }
    for_each_cell(s, visit);
    if (s->best_chart) {
        zoom_best(s);
        settle(s);
    }
    return s->best_chart;
}

/* ---- where P and Q meet ------------------------------------------------------------------- */

/* The limit of one sheet at a place where it contains P; `corner` turns a triangle so that each
 * of its edges is once the one along u. */
static void limit_at(search *s, btg_place at, int corner) {
    const btg_part *part = s->data->part;
    bool edge_u, edge_v;
    double value;
    btg_surface_point f;
    btg_part_point(part, at, &f);
    /* an edge this near to P lies all inside the clearance, where only limits speak */
    double near = ON_EDGE * sqrt(s->query.p_clearance2);
    double tu = near / (vec_norm(f.su) + near), tv = near / (vec_norm(f.sv) + near);
    if (at.item < part->patch_count) {
        edge_u = at.u < tu || at.u > 1 - tu;
        edge_v = at.v < tv || at.v > 1 - tv;
    } else {
        const double weight[3] = {1 - at.u - at.v, at.u, at.v};
        btg_vec3 k[3];
        btg_triangle_corners(part, at.item - part->patch_count, k);
        f.su = vec_sub(k[(corner + 1) % 3], k[corner]);
        f.sv = vec_sub(k[(corner + 2) % 3], k[corner]);
        edge_u = false;
        edge_v = weight[(corner + 2) % 3] < fmax(tu, tv);
    }
    if (btg_ray_osculating(&s->query, &f, edge_u, edge_v, &value) && value > s->found)
        set_found(s, value);
}

/* All limits of one sheet at a place. */
static void limits_at(search *s, btg_place at) {
    bool patch = at.item < s->data->part->patch_count;
    for (int corner = 0; corner < (patch ? 1 : 3); corner++)
        limit_at(s, at, corner);
}

/* A cell that contains P: sections for the point next to P, then that sheet's limit. */
static void visit_p(search *s, const chart *c, box x, const cell *around) {
    if (c->side != FACE) return;
    if (vec_norm(vec_sub(around->centre, s->query.p)) > around->radius + s->same_point) return;
    search near = *s;
    near.nearest = true;
    near.best_chart = NULL;
    near.found = -s->same_point;
    zoom(&near, c, x);
    s->points = near.points;
    if (!near.best_chart) return;
    limits_at(s, place_at(s->data->part, c, near.best_a, near.best_b));
}

/* ---- the back end ------------------------------------------------------------------------- */

/* The tool's normal; where a sharp rim has none, that of the part. */
static btg_contact contact(const search *s) {
    btg_place place = place_at(s->data->part, s->best_chart, s->best_a, s->best_b);
    btg_surface_point at;
    btg_part_point(s->data->part, place, &at);
    btg_placement placement = btg_ray_place(&s->query, s->best.value);
    const btg_tool_element *e = &s->query.tool->element[s->best.element];
    btg_vec3 normal = vec_scale(btg_ray_tool_distance(e, placement, at.s).normal, -1);
    btg_vec3 own = vec_unit(vec_cross(at.su, at.sv));
    if (e->corner_radius_mm == 0 && s->best_chart->side == FACE && vec_norm2(own) > 0)
        normal = vec_dot(own, placement.axis) < 0 ? vec_scale(own, -1) : own;
    return (btg_contact){place, at.s, normal};
}

/* Shank and holder do not touch the part at P: as deep as that part of what is asked may they be.
 */
#define TOUCH_SHARE 2e-4

/* A point is deeper in an element of the tool as it starts than asked and than rounding. */
static void see_start(search *s, btg_vec3 point, uint32_t element) {
    const btg_tool_element *e = &s->query.tool->element[element];
    btg_placement start = btg_ray_place(&s->query, 0);
    double most =
        fmax(element > 0 ? TOUCH_SHARE * s->asked : s->asked, 1e-9 * s->data->part->scale);
    s->gouges |= -btg_ray_tool_distance(e, start, point).distance > most;
}

static void sample_start(search *s, const chart *c, box x, const cell *around) {
    (void)around;
    btg_vec3 point = point_at(s->data, c, 0.5 * (x.a0 + x.a1), 0.5 * (x.b0 + x.b1));
    btg_ray_hit hit;
    if (btg_ray_cast(&s->query, point, &hit) && hit.value > 0) see_start(s, point, hit.element);
}

/* The start pose cuts into the part: at any sample, or where the tool would be met first. */
static bool gouges(search *s, double tolerance) {
    s->asked = tolerance;
    for_each_cell(s, sample_start);
    if (s->best_chart && s->best.value > 0)
        see_start(s, point_at(s->data, s->best_chart, s->best_a, s->best_b), s->best.element);
    return s->gouges;
}

static btg_status drop(const btg_backend_setup *setup, const void *data,
                       const btg_drop_query *query, void *workspace, size_t workspace_size,
                       btg_drop_result *result) {
    (void)workspace, (void)workspace_size;
    search s;
    search_init(&s, data, btg_ray_query_drop(&setup->tool, query), -INFINITY);
    *result = (btg_drop_result){.status = BTG_NO_CONTACT, .bound_mm = NAN};
    if (solve(&s))
        *result = (btg_drop_result){BTG_OK, s.best.value, contact(&s), NAN, s.best.element, 0};
    result->nodes = s.points;
    return result->status;
}

static btg_status tilt(const btg_backend_setup *setup, const void *data,
                       const btg_tilt_query *query, void *workspace, size_t workspace_size,
                       btg_tilt_result *result) {
    (void)workspace, (void)workspace_size;
    search s;
    double limit;
    search_init(&s, data, btg_ray_query_tilt(&setup->tool, query), -query->max_tilt_rad);
    if (btg_ray_tool_limit(&s.query, &limit) && limit > s.found) set_found(&s, limit);
    limits_at(&s, query->p.place);
    for_each_cell(&s, visit_p);
    *result = (btg_tilt_result){BTG_SINGLE_CONTACT, query->max_tilt_rad, query->p, NAN, 0, 0};
    if (s.found > -query->max_tilt_rad) {
        result->status = BTG_OSCULATING;
        result->tilt_rad = fmax(0, -s.found);
    }
    bool met = solve(&s);
    if (gouges(&s, setup->solver.tolerance_mm)) return BTG_ERROR_GOUGE;
    if (met)
        *result =
            (btg_tilt_result){BTG_OK, fmax(0, -s.best.value), contact(&s), NAN, s.best.element, 0};
    result->nodes = s.points;
    return result->status;
}

static size_t no_workspace(const btg_part *part) {
    (void)part;
    return 0;
}

static void release(const btg_backend_setup *setup, void *data) {
    samples *d = data;
    btg_release(&setup->allocator, d->charts);
    btg_release(&setup->allocator, d->cells);
    btg_release(&setup->allocator, d);
}

static void fill_charts(samples *data) {
    const btg_part *part = data->part;
    size_t n = 0;
    for (uint32_t item = 0; item < part->patch_count + part->triangle_count; item++)
        for (int i = 0; i < (item < part->patch_count ? 5 : 4); i++)
            data->charts[n++] = (chart){.item = item, .side = (side)i};
}

static void fill_cells(samples *data) {
    for (size_t i = 0; i < data->chart_count; i++) {
        const chart *c = &data->charts[i];
        cell *at = data->cells + c->first;
        for (int ia = 0; ia < c->na; ia++)
            for (int ib = 0; ib < c->nb; ib++)
                *at++ = ball(data, c, cell_box(c, ia, ib));
    }
}

static btg_status prepare(const btg_backend_setup *setup, void **out, btg_message *message) {
    const btg_part *part = setup->part;
    const btg_tool_element *cutter = &setup->tool.element[0];
    samples *d = btg_allocate(&setup->allocator, 1, sizeof *d);
    if (!d) return btg_fail(message, BTG_ERROR_MEMORY, "reference: out of memory");
    *d = (samples){.part = part};
    d->spacing = fmax(cutter->corner_radius_mm, cutter->ring_radius_mm / 2) / CELLS_PER_RADIUS;
    d->chart_count = 5 * (size_t)part->patch_count + 4 * (size_t)part->triangle_count;
    d->charts = btg_allocate(&setup->allocator, d->chart_count, sizeof *d->charts);
    if (d->charts) {
        fill_charts(d);
        divide(d);
        d->cells = btg_allocate(&setup->allocator, d->cell_count, sizeof *d->cells);
    }
    if (!d->cells) {
        release(setup, d);
        return btg_fail(message, BTG_ERROR_MEMORY, "reference: out of memory");
    }
    fill_cells(d);
    *out = d;
    return BTG_OK;
}

static const btg_host_ops ops = {.workspace_size = no_workspace,
                                 .prepare = prepare,
                                 .release = release,
                                 .drop = drop,
                                 .tilt = tilt};

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    return btg_host_open(&ops, setup, state, message);
}

const btg_backend_table btg_backend_reference = {
    .name = "reference",
    .summary = "dense sampling and golden sections in double: slow, to check the others",
    .probe = btg_host_probe,
    .open = open,
    .close = btg_host_close,
    .drop = btg_host_drop,
    .tilt = btg_host_tilt,
    .threads = btg_host_threads};
