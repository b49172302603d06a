/* TILT by turning the part and dropping the tool on it again: M. Singh, S. Bedi, S. Mann, "A GPU
 * Method and Error Analysis of Multi-Point Positioning of a Toroidal Tool for 5-Axis Machining",
 * 2024, section 5 and appendix. The part turns about the pseudo-insert, so P stays on it; the tool
 * comes to rest as high as before until the second contact lifts it. The angle at which it starts
 * to is bisected. (Turning the tool the other way is the same, and leaves the part alone.)
 *
 * What this method lacks by nature: a part that is met at some angle and clear again at a larger
 * one is seen only where a bisected angle happens to meet it; and where Q comes near P the rest
 * height grows so slowly that its own error decides the angle. */
#include "methods/internal.h"
#include "core/spin.h"

/* Halvings of 45 degrees: to 7e-7 degrees. */
#define HALVINGS 26
/* Contacts that near to each other are one, mm. */
#define MERGED 0.01

typedef struct bracket {
    double clear, met;   /* rad */
    double angle;        /* that is tried */
    btg_contact contact; /* of the drop at `met` */
    uint32_t element;
    bool inside; /* the part, before it turns at all */
    bool ended;  /* without a second contact */
    uint32_t nodes;
} bracket;

/* Memory of one call. */
typedef struct work {
    bracket *brackets;
    btg_drop_query *queries;
    btg_drop_result *results;
} work;

static void leave(const btg_turn *t, work *r) {
    btg_release(&t->setup->allocator, r->brackets);
    btg_release(&t->setup->allocator, r->queries);
    btg_release(&t->setup->allocator, r->results);
}

static bool make_room(const btg_turn *t, size_t count, work *r) {
    const btg_allocator *a = &t->setup->allocator;
    r->brackets = btg_allocate(a, count, sizeof *r->brackets);
    r->queries = btg_allocate(a, count, sizeof *r->queries);
    r->results = btg_allocate(a, count, sizeof *r->results);
    return r->brackets && r->queries && r->results;
}

/* One drop for each query, turned by its angle; heights are over where the tool rested. */
static btg_status drop_turned(const btg_turn *t, const btg_tilt_query *queries, size_t count,
                              work *r) {
    for (size_t i = 0; i < count; i++) {
        btg_drop_query q = {0};
        btg_position_pose(&t->setup->tool, &queries[i], r->brackets[i].angle, &q.origin, &q.axis);
        r->queries[i] = q;
    }
    btg_method_context_of(t->setup)->counts->turned_drops += count;
    btg_status status = t->drop(t->user, r->queries, count, r->results);
    for (size_t i = 0; i < count && status >= 0; i++) {
        r->brackets[i].nodes += r->results[i].nodes;
        if (r->results[i].status < 0) return r->results[i].status;
    }
    return status;
}

static bool rests_higher(const btg_turn *t, const btg_drop_result *drop) {
    return drop->status != BTG_NO_CONTACT && drop->height_mm > t->same_height_mm;
}

static void meet(bracket *b, const btg_drop_result *drop) {
    b->met = b->angle;
    b->contact = drop->contact;
    b->element = drop->element;
}

/* The two ends: as dropped, and turned as far as may be. */
static btg_status begin(const btg_turn *t, const btg_tilt_query *queries, size_t count, work *r) {
    for (size_t i = 0; i < count; i++)
        r->brackets[i] = (bracket){.angle = 0};
    btg_status status = drop_turned(t, queries, count, r);
    for (size_t i = 0; i < count && status >= 0; i++) {
        r->brackets[i].inside = rests_higher(t, &r->results[i]);
        r->brackets[i].angle = queries[i].max_tilt_rad;
    }
    if (status >= 0) status = drop_turned(t, queries, count, r);
    for (size_t i = 0; i < count && status >= 0; i++) {
        r->brackets[i].ended = !rests_higher(t, &r->results[i]);
        meet(&r->brackets[i], &r->results[i]);
    }
    return status;
}

static btg_status bisect(const btg_turn *t, const btg_tilt_query *queries, size_t count, work *r) {
    btg_status status = begin(t, queries, count, r);
    for (int k = 0; k < HALVINGS && status >= 0; k++) {
        for (size_t i = 0; i < count; i++) {
            bracket *b = &r->brackets[i];
            b->angle = b->clear + 0.5 * (b->met - b->clear);
        }
        status = drop_turned(t, queries, count, r);
        for (size_t i = 0; i < count && status >= 0; i++) {
            if (rests_higher(t, &r->results[i]))
                meet(&r->brackets[i], &r->results[i]);
            else
                r->brackets[i].clear = r->brackets[i].angle;
        }
    }
    return status;
}

static btg_tilt_result result_of(const btg_tilt_query *query, const bracket *b) {
    btg_tilt_result r = {.bound_mm = NAN, .nodes = b->nodes, .element = b->element};
    if (b->inside) {
        r = (btg_tilt_result){.status = BTG_ERROR_GOUGE};
    } else if (b->ended) {
        r.status = BTG_SINGLE_CONTACT;
        r.tilt_rad = query->max_tilt_rad;
        r.element = 0;
    } else {
        bool merged = vec_norm(vec_sub(b->contact.point, query->p.point)) < MERGED;
        r.status = merged ? BTG_OSCULATING : BTG_OK;
        r.tilt_rad = b->clear;
        r.contact = merged ? query->p : b->contact;
    }
    return r;
}

btg_status btg_turn_tilt(const btg_turn *turn, const btg_tilt_query *queries, size_t count,
                         btg_tilt_result *results) {
    work r = {0};
    btg_status status = BTG_ERROR_MEMORY;
    if (make_room(turn, count, &r)) status = bisect(turn, queries, count, &r);
    for (size_t i = 0; i < count && status >= 0; i++)
        results[i] = result_of(&queries[i], &r.brackets[i]);
    leave(turn, &r);
    return status;
}
