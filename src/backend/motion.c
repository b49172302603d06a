/* Positions as a list, and work on the moves between them until none is left to do. */
#include "bitangent/motion.h"
#include "core/motion.h"
#include "core/part.h"

#include <string.h>

#define DEF_VERSION 1
#define NONE        UINT32_MAX
/* Positions held before they are worked on, where no more are needed. */
#define HELD_MOST 2048
/* Share of the tolerance that is left to what lies between two moments. */
#define BETWEEN_SHARE 0.5
/* Moments of one move; a longer one is divided unseen. */
#define MOMENTS_MOST  1024
#define MOMENTS_BLOCK 4096
/* A hop starts this much higher than what it has to get over, and doubles. */
#define HOP_ROOM_MM 0.1
/* Leans that differ by less are the same. */
#define LEAN_SAME 1e-12

typedef struct item {
    btg_motion_stop stop;
    uint32_t next, before;
    bool pending;   /* the move to the next item is in the list of those to be looked at */
    bool undivided; /* the foot half-way to the next one has no contact */
    bool leant;
    bool gone;       /* out of the list */
    double bound_mm; /* of the move to the next item */
    double hop_mm;   /* of a hop's first item: how far it backs out */
} item;

typedef struct move {
    uint32_t from;
    double bound;   /* deepest at its moments, mm */
    double between; /* and what they miss */
} move;

struct btg_motion {
    btg_motion_def def;
    btg_backend *backend;
    btg_tool tool;
    btg_motion_info info;
    bool broken;   /* the last position added has no contact */
    bool unproven; /* the back end gave no bound */

    item *items;
    uint32_t count, capacity, first, last;
    bool carried; /* the first item was given before; it is there as where the tool stands */

    move *moves;
    uint32_t move_count, move_capacity;
    uint32_t *divided; /* moves whose feet half-way are to be solved */
    uint32_t divided_count, divided_capacity;

    btg_drop_query *queries;
    btg_drop_result *results;
    uint32_t *owner;
    uint32_t query_count;
};

/* ---- set-up ------------------------------------------------------------------------------- */

btg_motion_def btg_motion_def_default(void) {
    btg_motion_def def;
    memset(&def, 0, sizeof def);
    def.version = DEF_VERSION;
    def.tolerance_mm = 0.005;
    def.closest_mm = 0.02;
    def.clear_z_mm = NAN;
    return def;
}

static btg_status check(const btg_motion_def *d, btg_message *message) {
    if (d->version != DEF_VERSION)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "motion: unknown version; start from btg_motion_def_default()");
    if (!d->give)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "motion: no function to give stops to");
    if (!(d->tolerance_mm == 0 || (d->tolerance_mm >= 1e-6 && d->tolerance_mm <= 1)))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "motion: a tolerance of %g mm; give 1e-6 to 1, or 0", d->tolerance_mm);
    if (!(d->closest_mm >= 1e-6 && d->closest_mm <= BTG_LENGTH_MAX))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "motion: feet %g mm apart at the closest; give 1e-6 or more",
                        d->closest_mm);
    if (!(fabs(d->clear_z_mm) <= BTG_LENGTH_MAX))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "motion: give a height that is clear of the part, in mm");
    if (!(d->turn_rad_per_mm >= 0 && d->turn_rad_per_mm <= 1e6))
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "motion: a turn of %g radians a mm; give more than 0, or 0 for any",
                        d->turn_rad_per_mm);
    return BTG_OK;
}

btg_status btg_motion_create(const btg_motion_def *def, btg_backend *backend, const btg_tool *tool,
                             btg_motion **motion, btg_message *message) {
    if (!def || !backend || !tool || !motion)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "motion: an argument is NULL");
    btg_status status = check(def, message);
    if (status != BTG_OK) return status;
    btg_motion *m = btg_allocate(&def->allocator, 1, sizeof *m);
    if (!m) return btg_fail(message, BTG_ERROR_MEMORY, "motion: out of memory");
    memset(m, 0, sizeof *m);
    m->def = *def;
    m->backend = backend;
    m->tool = *tool;
    m->first = m->last = NONE;
    m->queries = btg_allocate(&def->allocator, MOMENTS_BLOCK, sizeof *m->queries);
    m->results = btg_allocate(&def->allocator, MOMENTS_BLOCK, sizeof *m->results);
    m->owner = btg_allocate(&def->allocator, MOMENTS_BLOCK, sizeof *m->owner);
    if (!m->queries || !m->results || !m->owner) {
        btg_motion_destroy(m);
        return btg_fail(message, BTG_ERROR_MEMORY, "motion: out of memory");
    }
    *motion = m;
    return BTG_OK;
}

void btg_motion_destroy(btg_motion *m) {
    if (!m) return;
    btg_allocator a = m->def.allocator;
    void *memory[] = {m->items, m->moves, m->divided, m->queries, m->results, m->owner};
    for (size_t i = 0; i < sizeof memory / sizeof *memory; i++)
        btg_release(&a, memory[i]);
    btg_release(&a, m);
}

/* Room for one more of `count`. */
static bool grow(const btg_motion *m, void **array, uint32_t count, uint32_t *capacity,
                 size_t size) {
    if (count < *capacity) return true;
    if (*capacity > NONE / 4) return false;
    uint32_t wanted = *capacity > 0 ? 2 * *capacity : 256;
    void *larger = btg_allocate(&m->def.allocator, wanted, size);
    if (!larger) return false;
    if (count > 0) memcpy(larger, *array, count * size);
    btg_release(&m->def.allocator, *array);
    *array = larger;
    *capacity = wanted;
    return true;
}

/* ---- the list ----------------------------------------------------------------------------- */

/* Puts a stop behind `before` (NONE: at the end). NONE: no memory. */
static uint32_t put(btg_motion *m, uint32_t before, const btg_motion_stop *stop) {
    if (!grow(m, (void **)&m->items, m->count, &m->capacity, sizeof *m->items)) return NONE;
    uint32_t i = m->count++;
    m->items[i] = (item){.stop = *stop, .next = NONE, .before = before};
    if (before == NONE) before = m->items[i].before = m->last;
    if (before == NONE) {
        m->first = i;
    } else {
        m->items[i].next = m->items[before].next;
        m->items[before].next = i;
    }
    if (m->items[i].next != NONE) m->items[m->items[i].next].before = i;
    if (before == m->last) m->last = i;
    return i;
}

static void take_out(btg_motion *m, uint32_t i) {
    item *at = &m->items[i];
    at->gone = true;
    m->items[at->before].next = at->next;
    m->items[at->next].before = at->before;
}

static bool moves_on(const btg_motion *m, uint32_t i) {
    uint32_t next = m->items[i].next;
    return next != NONE && m->items[next].stop.link;
}

/* The move that begins at item i is to be looked at. */
static btg_status look_at(btg_motion *m, uint32_t i) {
    if (m->def.tolerance_mm == 0 || i == NONE || m->items[i].pending || !moves_on(m, i))
        return BTG_OK;
    if (!grow(m, (void **)&m->moves, m->move_count, &m->move_capacity, sizeof *m->moves))
        return BTG_ERROR_MEMORY;
    m->moves[m->move_count++] = (move){.from = i};
    m->items[i].pending = true;
    return BTG_OK;
}

/* ---- lean --------------------------------------------------------------------------------- */

static double lean_of(const item *i) {
    double tilt = i->stop.position.tilt_rad;
    return tilt > 0 ? tilt : 0;
}

static bool bound_together(const btg_motion *m, uint32_t a) {
    uint32_t b = m->items[a].next;
    return moves_on(m, a) && m->items[a].stop.kind != BTG_MOTION_HOP &&
           m->items[b].stop.kind != BTG_MOTION_HOP;
}

static double feet_apart(const btg_position *a, const btg_position *b) {
    return norm2(b->foot_x_mm - a->foot_x_mm, b->foot_y_mm - a->foot_y_mm);
}

/* The pose of item i, backed out along its axis. */
static btg_motion_stop backed_out(const btg_motion *m, uint32_t i, double mm, uint64_t index) {
    const btg_position *p = &m->items[i].stop.position;
    btg_motion_stop s = {.kind = BTG_MOTION_HOP, .index = index, .link = 1};
    s.position.foot_x_mm = p->foot_x_mm;
    s.position.foot_y_mm = p->foot_y_mm;
    s.position.axis = p->axis;
    s.position.tip = vec_mad(p->tip, p->axis, mm);
    s.position.p.point = s.position.q.point = vec_nan();
    s.position.bound_mm = NAN;
    return s;
}

/* The hops that begin or end at item i follow it. */
static btg_status hops_follow(btg_motion *m, uint32_t i) {
    uint32_t after = m->items[i].next, before = m->items[i].before;
    btg_status status = BTG_OK;
    if (after != NONE && m->items[after].stop.kind == BTG_MOTION_HOP) {
        item *over = &m->items[after];
        over->stop = backed_out(m, i, over->hop_mm, over->stop.index);
        status = look_at(m, after);
    }
    if (status == BTG_OK && before != NONE && m->items[before].stop.kind == BTG_MOTION_HOP) {
        item *down = &m->items[before];
        uint32_t over = down->before;
        down->stop = backed_out(m, i, m->items[over].hop_mm, down->stop.index);
        status = look_at(m, over);
    }
    return status;
}

/* Holds the lean of `at` to what its neighbour `other` allows it. */
static btg_status hold(btg_motion *m, uint32_t at, uint32_t other) {
    item *i = &m->items[at];
    const item *o = &m->items[other];
    double turn = m->def.turn_rad_per_mm * feet_apart(&i->stop.position, &o->stop.position);
    btg_motion_bond bond = btg_motion_bind(&m->tool, &i->stop.position, &o->stop.position, turn);
    double most = min2(bond.cap, bond.turn + bond.share * lean_of(o));
    if (lean_of(i) <= most + LEAN_SAME) return BTG_OK;
    btg_motion_lean(&m->tool, most, &i->stop.position);
    i->leant = true;
    btg_status status = look_at(m, i->before);
    if (status == BTG_OK) status = look_at(m, at);
    return status == BTG_OK ? hops_follow(m, at) : status;
}

/* The greatest leans that keep to the turn: once along the list, and once back. */
static btg_status hold_all(btg_motion *m) {
    btg_status status = BTG_OK;
    if (m->def.turn_rad_per_mm == 0) return BTG_OK;
    for (uint32_t i = m->first; i != NONE && status == BTG_OK; i = m->items[i].next)
        if (bound_together(m, i)) status = hold(m, m->items[i].next, i);
    for (uint32_t i = m->last; i != NONE && status == BTG_OK; i = m->items[i].before)
        if (bound_together(m, i)) status = hold(m, i, m->items[i].next);
    return status;
}

/* ---- looking at moves --------------------------------------------------------------------- */

static btg_motion_pose pose_of(const item *i) {
    return (btg_motion_pose){i->stop.position.tip, i->stop.position.axis};
}

/* Asks what waits, and takes the worst answer of each move. */
static btg_status ask(btg_motion *m) {
    btg_status status = btg_backend_drop(m->backend, m->queries, m->query_count, m->results, NULL);
    if (status < 0) return status;
    for (uint32_t k = 0; k < m->query_count; k++) {
        const btg_drop_result *r = &m->results[k];
        move *v = &m->moves[m->owner[k]];
        if (r->status < 0) return r->status;
        if (r->status == BTG_NO_CONTACT) continue;
        double deep = max2(r->height_mm, 0) + r->bound_mm;
        /* What proves nothing counts as it stands; the bound told is NaN then. */
        if (isnan(r->bound_mm)) deep = max2(r->height_mm, 0), m->unproven = true;
        v->bound = max2(v->bound, deep);
    }
    m->info.moments += m->query_count;
    m->query_count = 0;
    return BTG_OK;
}

static btg_status ask_pose(btg_motion *m, uint32_t owner, const btg_motion_pose *pose,
                           const btg_contact *near) {
    btg_drop_query *q = &m->queries[m->query_count];
    *q = btg_motion_query(&m->tool, pose);
    q->has_start = vec_finite(near->point);
    if (q->has_start) q->start = near->place;
    m->owner[m->query_count++] = owner;
    return m->query_count < MOMENTS_BLOCK ? BTG_OK : ask(m);
}

/* Along a hop's way out or in the tool moves along its own axis: clear where its lower end is. */
static btg_status ask_way_out(btg_motion *m, uint32_t k) {
    const item *a = &m->items[m->moves[k].from], *b = &m->items[a->next];
    if (a->stop.kind == BTG_MOTION_HOP) a = b;
    btg_motion_pose pose = pose_of(a);
    return ask_pose(m, k, &pose, &a->stop.position.p);
}

static btg_status ask_turn(btg_motion *m, uint32_t k, uint32_t steps, bool chord) {
    const item *a = &m->items[m->moves[k].from], *b = &m->items[a->next];
    btg_motion_pose from = pose_of(a), to = pose_of(b);
    btg_status status = BTG_OK;
    for (uint32_t i = 1; i < steps && status == BTG_OK; i++) {
        btg_motion_pose pose = btg_motion_at(&from, &to, (double)i / steps, chord);
        const item *near = 2 * i < steps ? a : b;
        status = ask_pose(m, k, &pose, &near->stop.position.p);
    }
    return status;
}

static double position_bound(btg_motion *m, const item *a, const item *b) {
    double bound = a->stop.position.bound_mm, other = b->stop.position.bound_mm;
    if (isnan(bound) || isnan(other)) m->unproven = true;
    return max2(isnan(bound) ? 0 : bound, isnan(other) ? 0 : other);
}

static btg_status ask_move(btg_motion *m, uint32_t k) {
    move *v = &m->moves[k];
    const item *a = &m->items[v->from], *b = &m->items[a->next];
    bool hop_a = a->stop.kind == BTG_MOTION_HOP, hop_b = b->stop.kind == BTG_MOTION_HOP;
    if (hop_a != hop_b) return ask_way_out(m, k);
    double between = BETWEEN_SHARE * m->def.tolerance_mm;
    btg_motion_pose from = pose_of(a), to = pose_of(b);
    btg_motion_plan plan = btg_motion_steps(&m->tool, &from, &to, between, MOMENTS_MOST);
    if (plan.steps == 0) {
        v->bound = INFINITY;
        return BTG_OK;
    }
    if (!hop_a) v->bound = position_bound(m, a, b);
    btg_status status = ask_turn(m, k, plan.steps, false);
    if (status == BTG_OK && plan.both) status = ask_turn(m, k, plan.steps, true);
    v->between = between;
    return status;
}

static btg_status look(btg_motion *m) {
    btg_status status = BTG_OK;
    for (uint32_t k = 0; k < m->move_count && status == BTG_OK; k++)
        status = ask_move(m, k);
    return status == BTG_OK ? ask(m) : status;
}

/* ---- what is done about a move ------------------------------------------------------------ */

/* Left out: whoever writes the path retracts there. Items of a hop go. */
static void leave_out(btg_motion *m, uint32_t from) {
    uint32_t i = m->items[from].stop.kind == BTG_MOTION_HOP ? m->items[from].before : from;
    while (m->items[i].stop.kind == BTG_MOTION_HOP)
        i = m->items[i].before;
    while (m->items[m->items[i].next].stop.kind == BTG_MOTION_HOP)
        take_out(m, m->items[i].next);
    m->items[m->items[i].next].stop.link = 0;
    m->info.retracts++;
}

static btg_status hop(btg_motion *m, uint32_t a, double mm) {
    uint32_t b = m->items[a].next;
    uint64_t index = m->items[a].stop.index;
    btg_motion_stop out = backed_out(m, a, mm, index), in = backed_out(m, b, mm, index);
    uint32_t over = put(m, a, &out);
    uint32_t down = over == NONE ? NONE : put(m, over, &in);
    if (down == NONE) return BTG_ERROR_MEMORY;
    m->items[over].hop_mm = mm;
    btg_status status = look_at(m, a);
    if (status == BTG_OK) status = look_at(m, over);
    return status == BTG_OK ? look_at(m, down) : status;
}

/* The hop whose way over begins at item `over` was not clear. */
static btg_status hop_higher(btg_motion *m, uint32_t over) {
    uint32_t down = m->items[over].next, a = m->items[over].before, b = m->items[down].next;
    double mm = 2 * m->items[over].hop_mm;
    uint64_t index = m->items[a].stop.index;
    btg_motion_stop out = backed_out(m, a, mm, index), in = backed_out(m, b, mm, index);
    double reach = m->tool.def.major_radius_mm + m->tool.def.minor_radius_mm;
    double z = m->def.clear_z_mm + 4 * reach;
    if (out.position.tip.z > z && in.position.tip.z > z) {
        leave_out(m, over);
        return BTG_OK;
    }
    m->items[over].stop = out;
    m->items[down].stop = in;
    m->items[over].hop_mm = mm;
    return look_at(m, over);
}

static btg_status divide_later(btg_motion *m, uint32_t a) {
    if (!grow(m, (void **)&m->divided, m->divided_count, &m->divided_capacity, sizeof *m->divided))
        return BTG_ERROR_MEMORY;
    m->divided[m->divided_count++] = a;
    return BTG_OK;
}

/* A move that is too deep in the part. */
static btg_status mend(btg_motion *m, const move *v) {
    uint32_t a = v->from, b = m->items[a].next;
    const item *from = &m->items[a], *to = &m->items[b];
    bool hop_a = from->stop.kind == BTG_MOTION_HOP, hop_b = to->stop.kind == BTG_MOTION_HOP;
    if (hop_a && hop_b) return hop_higher(m, a);
    if (hop_a || hop_b) {
        leave_out(m, a);
        return BTG_OK;
    }
    if (!from->undivided &&
        feet_apart(&from->stop.position, &to->stop.position) >= 2 * m->def.closest_mm)
        return divide_later(m, a);
    double over = v->bound < INFINITY ? v->bound : 0;
    return hop(m, a, over + HOP_ROOM_MM);
}

/* ---- all of it ---------------------------------------------------------------------------- */

static bool touches(const btg_position *p) {
    return p->status >= 0 && p->status != BTG_NO_CONTACT;
}

/* Solves the feet half-way of the moves to be divided. */
static btg_status solve_between(btg_motion *m) {
    const btg_allocator *a = &m->def.allocator;
    uint32_t n = m->divided_count;
    double *feet = btg_allocate(a, n, 2 * sizeof *feet);
    btg_position *solved = btg_allocate(a, n, sizeof *solved);
    btg_status status = feet && solved ? BTG_OK : BTG_ERROR_MEMORY;
    for (uint32_t k = 0; k < n && status == BTG_OK; k++) {
        const item *from = &m->items[m->divided[k]], *to = &m->items[from->next];
        const btg_position *p = &from->stop.position, *q = &to->stop.position;
        feet[2 * k] = 0.5 * (p->foot_x_mm + q->foot_x_mm);
        feet[2 * k + 1] = 0.5 * (p->foot_y_mm + q->foot_y_mm);
    }
    if (status == BTG_OK) status = btg_backend_positions(m->backend, feet, n, solved, NULL);
    for (uint32_t k = 0; k < n && status >= 0; k++) {
        uint32_t from = m->divided[k];
        btg_motion_stop s = {.position = solved[k], .kind = BTG_MOTION_INSERTED, .link = 1};
        s.index = m->items[from].stop.index;
        m->items[from].undivided = !touches(&solved[k]);
        uint32_t middle = touches(&solved[k]) ? put(m, from, &s) : from;
        if (middle == NONE) status = BTG_ERROR_MEMORY;
        if (status >= 0) status = look_at(m, from);
        if (status >= 0 && middle != from) status = look_at(m, middle);
    }
    btg_release(a, feet);
    btg_release(a, solved);
    return status;
}

/* Looks at what is pending and mends it; what that changes is pending then. */
static btg_status work_once(btg_motion *m) {
    btg_status status = look(m);
    uint32_t count = m->move_count;
    move *done = m->moves;
    m->moves = NULL;
    m->move_count = m->move_capacity = m->divided_count = 0;
    for (uint32_t k = 0; k < count; k++)
        m->items[done[k].from].pending = false;
    for (uint32_t k = 0; k < count && status == BTG_OK; k++) {
        double bound = done[k].bound + done[k].between;
        if (m->items[done[k].from].gone || !moves_on(m, done[k].from)) continue;
        if (bound <= m->def.tolerance_mm)
            m->items[done[k].from].bound_mm = bound;
        else
            status = mend(m, &done[k]);
    }
    btg_release(&m->def.allocator, done);
    if (status == BTG_OK && m->divided_count > 0) status = solve_between(m);
    return status;
}

static btg_status work(btg_motion *m) {
    btg_status status = hold_all(m);
    while (status >= 0 && m->move_count > 0) {
        status = work_once(m);
        if (status >= 0) status = hold_all(m);
    }
    return status < 0 ? status : BTG_OK;
}

static void give(btg_motion *m, const item *i) {
    bool hops = i->stop.kind == BTG_MOTION_HOP;
    if (i->stop.kind == BTG_MOTION_INSERTED) m->info.inserted++;
    if (hops && i->hop_mm > 0) m->info.hops++;
    if (i->leant) m->info.leant++;
    m->def.give(&i->stop, m->def.user);
}

/* Gives the list; the last item stays, as the place to go on from. */
static btg_status flush(btg_motion *m) {
    if (m->first == NONE) return BTG_OK;
    btg_status status = work(m);
    if (status < 0) return status;
    for (uint32_t i = m->first; i != NONE; i = m->items[i].next) {
        if (i != m->first || !m->carried) give(m, &m->items[i]);
        if (moves_on(m, i)) m->info.bound_mm = max2(m->info.bound_mm, m->items[i].bound_mm);
    }
    m->items[0] = m->items[m->last];
    m->items[0].next = m->items[0].before = NONE;
    m->first = m->last = 0;
    m->count = 1;
    m->carried = true;
    return BTG_OK;
}

btg_status btg_motion_add(btg_motion *m, const btg_position *position, int link) {
    if (!m || !position) return BTG_ERROR_ARGUMENT;
    bool contact = touches(position);
    bool linked = link && contact && !m->broken && m->info.given > 0;
    btg_status status = BTG_OK;
    if (!linked || (m->def.turn_rad_per_mm == 0 && m->count >= HELD_MOST)) status = flush(m);
    if (status < 0) return status;
    btg_motion_stop s = {.position = *position, .index = m->info.given++, .link = linked};
    m->broken = !contact;
    uint32_t last = m->last;
    if (put(m, NONE, &s) == NONE) return BTG_ERROR_MEMORY;
    return look_at(m, last);
}

btg_status btg_motion_end(btg_motion *m, btg_motion_info *info) {
    if (!m) return BTG_ERROR_ARGUMENT;
    btg_status status = flush(m);
    if (status < 0) return status;
    if (m->def.tolerance_mm == 0 || m->unproven) m->info.bound_mm = NAN;
    if (info) *info = m->info;
    return BTG_OK;
}
