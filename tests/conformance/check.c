#include "conformance.h"
#include "core/part.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Clearance is dear: that many queries of a fixture at most. */
#define CLEARANCES_MAX 40
/* TIGHT tilts at least that much further: what it then cuts shows above rounding. */
#define TIGHT_MIN (0.02 * BTG_PI / 180)
/* A batch of many is left out where it would take longer (the reference). */
#define LARGE_SECONDS 10
/* Failures of one case and back end that are printed. */
#define PRINTED_MAX 5

static void print_vec(const char *name, btg_vec3 a) {
    printf("      %s %a %a %a\n", name, a.x, a.y, a.z);
}

static void print_inputs(const check_context *c, size_t i) {
    const fixture *f = c->f;
    printf("      tool %a %a %s, %u elements\n", f->tool.def.major_radius_mm,
           f->tool.def.minor_radius_mm, f->tool.def.profile ? "bullnose" : "toroidal",
           f->tool.element_count);
    if (f->op == BTG_OP_DROP) {
        print_vec("origin", f->drops[i].origin);
        print_vec("axis", f->drops[i].axis);
    } else {
        const btg_tilt_query *q = &f->tilts[i];
        print_vec("u", q->u);
        print_vec("v", q->v);
        print_vec("w", q->w);
        print_vec("o1", q->o1);
        print_vec("p", q->p.point);
        print_vec("n", q->p.normal);
        printf("      item %u at %a %a, max tilt %a\n", q->p.place.item, q->p.place.u, q->p.place.v,
               q->max_tilt_rad);
    }
    model_print(&f->model);
}

static void fail(const check_context *c, size_t i, const char *what, double got, double expected,
                 double error, double limit) {
    if (c->tally->failed++ >= PRINTED_MAX) return;
    printf("  FAIL %s on %s: %s, query %zu (--seed %llu --case %s --round %d)\n", c->test->name,
           c->backend, what, i, (unsigned long long)c->seed, c->test->name, c->round);
    printf("      got %.17g (%a), want %.17g (%a), error %g, limit %g\n", got, got, expected,
           expected, error, limit);
    if (c->tally->failed == 1) print_inputs(c, i);
}

static void note(const check_context *c, double error, limits limit) {
    double *worst = error > 0 ? &c->tally->worst_deep : &c->tally->worst_shallow;
    double part = fabs(error) / (error > 0 ? limit.deep : limit.shallow);
    if (part > *worst) *worst = part;
}

/* ---- values ------------------------------------------------------------------------------- */

/* Clearance at a contact by one unit of the value. */
static double lever_of(const fixture *f, size_t i, const answer *a) {
    if (f->op == BTG_OP_DROP) return fabs(vec_dot(a->contact.normal, f->drops[i].axis));
    const btg_tilt_query *q = &f->tilts[i];
    btg_vec3 way = vec_cross(q->u, vec_sub(a->contact.point, q->o1));
    return fabs(vec_dot(way, a->contact.normal));
}

static tolerance_class class_of(const check_context *c, double lever, btg_status status) {
    if (c->f->op == BTG_OP_DROP || c->test->tolerance != TOLERANCE_F64) return c->test->tolerance;
    bool near = status == BTG_OSCULATING || lever < 0.02 * fixture_size(c->f);
    return near ? TOLERANCE_OSCULATING : TOLERANCE_F64;
}

static bool touches(btg_status s) {
    return s == BTG_OK || s == BTG_OSCULATING;
}

static void compare(const check_context *c, size_t i, const char *what, const answer *got,
                    btg_status status, double value, double lever) {
    bool cut_short = got->status == BTG_BUDGET && status >= 0;
    if (cut_short) c->tally->cut_short++;
    if (cut_short && !touches(status)) return;
    bool same = touches(status) ? touches(got->status) || cut_short : got->status == status;
    limits limit = tolerance_limits(class_of(c, lever, status), c->f, lever);
    if (c->f->op == BTG_OP_TILT && !same) {
        /* a second contact just before or just beyond the largest tilt */
        double end = c->f->tilts[i].max_tilt_rad;
        bool at_end = (touches(status) || status == BTG_SINGLE_CONTACT) &&
                      (touches(got->status) || got->status == BTG_SINGLE_CONTACT);
        if (at_end) {
            if (status == BTG_SINGLE_CONTACT) value = end;
            same = true;
        }
    }
    if (!same) {
        fail(c, i, what, got->status, status, NAN, NAN);
        return;
    }
    if (!touches(status) && !touches(got->status)) return;
    double error = c->f->op == BTG_OP_DROP ? value - got->value : got->value - value;
    if (cut_short && error < 0) return; /* safe, and says so */
    note(c, error, limit);
    if (error > limit.deep || -error > limit.shallow || isnan(error))
        fail(c, i, error > 0 ? "too deep" : "too shallow", got->value, value, error,
             error > 0 ? limit.deep : limit.shallow);
}

/* ---- the placed tool ---------------------------------------------------------------------- */

/* Parameters may be flat: a contact lies as far off as the clearance allows. */
static double tangency_limit(const fixture *f, double clearance) {
    return sqrt(8 * clearance / fixture_size(f)) + 1e-6;
}

/* From the contact to the border of its patch or triangle, by its tangent plane. */
static double border_distance(const btg_part *part, btg_place at, const btg_surface_point *s) {
    double area = vec_norm(vec_cross(s->su, s->sv));
    double wu = area / vec_norm(s->sv), wv = area / vec_norm(s->su);
    double least = fmin(at.u * wu, at.v * wv);
    if (at.item < part->patch_count) return fmin(least, fmin((1 - at.u) * wu, (1 - at.v) * wv));
    return fmin(least, (1 - at.u - at.v) * area / vec_norm(vec_sub(s->sv, s->su)));
}

static void check_normal(const check_context *c, size_t i, const answer *a, btg_placement at,
                         const btg_surface_point *s) {
    const btg_tool_def *tool = &c->f->tool.def;
    btg_contact k = a->contact;
    double limit = tangency_limit(c->f, tolerance_clearance(c->test->tolerance, c->f));
    double length = vec_norm(k.normal);
    if (!(fabs(length - 1) < 1e-9)) fail(c, i, "normal is not unit", length, 1, length - 1, 1e-9);
    if (a->element != 0 || tool->minor_radius_mm == 0) return;
    /* the normal passes through the major circle, or through the flat's disc */
    btg_vec3 arm = vec_sub(vec_mad(k.point, k.normal, tool->minor_radius_mm), at.centre);
    double z = vec_dot(arm, at.axis), r = vec_norm(vec_mad(arm, at.axis, -z));
    double across = r - tool->major_radius_mm;
    if (tool->profile == BTG_PROFILE_BULLNOSE && across < 0) across = 0;
    double off = hypot(across, z) / tool->minor_radius_mm;
    if (!(off < limit)) fail(c, i, "normal misses the major circle", off, 0, off, limit);
    btg_vec3 n = vec_unit(vec_cross(s->su, s->sv));
    double skew = vec_norm(vec_cross(n, k.normal));
    /* On an edge any normal may be; and where going there gains less than the clearance. */
    double gain = skew * border_distance(c->f->part, k.place, s);
    if (gain < tolerance_clearance(c->test->tolerance, c->f)) return;
    if (!(skew < limit)) fail(c, i, "not tangent to the part", skew, 0, skew, limit);
}

static void check_touch(const check_context *c, size_t i, const answer *a, btg_placement at) {
    double rounding = 1e-12 * (1 + fixture_scale(c->f));
    btg_surface_point s;
    if (btg_part_evaluate(c->f->part, a->contact.place, &s) != BTG_OK) {
        fail(c, i, "contact is no place of the part", a->contact.place.u, 0, NAN, NAN);
        return;
    }
    double off = vec_norm(vec_sub(s.s, a->contact.point));
    if (!(off <= rounding)) fail(c, i, "contact is not on the part", off, 0, off, rounding);
    double limit = tolerance_clearance(c->test->tolerance, c->f);
    double gap = tool_clearance(&c->f->tool, at, s.s);
    if (!(fabs(gap) <= limit)) fail(c, i, "contact does not touch", gap, 0, gap, limit);
    check_normal(c, i, a, at, &s);
}

static void check_tight(const check_context *c, size_t i, const answer *a) {
    double lever = lever_of(c->f, i, a);
    limits limit = tolerance_limits(class_of(c, lever, a->status), c->f, lever);
    double further = fmax(3 * limit.shallow, TIGHT_MIN);
    btg_placement at = fixture_place(c->f, i, a->value + further);
    double clearance = cloud_clearance(c->samples, c->f, at, &a->contact.point);
    double rounding = 1e-13 * (1 + fixture_scale(c->f));
    if (!(clearance < -rounding))
        fail(c, i, "turns further and is still clear", clearance, -rounding, clearance, -rounding);
}

static void check_placed(const check_context *c, size_t i, const answer *a) {
    unsigned checks = c->test->checks;
    if (!touches(a->status) && a->status != BTG_SINGLE_CONTACT && a->status != BTG_BUDGET) return;
    btg_placement at = fixture_place(c->f, i, a->value);
    if ((checks & CHECK_TOUCH) && touches(a->status)) check_touch(c, i, a, at);
    size_t every = 1 + c->f->count / CLEARANCES_MAX;
    if (!c->samples || i % every != 0) return;
    if (checks & CHECK_CLEAR) {
        double limit = tolerance_clearance(c->test->tolerance, c->f);
        const btg_vec3 *hint = touches(a->status) ? &a->contact.point : NULL;
        double clearance = cloud_clearance(c->samples, c->f, at, hint);
        if (!(clearance >= -limit)) fail(c, i, "gouges", clearance, 0, clearance, -limit);
    }
    /* a disc without thickness has no inside to cut with */
    bool solid = c->f->tool.def.minor_radius_mm > 0;
    if ((checks & CHECK_TIGHT) && solid && c->f->op == BTG_OP_TILT && touches(a->status))
        check_tight(c, i, a);
}

static bool is_number(const answer *a) {
    if (a->status == BTG_NO_CONTACT || a->status < 0) return true;
    if (!touches(a->status)) return isfinite(a->value);
    return isfinite(a->value) && vec_finite(a->contact.point) && vec_finite(a->contact.normal);
}

static void print_answer(const char *name, const answer *a) {
    printf("      %s: %s %.17g, element %u, item %u at %.17g %.17g, point %.17g %.17g %.17g\n",
           name, btg_status_name(a->status), a->value, a->element, a->contact.place.item,
           a->contact.place.u, a->contact.place.v, a->contact.point.x, a->contact.point.y,
           a->contact.point.z);
}

static void check_answer(const check_context *c, size_t i, const answer *a) {
    const want *w = &c->f->wants[i];
    if (!is_number(a)) {
        fail(c, i, "not a number", a->value, NAN, NAN, NAN);
        return;
    }
    bool below = w->at_most && touches(a->status) && a->value < w->value;
    if ((c->test->checks & CHECK_VALUE) && w->known && !below)
        compare(c, i, "status", a, w->status, w->value, w->lever);
    if ((c->test->checks & CHECK_REFERENCE) && c->reference) {
        const answer *r = &c->reference[i];
        double lever = touches(r->status) ? lever_of(c->f, i, r) : 1;
        compare(c, i, "status", a, r->status, r->value, lever);
    }
    check_placed(c, i, a);
}

void check_answers(const check_context *c, const answer *answers) {
    for (size_t i = 0; i < c->f->count; i++) {
        size_t before = c->tally->failed;
        check_answer(c, i, &answers[i]);
        if (c->tally->failed == before || before >= PRINTED_MAX) continue;
        print_answer("answer", &answers[i]);
        if (c->f->op == BTG_OP_TILT) {
            btg_vec3 pq = vec_sub(answers[i].contact.point, c->f->tilts[i].p.point);
            printf("      Q is %g mm from P\n", vec_norm(pq));
        }
        if (c->reference) print_answer("reference", &c->reference[i]);
    }
}

/* ---- moved -------------------------------------------------------------------------------- */

static void move_queries(fixture *f, const fixture *from, const motion *t) {
    for (size_t i = 0; i < from->count; i++) {
        if (from->op == BTG_OP_DROP) {
            btg_drop_query q = from->drops[i];
            q.origin = motion_point(t, q.origin);
            q.axis = motion_vector(t, q.axis);
            fixture_drop(f, q, unknown);
            continue;
        }
        btg_tilt_query *q = &f->tilts[i];
        q->o1 = motion_point(t, q->o1);
        q->p.point = motion_point(t, q->p.point);
        q->p.normal = motion_vector(t, q->p.normal);
        q->v = motion_vector(t, q->v);
        q->w = motion_vector(t, q->w);
        q->u = vec_cross(q->v, q->w); /* an axis of rotation: a mirror turns it round */
    }
}

static void move_tool(fixture *f, const btg_tool_def *def, double k) {
    fixture_tool(f, k * def->major_radius_mm, k * def->minor_radius_mm, def->profile);
    if (def->shank.radius_mm > 0)
        fixture_cylinder(f, k * def->shank.radius_mm, k * def->shank.from_mm, k * def->shank.to_mm);
    for (uint32_t i = 0; i < def->holder_count; i++)
        fixture_cylinder(f, k * def->holder[i].radius_mm, k * def->holder[i].from_mm,
                         k * def->holder[i].to_mm);
}

static motion random_motion(rng *r) {
    motion t = {.angle = rng_range(r, -BTG_PI, BTG_PI), .scale = exp(rng_range(r, -0.7, 0.7))};
    t.mirror = rng_pick(r, 2);
    t.shift = vec(rng_range(r, -100, 100), rng_range(r, -100, 100), rng_range(r, -50, 50));
    return t;
}

void check_moved(const check_context *c, const answer *answers, rng *r) {
    const fixture *f = c->f;
    motion t = random_motion(r);
    fixture g;
    fixture_init(&g, f->op);
    g.solver = f->solver;
    g.solver.tolerance_mm = fmin(1, f->solver.tolerance_mm * t.scale);
    move_tool(&g, &f->tool.def, t.scale);
    g.model = model_copy(&f->model);
    model_move(&g.model, &t);
    fixture_part(&g);
    if (f->op == BTG_OP_TILT) {
        g.tilts = malloc((f->count + 1) * sizeof *g.tilts);
        if (!g.tilts) abort();
        memcpy(g.tilts, f->tilts, f->count * sizeof *g.tilts);
        g.count = f->count;
    }
    move_queries(&g, f, &t);
    answer *moved = calloc(f->count + 1, sizeof *moved);
    if (!fixture_run(&g, c->backend, 0, moved)) fail(c, 0, "refused when moved", 0, 0, NAN, NAN);
    for (size_t i = 0; i < f->count; i++) {
        answer back = moved[i];
        if (f->op == BTG_OP_DROP) back.value /= t.scale;
        if (answers[i].status == BTG_BUDGET) continue; /* safe, but with no value to compare */
        double lever = touches(answers[i].status) ? lever_of(f, i, &answers[i]) : 1;
        compare(c, i, "moved", &back, answers[i].status, answers[i].value, lever / 2);
    }
    free(moved);
    fixture_free(&g);
}

/* ---- batches ------------------------------------------------------------------------------ */

static bool same_bits(const answer *a, const answer *b) {
    return a->status == b->status && a->element == b->element &&
           memcmp(&a->value, &b->value, sizeof a->value) == 0 &&
           memcmp(&a->contact.point, &b->contact.point, sizeof a->contact.point) == 0 &&
           memcmp(&a->contact.normal, &b->contact.normal, sizeof a->contact.normal) == 0 &&
           a->contact.place.item == b->contact.place.item &&
           a->contact.place.u == b->contact.place.u && a->contact.place.v == b->contact.place.v;
}

static void compare_bits(const check_context *c, const fixture *part_of, size_t first,
                         uint32_t threads, bool reversed, const answer *answers) {
    answer *again = calloc(part_of->count + 1, sizeof *again);
    if (!fixture_run(part_of, c->backend, threads, again))
        fail(c, first, "refused a batch", 0, 0, NAN, NAN);
    for (size_t i = 0; i < part_of->count; i++) {
        size_t k = first + (reversed ? part_of->count - 1 - i : i);
        if (!same_bits(&again[i], &answers[k]))
            fail(c, k, "differs in a batch", again[i].value, answers[k].value, NAN, 0);
    }
    free(again);
}

static void reverse(fixture *f) {
    for (size_t i = 0, j = f->count; i + 1 < j; i++) {
        j--;
        if (f->op == BTG_OP_DROP) {
            btg_drop_query q = f->drops[i];
            f->drops[i] = f->drops[j];
            f->drops[j] = q;
        } else {
            btg_tilt_query q = f->tilts[i];
            f->tilts[i] = f->tilts[j];
            f->tilts[j] = q;
        }
    }
}

/* Many queries, where the back end is fast enough: those known, over and over. */
static void check_large(const check_context *c, const answer *answers) {
    fixture f = {.op = c->f->op, .tool = c->f->tool, .solver = c->f->solver, .part = c->f->part};
    size_t n = c->f->count;
    clock_t start = clock();
    compare_bits(c, c->f, 0, 1, false, answers);
    double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    if (seconds * (double)c->f->large / (double)n > LARGE_SECONDS) return;
    f.count = c->f->large;
    f.drops = malloc(f.count * sizeof *f.drops);
    f.tilts = malloc(f.count * sizeof *f.tilts);
    answer *again = calloc(f.count, sizeof *again);
    if (!f.drops || !f.tilts || !again) abort();
    for (size_t i = 0; i < f.count; i++) {
        if (f.op == BTG_OP_DROP)
            f.drops[i] = c->f->drops[i % n];
        else
            f.tilts[i] = c->f->tilts[i % n];
    }
    if (!fixture_run(&f, c->backend, 0, again)) fail(c, 0, "refused many", 0, 0, NAN, NAN);
    for (size_t i = 0; i < f.count; i++)
        if (!same_bits(&again[i], &answers[i % n]))
            fail(c, i % n, "differs among many", again[i].value, answers[i % n].value, NAN, 0);
    free(f.drops);
    free(f.tilts);
    free(again);
}

void check_batch(const check_context *c, const answer *answers) {
    if (c->f->large > 0) check_large(c, answers);
    fixture f = *c->f;
    for (uint32_t threads = 1; threads <= 4; threads++)
        compare_bits(c, &f, 0, threads, false, answers);
    f.count = 0;
    compare_bits(c, &f, 0, 0, false, answers);
    for (size_t i = 0; i < 3 && i < c->f->count; i++) { /* alone, from the middle */
        f = *c->f;
        size_t at = (i + 1) * f.count / 4;
        f.drops += at;
        f.tilts += at;
        f.count = 1;
        compare_bits(c, &f, at, 0, false, answers);
    }
    f = *c->f;
    reverse(&f);
    compare_bits(c, &f, 0, 3, true, answers);
    reverse(&f);
}
