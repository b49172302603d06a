/* The way uphill on one item: steps to the largest value, halved where they do not lead up. */
#include "core/step.h"

#define STEPS_MAX  24
#define HALVES_MAX 10
/* Steps shorter than this part of the part's size move the value by less than its rounding. */
#define STEP_MIN 1e-13
/* From so near the next step is one of those. */
#define STEP_NEAR 1e-9
/* So near, the lengths of steps tell the next one's; and what may be left of the way. */
#define STEP_CLOSE 1e-6
#define STEP_REST  1e-11
/* A point's distance to the tool, part of the part's size. */
#define POINT_ROUNDING 1e-15

/* The value at a place; false when the tool never meets it. */
static bool look(const btg_search *search, btg_place place, btg_surface_point *s,
                 btg_ray_hit *hit) {
    btg_part_point(search->part, place, s);
    return btg_ray_cast(&search->query, s->s, hit);
}

/* Where a way uphill has come to. */
typedef struct climber {
    btg_place at;
    btg_surface_point *s, *other; /* there; room for the next */
    btg_ray_hit hit;
    double last;  /* length of the step before */
    bool newton;  /* that was a whole one of Newton's */
    bool settled; /* the last step was a true one, and as short as counts */
} climber;

static BTG_APART void plan_step(btg_search *search, const climber *c, btg_step *step) {
    btg_placement tool;
    btg_ray_touch(&search->query, c->s->s, &c->hit, &tool, &search->near);
    btg_step_make(search, c->at, c->s, &tool, &search->near, step);
}

/* Newton's steps square the distance: by the lengths of two of them next to nothing is left for the
 * third. */
static bool arrived(const climber *c, double length, double scale) {
    double ratio = length / c->last;
    return c->newton && length < STEP_CLOSE * scale && length * ratio * ratio < STEP_REST * scale;
}

/* A value is known no better than its point: TILT, close to P, where the distance hardly changes
 * with the value, much worse. */
static double value_rounding(const btg_search *search, const btg_step *way) {
    double own = search->query.op == BTG_OP_DROP ? 4e-15 * search->part->scale : 1e-14;
    double of_point = POINT_ROUNDING * search->part->scale;
    return way->by_value > 0 ? max2(own, of_point / way->by_value) : own;
}

/* One step; false: none leads up from here. */
static bool step_up(btg_search *search, climber *c) {
    double shortest = STEP_MIN * search->part->scale, near = STEP_NEAR * search->part->scale;
    btg_step way;
    plan_step(search, c, &way);
    double rounding = value_rounding(search, &way);
    double part = 1;
    for (int half = 0; half < HALVES_MAX; half++, part *= 0.5) {
        btg_place next = btg_step_move(search, c->at, &way, part);
        btg_ray_hit hit;
        double length = fabs(next.u - c->at.u) * way.speed_u + fabs(next.v - c->at.v) * way.speed_v;
        if (length < shortest) {
            c->settled = way.newton;
            return false;
        }
        if (!look(search, next, c->other, &hit)) continue;
        /* The value is flat on top: its last digits say nothing when a step still halves the
         * distance to the contact. */
        bool closing = way.newton && half == 0 && length < 0.5 * c->last &&
                       hit.value > c->hit.value - rounding;
        if (!closing && fabs(hit.value - c->hit.value) <= rounding) {
            c->settled = way.newton && (length < near || c->newton);
            return false;
        }
        if (!closing && hit.value < c->hit.value) continue;
        c->settled = closing && arrived(c, length, search->part->scale);
        c->newton = closing;
        c->last = length;
        c->at = next;
        c->hit = hit;
        btg_surface_point *swap = c->s;
        c->s = c->other;
        c->other = swap;
        return !c->settled;
    }
    return false;
}

/* The climb stands apart, so that the rim's is not below its frame. */
static BTG_APART bool climb(btg_search *search, climber *c) {
    if (!look(search, c->at, c->s, &c->hit)) return false;
    for (int step = 0; step < STEPS_MAX && step_up(search, c); step++)
        ;
    return true;
}

void btg_search_polish(btg_search *search, btg_place from) {
    climber c = {.at = from, .s = &search->here, .other = &search->there, .last = INFINITY};
    if (!climb(search, &c)) return;
    if (btg_search_offer(search, c.hit.value, c.at, c.s->s, c.hit.element, false))
        search->settled = c.settled;
    if (search->query.tool->element[c.hit.element].corner_radius_mm == 0)
        btg_search_polish_rim(search, c.at, c.hit.element);
}
