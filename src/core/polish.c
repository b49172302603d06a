/* The way uphill on one item: steps to the largest value, halved where they do not lead up. */
#include "core/step.h"

#define STEPS_MAX  24
#define HALVES_MAX 10
/* Steps shorter than this part of the part's size move the value by less than its rounding. */
#define STEP_MIN 1e-13
/* From so near the next step is one of those. */
#define STEP_NEAR 1e-9

/* The value at a place; false when the tool never meets it. */
static bool look(const btg_search *search, btg_place place, btg_surface_point *s,
                 btg_ray_hit *hit) {
    btg_part_point(search->part, place, s);
    return btg_ray_cast(&search->query, s->s, hit);
}

void btg_search_polish(btg_search *search, btg_place from) {
    btg_place at = from;
    btg_surface_point *s = &search->here, *t = &search->there;
    btg_ray_hit hit;
    if (!look(search, at, s, &hit)) return;
    double shortest = STEP_MIN * search->part->scale, near = STEP_NEAR * search->part->scale;
    double rounding = search->query.op == BTG_OP_DROP ? 4e-15 * search->part->scale : 1e-14;
    double last = INFINITY; /* length of the step before */
    bool settled = false;
    for (int step = 0; step < STEPS_MAX; step++) {
        btg_placement tool;
        btg_ray_distance d = btg_ray_touch(&search->query, s->s, &hit, &tool);
        btg_step way;
        btg_step_make(search, at, s, &tool, &d, &way);
        bool newton = way.newton, better = false;
        double part = 1;
        for (int half = 0; half < HALVES_MAX && !better; half++, part *= 0.5) {
            btg_place next = btg_step_move(search, at, &way, part);
            btg_ray_hit other;
            double length = fabs(next.u - at.u) * way.speed_u + fabs(next.v - at.v) * way.speed_v;
            if (length < shortest) {
                settled = newton;
                break;
            }
            if (!look(search, next, t, &other)) continue;
            /* The value is flat on top: its last digits say nothing when a step still halves the
             * distance to the contact. */
            bool closing =
                newton && half == 0 && length < 0.5 * last && other.value > hit.value - rounding;
            if (!closing && fabs(other.value - hit.value) <= rounding) {
                settled = newton && length < near;
                break;
            }
            if (!closing && other.value < hit.value) continue;
            last = length;
            at = next;
            btg_surface_point *swap = s;
            s = t;
            t = swap;
            hit = other;
            better = true;
        }
        if (!better) break;
    }
    if (btg_search_offer(search, hit.value, at, s->s, hit.element, false))
        search->settled = settled;
    if (search->query.tool->element[hit.element].corner_radius_mm == 0)
        btg_search_polish_rim(search, at, hit.element);
}
