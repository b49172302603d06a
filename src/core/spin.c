/* Which spin: gap, across, widest.
 *
 * The family over the spin angle is that of S. K. Sharma, R. K. Duvedi, S. Bedi, S. Mann,
 * "Numerical implementation of drop spin and tilt method for five-axis tool positioning for tensor
 * product surfaces", which picks from it by hand; each member is one TILT in closed form here.
 *
 * What is continuous: the inclination, a maximum over the part, is continuous in the spin. Q, and
 * with it |PQ|, its direction and the strip, is so in pieces: it jumps where two places tie. What
 * to expect of a piece: both contacts lie near one circle of the tool, so that
 *
 *     |PQ| = D cos(alpha - heading),
 *
 * heading being the spin that puts the tool's centre over Q, and D and heading change slowly: the
 * part's curvature at P holds them. So one tilt predicts the four spins with a given |PQ|, two to
 * either side, and a secant then ends the matter; brackets, a scan and a parabola are there for
 * parts that do not follow. The strip is widest where the clearance between P and Q just reaches
 * the scallop, which is a matter of |PQ| as well (its fourth power), or where it is smooth. */
#include "core/spin.h"
#include "core/check.h"
#include "core/part.h"
#include "core/strip.h"

#define DEGREE (BTG_PI / 180)

/* What counts as met, and where a search stops: half of it, for the rounding of a frame. */
#define GAP_MET_MM     1e-4
#define ACROSS_MET_RAD (1e-3 * DEGREE)
#define STOP           0.5

#define SCALLOP_DEFAULT_MM 0.01

/* Spins this close are one; a bracket that narrow holds a jump. */
#define SAME_SPIN 1e-9
/* Places this close, in parameters of a patch, are one contact. */
#define SAME_PLACE 1e-8
/* At right angles to the heading there is no |PQ| to go by. */
#define COS_MIN 1e-3
/* A value that changes across a bracket by that many times what any smooth piece would. */
#define JUMP 20.0
/* A scan's step, and the step of a first slope. */
#define SCAN_STEP  (60 * DEGREE)
#define SLOPE_STEP (4 * DEGREE)
/* Steps after a model or a slope before the scan. */
#define TRIES 5
/* Values farther apart say nothing about what is between them. */
#define WIDEST_BRACKET (2 * SCAN_STEP)
/* Steps toward the greatest value of a parabola: for a strip, and for the nearest spin where none
 * meets the aim. */
#define POLISHES_WIDEST 3
#define POLISHES        2
/* Widest: the spin need not be known better, its strip changes by less than a percent. */
#define WIDEST_SPIN (0.5 * DEGREE)
/* Widest: spins farther apart may hide a strip between them. */
#define WIDEST_APART (75 * DEGREE)

/* Widest: the crest to aim at, part of the scallop, and what is good enough. Beyond 1 the strip
 * falls in two. */
#define CREST_AIM  0.97
#define CREST_GOOD 0.94
/* From here on the crest is a matter of |PQ| alone. */
#define CREST_NEAR 0.05
/* What could be there may be that much more, foreseen from a crest e times as high. */
#define COULD_ERROR 0.15
/* A strip that much wider is worth another tilt. */
#define WORTH 0.003
/* A branch that has no strip of its own so near its place is none. */
#define UNSEEN (8 * DEGREE)

/* From the Q of a spin so near the way uphill leads to that of another, as a rule. */
#define GUESS_WITHIN (25 * DEGREE)
/* Q foreseen by the model is no nearer to P and no farther from it, in parts of the Q it is
 * foreseen from. */
#define FORESEEN_LEAST 0.2
#define FORESEEN_MOST  2.0
/* So many guesses may be wrong before there are no more of them. */
#define MISLED_MOST 2

static double wrap(double angle) {
    return angle - 2 * BTG_PI * floor(angle / (2 * BTG_PI) + 0.5);
}

static double distance(double a, double b) {
    return fabs(wrap(a - b));
}

/* ---- what a spin is worth ----------------------------------------------------------------- */

static btg_vec3 feed_of(const btg_solver_def *solver) {
    double length = hypot(solver->feed_x, solver->feed_y);
    if (!(length > 0)) return vec(0, 1, 0);
    return vec(solver->feed_x / length, solver->feed_y / length, 0);
}

static btg_strip_query strip_query(const btg_part *part, const btg_tool *tool,
                                   const btg_solver_def *solver) {
    btg_vec3 feed = feed_of(solver);
    return (btg_strip_query){.part = part,
                             .tool = tool,
                             .across = vec(feed.y, -feed.x, 0),
                             .scallop_mm =
                                 solver->scallop_mm > 0 ? solver->scallop_mm : SCALLOP_DEFAULT_MM};
}

/* The larger the better; NaN stays. */
static double score(const btg_spin_search *s, double value) {
    return s->solver->spin == BTG_SPIN_WIDEST ? value : -fabs(value);
}

static double limit(const btg_spin_search *s) {
    return s->solver->spin == BTG_SPIN_GAP ? GAP_MET_MM : ACROSS_MET_RAD;
}

/* The angle of PQ off the right angle to the feed, as a line and from above: -pi/2 .. pi/2. */
static double off_across(const btg_solver_def *solver, btg_vec3 pq) {
    btg_vec3 feed = feed_of(solver);
    double along = vec_dot(pq, feed), across = pq.x * feed.y - pq.y * feed.x;
    if (along == 0 && across == 0) return NAN;
    return across < 0 ? atan2(-along, -across) : atan2(along, across);
}

/* Q as a direction. */
static double heading_of(const btg_tilt_query *unspun, btg_vec3 pq) {
    btg_vec3 n = unspun->p.normal, e = vec_cross(n, unspun->u), right = vec_cross(n, e);
    return atan2(vec_dot(pq, right), vec_dot(pq, e));
}

/* The turn from the heading at which |PQ| is `gap`. */
static double half_of(const btg_spin_sample *sample, btg_vec3 pq, double gap) {
    double across = vec_norm(pq) / fmax(cos(sample->alpha - sample->heading), COS_MIN);
    return acos(fmin(gap / across, 1));
}

static void judge_widest(btg_spin_search *s, const btg_tilt_query *query,
                         const btg_tilt_result *tilt, btg_spin_sample *sample) {
    btg_strip_query *strip = &s->strip;
    btg_position_pose(s->tool, query, tilt->tilt_rad, &strip->pose.centre, &strip->pose.axis);
    bool two = tilt->status == BTG_OK;
    btg_strip found = btg_strip_measure(strip, &query->p, two ? &tilt->contact : NULL);
    sample->value = found.width_mm;
    if (!(found.crest_mm > 0)) return;
    sample->crest = found.crest_mm / strip->scallop_mm;
    sample->off_crest = log(sample->crest / CREST_AIM);
    btg_vec3 pq = vec_sub(tilt->contact.point, query->p.point);
    double stretch = sqrt(sqrt(CREST_AIM / sample->crest));
    sample->half = half_of(sample, pq, vec_norm(pq) * stretch);
    /* no farther apart than the model has them at the most */
    stretch = fmin(stretch, 1 / fmax(cos(sample->alpha - sample->heading), COS_MIN));
    sample->could = found.span_mm + (stretch - 1) * found.apart_mm;
}

static void judge(btg_spin_search *s, const btg_tilt_query *query, const btg_tilt_result *tilt,
                  btg_spin_sample *sample) {
    *sample = (btg_spin_sample){
        .alpha = s->asked, .value = NAN, .heading = NAN, .half = NAN, .crest = NAN, .could = NAN};
    bool two = tilt->status == BTG_OK;
    btg_vec3 pq = vec_sub(tilt->contact.point, query->p.point);
    if (!two && tilt->status != BTG_OSCULATING) return;
    if (two) sample->heading = heading_of(&s->unspun, pq);
    if (s->solver->spin == BTG_SPIN_WIDEST) {
        judge_widest(s, query, tilt, sample);
    } else if (s->solver->spin == BTG_SPIN_GAP) {
        sample->value = (two ? vec_norm(pq) : 0) - s->solver->gap_mm;
        if (two) sample->half = half_of(sample, pq, s->solver->gap_mm);
    } else if (two) {
        sample->value = off_across(s->solver, pq);
    }
}

/* ---- the spins tried ---------------------------------------------------------------------- */

static bool tried(const btg_spin_search *s, double alpha, double within) {
    for (uint32_t i = 0; i < s->count; i++)
        if (distance(s->sample[i].alpha, alpha) <= within) return true;
    return false;
}

/* The sample that follows another counter-clockwise (side 1) or clockwise (-1); itself when it is
 * alone. `way`: the turn to it. */
static const btg_spin_sample *neighbour(const btg_spin_search *s, const btg_spin_sample *of,
                                        double side, double *way) {
    const btg_spin_sample *found = of;
    *way = 2 * BTG_PI;
    for (uint32_t i = 0; i < s->count; i++) {
        double turn = side * wrap(s->sample[i].alpha - of->alpha);
        if (turn < 0) turn += 2 * BTG_PI;
        if (&s->sample[i] == of || turn >= *way) continue;
        found = &s->sample[i];
        *way = turn;
    }
    return found;
}

static const btg_spin_sample *best_of(const btg_spin_search *s) {
    const btg_spin_sample *best = NULL;
    for (uint32_t i = 0; i < s->count; i++) {
        double here = score(s, s->sample[i].value);
        if (here > -INFINITY && (!best || here > score(s, best->value))) best = &s->sample[i];
    }
    return best;
}

/* The first of the scan's spins that has not been tried. */
static bool scan(const btg_spin_search *s, double *alpha) {
    for (int k = 0; k < 6; k++) {
        double turn = SCAN_STEP * (k % 2 ? (k + 1) / 2 : -(k / 2));
        *alpha = wrap(s->start + turn);
        if (!tried(s, *alpha, 0.5 * SCAN_STEP)) return true;
    }
    *alpha = 0;
    return !s->any && !tried(s, 0, 0);
}

/* ---- roots: gap and across ---------------------------------------------------------------- */

/* From a to the spin `way` on, the value passes 0 without a jump. */
static bool brackets(const btg_spin_search *s, double a, double b, double way) {
    if (!(a * b < 0) || way <= SAME_SPIN || way > WIDEST_BRACKET) return false;
    double most = s->solver->spin == BTG_SPIN_GAP
                      ? s->tool->element[0].ring_radius_mm + s->tool->element[0].corner_radius_mm
                      : 1;
    double change = fabs(a - b);
    if (s->solver->spin == BTG_SPIN_ACROSS && change > BTG_PI / 2) return false;
    return change <= JUMP * most * way;
}

/* Inverse quadratic through three values, where they differ; else the secant of two. */
static double interpolate(double a, double fa, double b, double fb, double c, double fc) {
    if (fc == fa || fc == fb || !isfinite(fc)) return a - fa * (b - a) / (fb - fa);
    return a * fb * fc / ((fa - fb) * (fa - fc)) + b * fa * fc / ((fb - fa) * (fb - fc)) +
           c * fa * fb / ((fc - fa) * (fc - fb));
}

/* Inside the bracket from a, `way` wide, to b: by the third value nearby, or in the middle when
 * the last steps came from one side alone. */
static double step_inside(const btg_spin_search *s, const btg_spin_sample *a,
                          const btg_spin_sample *b, double way) {
    double before, after, third = NAN, at = 0;
    const btg_spin_sample *l = neighbour(s, a, -1, &before), *r = neighbour(s, b, 1, &after);
    if (l != b && before < after) {
        third = l->value;
        at = -before;
    } else if (r != a) {
        third = r->value;
        at = way + after;
    }
    if (s->count > TRIES && s->count % 3 == 0) return 0.5 * way;
    double x = interpolate(0, a->value, way, b->value, at, third);
    if (!(x > 0 && x < way)) x = interpolate(0, a->value, way, b->value, 0, NAN);
    if (!isnan(a->half) && s->count <= 2) { /* the model knows more than two values */
        const btg_spin_sample *m = fabs(a->value) < fabs(b->value) ? a : b;
        for (int k = 0; k < 4; k++) {
            double turn = m->heading + (k / 2) * BTG_PI + (k % 2 ? m->half : -m->half) - a->alpha;
            turn = wrap(turn);
            if (turn > 0 && turn < way) x = turn;
        }
    }
    return fmin(fmax(x, 1e-3 * way), (1 - 1e-3) * way);
}

static bool root_in_bracket(const btg_spin_search *s, double *alpha) {
    const btg_spin_sample *best = NULL;
    double nearest = INFINITY;
    for (uint32_t i = 0; i < s->count; i++) {
        double way;
        const btg_spin_sample *a = &s->sample[i], *b = neighbour(s, a, 1, &way);
        if (!brackets(s, a->value, b->value, way)) continue;
        double off = fmax(distance(a->alpha, s->start), distance(b->alpha, s->start));
        if (off >= nearest) continue;
        best = a;
        nearest = off;
    }
    if (!best) return false;
    double way;
    const btg_spin_sample *b = neighbour(s, best, 1, &way);
    *alpha = wrap(best->alpha + step_inside(s, best, b, way));
    return true;
}

/* Of the spins that a sample's model names, the nearest to an angle. */
static double model_spin(const btg_spin_sample *m, double near) {
    double best = m->heading + m->half;
    for (int k = 1; k < 4; k++) {
        double other = m->heading + (k / 2) * BTG_PI + (k % 2 ? -m->half : m->half);
        if (distance(other, near) < distance(best, near)) best = other;
    }
    return wrap(best);
}

/* Before there is a bracket: after the model, or after the slope of the last two. */
static bool root_ahead(const btg_spin_search *s, double *alpha) {
    const btg_spin_sample *last = &s->sample[s->count - 1];
    bool across = s->solver->spin == BTG_SPIN_ACROSS;
    if (s->count > TRIES || isnan(last->value)) return false;
    if (s->count >= 2 && !isnan(last[-1].value)) {
        double way = wrap(last->alpha - last[-1].alpha), change = last->value - last[-1].value;
        double step = -last->value * way / change;
        if (fabs(way) < SCAN_STEP / 2 && fabs(step) < SCAN_STEP / 2) {
            *alpha = wrap(last->alpha + step);
            return true;
        }
    }
    if (!isnan(last->half)) {
        *alpha = model_spin(last, last->alpha);
        return !tried(s, *alpha, SAME_SPIN);
    }
    if (!across || s->count > 1 || !s->local) return false;
    *alpha = wrap(last->alpha + SLOPE_STEP);
    return true;
}

/* The scan met no bracket: a spin that some sample's model names, and that nothing is near of. */
static bool root_elsewhere(const btg_spin_search *s, double *alpha) {
    for (uint32_t i = 0; i < s->count; i++) {
        if (!(s->sample[i].half > 0)) continue;
        *alpha = model_spin(&s->sample[i], s->sample[i].alpha);
        if (!tried(s, *alpha, SLOPE_STEP / 2)) return true;
    }
    return false;
}

/* ---- the greatest score ------------------------------------------------------------------- */

/* The top of the parabola through the best and its neighbours, or the golden section where that
 * leads nowhere. */
static bool uphill(btg_spin_search *s, double within, double *alpha) {
    const btg_spin_sample *b = best_of(s);
    double left, right;
    uint32_t most = s->solver->spin == BTG_SPIN_WIDEST ? POLISHES_WIDEST : POLISHES;
    if (!b || s->polishes == most || s->count < 3) return false;
    const btg_spin_sample *l = neighbour(s, b, -1, &left), *r = neighbour(s, b, 1, &right);
    if (left + right < 2 * within) return false;
    s->polishes++;
    double dl = score(s, b->value) - score(s, l->value);
    double dr = score(s, b->value) - score(s, r->value);
    double x = NAN;
    if (left < BTG_PI / 2 && right < BTG_PI / 2)
        x = 0.5 * (right * right * dl - left * left * dr) / (right * dl + left * dr);
    bool wide = left > right;
    double longest = wide ? left : right;
    if (!(fabs(x) >= within && x > -0.9 * left && x < 0.9 * right))
        x = (wide ? -0.381966 : 0.381966) * longest;
    *alpha = wrap(b->alpha + x);
    return true;
}

/* ---- widest ------------------------------------------------------------------------------- */

/* One of the four spins at which the crest between the contacts should be the scallop: Q on one
 * side of P (`lobe`) or the other, the tool's centre to one side of it (`side`) or the other. */
typedef struct branch {
    double spin;  /* NaN: not known */
    double could; /* the width there */
    bool own;     /* known from a sample of this branch */
    bool settled; /* one of its samples is there already */
} branch;

static bool at_crest(const btg_spin_sample *m) {
    return m->crest >= CREST_GOOD && m->crest <= 1;
}

/* The branch of a sample; `heading` tells the lobes apart. */
static int branch_of(const btg_spin_sample *m, double heading) {
    int lobe = distance(m->heading, heading) > BTG_PI / 2;
    return 2 * lobe + (wrap(m->alpha - m->heading) > 0);
}

/* How far a sample is from telling where a branch's spin is: from the scallop, and from the branch.
 */
static double remote(const btg_spin_sample *m, int number, double heading) {
    int of = branch_of(m, heading);
    double far = of == number ? 0 : of / 2 == number / 2 ? 2 : 3;
    return fabs(m->off_crest) + far;
}

/* The sample of a branch nearest to `low` whose crest is too high. */
static const btg_spin_sample *beyond_crest(const btg_spin_search *s, const btg_spin_sample *low,
                                           int number, double heading) {
    const btg_spin_sample *high = NULL;
    for (uint32_t i = 0; i < s->count; i++) {
        const btg_spin_sample *m = &s->sample[i];
        if (isnan(m->half) || m->crest <= CREST_AIM || branch_of(m, heading) != number) continue;
        if (!high || distance(m->alpha, low->alpha) < distance(high->alpha, low->alpha)) high = m;
    }
    return high;
}

static branch branch_look(const btg_spin_search *s, int number, double heading) {
    const btg_spin_sample *low = NULL, *high = NULL, *model = NULL;
    double nearest = INFINITY;
    branch b = {NAN, INFINITY, false, false};
    for (uint32_t i = 0; i < s->count; i++) {
        const btg_spin_sample *m = &s->sample[i];
        if (isnan(m->half)) continue;
        double away = remote(m, number, heading);
        if (away < nearest) {
            nearest = away;
            model = m;
        }
        if (branch_of(m, heading) != number) continue;
        b.own = true;
        if (at_crest(m)) b.settled = true;
        if (m->crest <= CREST_AIM && (!low || m->crest > low->crest)) low = m;
        if (m->crest > CREST_AIM && (!high || m->crest < high->crest)) high = m;
    }
    if (!model) return b;
    double middle = model->heading + (branch_of(model, heading) / 2 != number / 2 ? BTG_PI : 0);
    b.spin = wrap(middle + (number % 2 ? model->half : -model->half));
    if (high) b.could = high->could * (1 + COULD_ERROR * high->off_crest);
    if (low) b.could = low->could;
    if (low)
        high = beyond_crest(s, low, number, heading);
    else
        high = NULL;
    if (high && low->crest > CREST_NEAR) { /* by the logarithm, which is straighter */
        double a = low->off_crest, c = high->off_crest;
        double share = fmin(fmax(a / (a - c), 0.1), 0.9);
        b.spin = wrap(low->alpha + wrap(high->alpha - low->alpha) * share);
        if (distance(low->alpha, high->alpha) < WIDEST_SPIN) b.settled = true;
    }
    if (tried(s, b.spin, b.own ? WIDEST_SPIN : UNSEEN)) b.settled = true;
    return b;
}

/* Branches not seen yet, then those that could be wider than the best, the widest first. */
static bool widest_of_branches(const btg_spin_search *s, double *alpha) {
    double heading = NAN, most = 0;
    for (uint32_t i = 0; i < s->count && isnan(heading); i++)
        if (!isnan(s->sample[i].half)) heading = s->sample[i].heading;
    if (isnan(heading)) return false;
    double best = score(s, best_of(s)->value);
    for (int k = 0; k < 4; k++) {
        branch b = branch_look(s, k, heading);
        if (isnan(b.spin) || b.settled) continue;
        if (b.own && !(b.could > best * (1 + WORTH))) continue;
        double worth = b.own ? fmin(b.could, 1e6) : 1e7;
        if (worth <= most) continue;
        most = worth;
        *alpha = b.spin;
    }
    return most > 0;
}

/* The middle of the widest piece without a sample, when it is wide enough to hide a strip. */
static bool widest_gap(const btg_spin_search *s, double *alpha) {
    double widest = WIDEST_APART;
    bool found = false;
    for (uint32_t i = 0; i < s->count; i++) {
        double way;
        neighbour(s, &s->sample[i], 1, &way);
        if (way <= widest) continue;
        widest = way;
        *alpha = wrap(s->sample[i].alpha + 0.5 * way);
        found = true;
    }
    return found;
}

/* Near a neighbour's spin: its branch alone, or to either side of the best. */
static bool widest_nearby(btg_spin_search *s, double *alpha) {
    const btg_spin_sample *b = best_of(s);
    if (s->count > 5 || at_crest(b)) return false;
    if (!isnan(b->half)) {
        branch of = branch_look(s, branch_of(b, b->heading), b->heading);
        *alpha = of.spin;
        if (!of.settled && distance(of.spin, b->alpha) < SCAN_STEP / 2) return true;
    }
    double left, right;
    neighbour(s, b, -1, &left);
    neighbour(s, b, 1, &right);
    if (left < SCAN_STEP && right < SCAN_STEP) return uphill(s, WIDEST_SPIN, alpha);
    *alpha = wrap(b->alpha + (right < left ? -SLOPE_STEP : SLOPE_STEP));
    return true;
}

static bool next_widest(btg_spin_search *s, double *alpha) {
    if (s->local && s->any) return widest_nearby(s, alpha);
    if (s->polishes == 0) {
        if (widest_of_branches(s, alpha) || widest_gap(s, alpha)) return true;
    }
    const btg_spin_sample *b = best_of(s);
    if (b && at_crest(b)) return false; /* beyond it falls in two */
    return uphill(s, WIDEST_SPIN, alpha);
}

/* ---- guesses ------------------------------------------------------------------------------ */

/* The sample with a second contact nearest to a spin; NULL: none. */
static const btg_spin_sample *nearest_q(const btg_spin_search *s, double alpha) {
    const btg_spin_sample *best = NULL;
    for (uint32_t i = 0; i < s->count; i++) {
        const btg_spin_sample *m = &s->sample[i];
        if (!m->has_q) continue;
        if (!best || distance(m->alpha, alpha) < distance(best->alpha, alpha)) best = m;
    }
    return best;
}

/* Where Q should be at a spin: in the direction it has from P at the spin nearest to that, as far
 * as the model says. False: not known. */
static bool foresee(const btg_spin_search *s, double alpha, btg_place *q) {
    const btg_spin_sample *m = nearest_q(s, alpha);
    btg_place p = s->unspun.p.place;
    if (!m) {
        *q = s->q;
        return s->has_q;
    }
    *q = m->q;
    if (m->q.item != p.item || p.item >= s->part->patch_count)
        return distance(m->alpha, alpha) <= GUESS_WITHIN;
    double here = cos(m->alpha - m->heading), there = cos(alpha - m->heading);
    double way = fabs(there) / fmax(fabs(here), COS_MIN);
    way = fmin(fmax(way, FORESEEN_LEAST), FORESEEN_MOST);
    if ((here < 0) != (there < 0)) way = -way;
    q->u = fmin(fmax(p.u + way * (m->q.u - p.u), 0), 1);
    q->v = fmin(fmax(p.v + way * (m->q.v - p.v), 0), 1);
    return true;
}

/* The sample at the very spin asked for. */
static btg_spin_sample *asked_before(btg_spin_search *s) {
    for (uint32_t i = 0; i < s->count; i++)
        if (s->sample[i].alpha == s->asked) return &s->sample[i];
    return NULL;
}

/* The best is a guess: to be asked in full. */
static bool unproven(const btg_spin_search *s, double *alpha) {
    const btg_spin_sample *best = best_of(s);
    if (!best || !best->guessed) return false;
    *alpha = best->alpha;
    return true;
}

/* ---- the search --------------------------------------------------------------------------- */

void btg_spin_begin(btg_spin_search *search, const btg_part *part, const btg_tool *tool,
                    const btg_solver_def *solver, const btg_tilt_query *unspun, double start) {
    *search = (btg_spin_search){.part = part,
                                .tool = tool,
                                .solver = solver,
                                .unspun = *unspun,
                                .strip = strip_query(part, tool, solver),
                                .local = isfinite(start),
                                .start = isfinite(start) ? remainder(start, 2 * BTG_PI) : 0,
                                .best_score = -INFINITY,
                                .proven_score = -INFINITY};
    search->proven.status = BTG_ERROR_GOUGE;
}

static bool choose(btg_spin_search *s, double *alpha) {
    if (s->count == 0) {
        *alpha = s->start;
        return true;
    }
    if (s->count == BTG_SPIN_TILTS_MAX) return false;
    /* the last tilt is kept for the position without spin, should it be needed */
    if (!s->any && s->count == BTG_SPIN_TILTS_MAX - 1) {
        *alpha = 0;
        return !tried(s, 0, 0);
    }
    if (s->solver->spin == BTG_SPIN_WIDEST)
        return next_widest(s, alpha) || (!s->any && scan(s, alpha));
    if (s->any && fabs(s->best_score) <= STOP * limit(s)) return false;
    return root_in_bracket(s, alpha) || root_ahead(s, alpha) || scan(s, alpha) ||
           root_elsewhere(s, alpha) || uphill(s, 100 * SAME_SPIN, alpha);
}

bool btg_spin_next(btg_spin_search *search, btg_tilt_query *query) {
    double alpha = search->asked;
    bool again = search->redo;
    if (!again && !choose(search, &alpha)) {
        if (!unproven(search, &alpha)) return false;
        again = true;
    }
    search->redo = false;
    search->asked = alpha;
    *query = search->unspun;
    btg_position_spin(alpha, query);
    query->has_start = foresee(search, alpha, &query->start);
    search->may_guess = query->has_start && !again && search->misled < MISLED_MOST;
    return true;
}

/* Scores anew: a sample may have been put right. */
static void find_best(btg_spin_search *s) {
    const btg_spin_sample *best = best_of(s);
    s->any = best != NULL;
    s->best_score = best ? score(s, best->value) : -INFINITY;
}

/* Too many were wrong: the others are not to be trusted with a root between them. */
static void drop_guesses(btg_spin_search *s) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s->count; i++)
        if (!s->sample[i].guessed) s->sample[kept++] = s->sample[i];
    s->count = kept;
}

/* What a guess was judged by is what is proven now. */
static bool same_contact(const btg_spin_sample *m, const btg_tilt_result *result) {
    btg_place a = m->q, b = result->contact.place;
    bool two = m->has_q && result->status == BTG_OK;
    return two && a.item == b.item && fabs(a.u - b.u) + fabs(a.v - b.v) <= SAME_PLACE;
}

void btg_spin_take(btg_spin_search *s, const btg_tilt_query *query, const btg_tilt_result *result,
                   bool guessed) {
    if (guessed && result->status != BTG_OK) {
        s->redo = true;
        return;
    }
    btg_spin_sample *before = asked_before(s), *sample = &s->fresh;
    bool misled = before && fabs(before->tilt - result->tilt_rad) > SAME_SPIN;
    bool same = before && !misled && same_contact(before, result);
    if (same)
        *sample = *before;
    else
        judge(s, query, result, sample);
    sample->has_q = result->status == BTG_OK;
    sample->q = result->contact.place;
    sample->guessed = guessed;
    sample->tilt = result->tilt_rad;
    if (before)
        *before = *sample;
    else
        s->sample[s->count++] = *sample;
    if (misled && ++s->misled == MISLED_MOST && s->solver->spin == BTG_SPIN_GAP) drop_guesses(s);
    find_best(s);
    if (guessed) return;
    double here = score(s, sample->value);
    bool better = here > s->proven_score;
    bool unspun =
        s->proven_score == -INFINITY && isnan(here) && s->asked == 0 && result->status >= 0;
    if (!better && !unspun) return;
    s->proven_alpha = s->asked;
    s->proven = *result;
    if (better) s->proven_score = here;
}

btg_status btg_spin_finish(const btg_spin_search *s, double foot_x_mm, double foot_y_mm,
                           const btg_drop_query *drop_query, const btg_drop_result *drop,
                           btg_position *position) {
    btg_solver_def spun = *s->solver;
    spun.spin = s->proven_alpha != 0 ? BTG_SPIN_FIXED : BTG_SPIN_NONE;
    spun.spin_rad = s->proven_alpha;
    btg_tilt_query frame = s->unspun;
    btg_position_spin(s->proven_alpha, &frame);
    bool tilted = s->proven.status >= 0;
    btg_status status =
        btg_position_assemble(s->tool, &spun, foot_x_mm, foot_y_mm, drop_query, drop,
                              tilted ? &frame : NULL, tilted ? &s->proven : NULL, position);
    if (status < 0) return status;
    bool widest = s->solver->spin == BTG_SPIN_WIDEST;
    bool any = s->proven_score > -INFINITY;
    position->spin_met = any && (widest || -s->proven_score <= limit(s));
    return status;
}

/* ---- the strip of a position ------------------------------------------------------------- */

btg_status btg_position_strip(const btg_part *part, const btg_tool *tool,
                              const btg_solver_def *solver, const btg_position *position,
                              double *width_mm) {
    if (!part || !tool || !solver || !position || !width_mm || btg_check_solver(solver, NULL))
        return BTG_ERROR_ARGUMENT;
    btg_strip_query query = strip_query(part, tool, solver);
    const btg_contact *p = &position->p, *q = &position->q;
    double width = 0;
    if (vec_finite(p->point)) {
        if (!vec_finite(position->axis) || !btg_check_place(p->place, &part->info))
            return BTG_ERROR_ARGUMENT;
        if (!vec_finite(q->point) || position->status == BTG_OSCULATING) q = NULL;
        if (q && !btg_check_place(q->place, &part->info)) return BTG_ERROR_ARGUMENT;
        query.pose.axis = position->axis;
        query.pose.centre =
            vec_mad(position->tip, position->axis, tool->element[0].corner_radius_mm);
        width = btg_strip_measure(&query, p, q).width_mm;
    }
    *width_mm = width;
    return BTG_OK;
}
