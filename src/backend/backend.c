/* The front: checks once, dispatches to a table, composes positions from its two answers. */
#define _GNU_SOURCE
#include "backend/internal.h"
#include "core/check.h"
#include "core/part.h"
#include "core/spin.h"

#include <string.h>
#include <unistd.h>
#ifdef __linux__
#include <sched.h>
#endif

#define BACKEND_DEF_VERSION 1
/* More threads than any machine this runs on has; a larger number is a slip of the finger. */
#define THREADS_MAX 1024
/* Pixels a side of depth images: the paper's, for one level and for two; and what makes sense. */
#define WINDOW_ONE 625
#define WINDOW_TWO 50
#define WINDOW_MIN 8
#define WINDOW_MAX 4096

struct btg_backend {
    const btg_backend_table *table;
    void *state;
    btg_backend_setup setup;
    btg_part_info info;
    /* Scratch of one block of positions. */
    size_t block;
    btg_drop_query *drop_queries;
    btg_drop_result *drop_results;
    btg_tilt_query *tilt_queries;
    btg_tilt_result *tilt_results;
    size_t *tilt_owner;        /* entry of the block that a tilt query belongs to */
    btg_spin_search *searches; /* one an entry, where the spin is searched for; else NULL */
    bool *searched;            /* the entry has a tilt, and so a search */
    void *workspace;           /* for guesses; else NULL */
};

btg_backend_def btg_backend_def_default(void) {
    btg_backend_def def;
    memset(&def, 0, sizeof def);
    def.version = BACKEND_DEF_VERSION;
    def.levels = 2;
    return def;
}

static uint32_t machine_threads(void) {
#ifdef __linux__
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) {
        int n = CPU_COUNT(&set);
        if (n > 0) return n < THREADS_MAX ? (uint32_t)n : THREADS_MAX;
    }
#endif
    long n = sysconf(_SC_NPROCESSORS_ONLN);
    if (n < 1) return 1;
    return n < THREADS_MAX ? (uint32_t)n : THREADS_MAX;
}

/* ---- opening ------------------------------------------------------------------------------ */

static btg_status unknown_name(const char *name, btg_message *message) {
    char known[256] = "";
    for (size_t i = 0; i < btg_backend_registry_count; i++) {
        if (i > 0) strncat(known, ", ", sizeof known - strlen(known) - 1);
        strncat(known, btg_backend_registry[i]->name, sizeof known - strlen(known) - 1);
    }
    return btg_fail(message, BTG_ERROR_ARGUMENT, "unknown back end '%.64s'; known are auto, %s",
                    name, known);
}

/* `why`: what is missing, where something is. */
static btg_backend_state probe(const btg_backend_table *table, char why[256]) {
    why[0] = '\0';
    return table->probe ? table->probe(why, 256) : BTG_BACKEND_NOT_BUILT;
}

/* Sets *found by name; with `,auto` behind it *any too, and then nobody need be ready. */
static btg_status find(const char *name, const btg_backend_table **found, bool *any,
                       btg_message *message) {
    *found = NULL;
    *any = !name || strcmp(name, "auto") == 0;
    if (*any) return BTG_OK;
    const char *comma = strchr(name, ',');
    size_t length = comma ? (size_t)(comma - name) : strlen(name);
    *any = comma && strcmp(comma, ",auto") == 0;
    for (size_t i = 0; i < btg_backend_registry_count; i++) {
        const btg_backend_table *table = btg_backend_registry[i];
        if (strncmp(name, table->name, length) != 0 || table->name[length] != '\0') continue;
        if (comma && !*any) break;
        *found = table;
        return BTG_OK;
    }
    return unknown_name(name, message);
}

static btg_status check_ready(const btg_backend_table *table, btg_message *message) {
    char why[256];
    btg_backend_state state = probe(table, why);
    if (state == BTG_BACKEND_READY) return BTG_OK;
    if (state == BTG_BACKEND_NOT_BUILT) {
        return btg_fail(message, BTG_ERROR_NOT_BUILT,
                        "back end '%s' is not built into this version; 'auto' takes one that is",
                        table->name);
    }
    return btg_fail(message, BTG_ERROR_NO_DEVICE,
                    "back end '%s' finds no device here: %s; 'auto' takes one that runs",
                    table->name, why[0] ? why : "none at all");
}

/* False: no such depth images. */
static bool set_images(const btg_backend_def *def, btg_backend_setup *setup) {
    uint32_t window = def->window_pixels;
    if (def->levels < 1 || def->levels > 2) return false;
    if (window == 0) window = def->levels == 1 ? WINDOW_ONE : WINDOW_TWO;
    if (window < WINDOW_MIN || window > WINDOW_MAX) return false;
    setup->levels = def->levels;
    setup->window = window;
    return true;
}

static btg_status make_setup(const btg_backend_def *def, const btg_part *part, const btg_tool *tool,
                             const btg_solver_def *solver, btg_backend_setup *setup,
                             btg_message *message) {
    if (!def || !part || !tool || !solver) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "back end: an argument is NULL");
    }
    if (def->version != BACKEND_DEF_VERSION) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "back end: unknown version; start from btg_backend_def_default()");
    }
    if (def->threads > THREADS_MAX) {
        return btg_fail(message, BTG_ERROR_ARGUMENT, "back end: %lu threads; give at most %d",
                        (unsigned long)def->threads, THREADS_MAX);
    }
    memset(setup, 0, sizeof *setup);
    if (!set_images(def, setup)) {
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "back end: %lu levels of %lu pixels; give 1 or 2 levels of %d to %d pixels",
                        (unsigned long)def->levels, (unsigned long)def->window_pixels, WINDOW_MIN,
                        WINDOW_MAX);
    }
    btg_status status = btg_tool_init(&tool->def, &setup->tool, message);
    if (status == BTG_OK) status = btg_check_solver(solver, message);
    if (status != BTG_OK) return status;
    setup->part = part;
    setup->solver = *solver;
    setup->threads = def->threads > 0 ? def->threads : machine_threads();
    setup->allocator = def->allocator;
    setup->raw = def->raw != 0;
    setup->gl_context = def->gl_context;
    return BTG_OK;
}

static bool make_scratch(btg_backend *b) {
    const btg_allocator *a = &b->setup.allocator;
    b->block = b->table->block > 0 ? b->table->block : BTG_BACKEND_BLOCK;
    b->drop_queries = btg_allocate(a, b->block, sizeof *b->drop_queries);
    b->drop_results = btg_allocate(a, b->block, sizeof *b->drop_results);
    b->tilt_queries = btg_allocate(a, b->block, sizeof *b->tilt_queries);
    b->tilt_results = btg_allocate(a, b->block, sizeof *b->tilt_results);
    b->tilt_owner = btg_allocate(a, b->block, sizeof *b->tilt_owner);
    if (btg_spin_searches(&b->setup.solver)) {
        b->searches = btg_allocate(a, b->block, sizeof *b->searches);
        b->searched = btg_allocate(a, b->block, sizeof *b->searched);
        if (!b->searches || !b->searched) return false;
        if (b->table->guesses) {
            b->workspace = btg_allocate(a, 1, btg_workspace_size(b->setup.part));
            if (!b->workspace) return false;
        }
    }
    return b->drop_queries && b->drop_results && b->tilt_queries && b->tilt_results &&
           b->tilt_owner;
}

static btg_status open_front(const btg_backend_table *table, const btg_backend_setup *setup,
                             btg_backend **backend, btg_message *message) {
    btg_backend *b = btg_allocate(&setup->allocator, 1, sizeof *b);
    if (!b) return btg_fail(message, BTG_ERROR_MEMORY, "back end: out of memory");
    *b = (btg_backend){.table = table, .setup = *setup};
    btg_part_get_info(setup->part, &b->info);
    btg_status status;
    if (!make_scratch(b)) {
        status = btg_fail(message, BTG_ERROR_MEMORY, "back end: out of memory");
    } else {
        status = table->open(&b->setup, &b->state, message);
    }
    if (status != BTG_OK) {
        btg_backend_close(b);
        return status;
    }
    *backend = b;
    return BTG_OK;
}

btg_status btg_backend_open(const btg_backend_def *def, const btg_part *part, const btg_tool *tool,
                            const btg_solver_def *solver, btg_backend **backend,
                            btg_message *message) {
    btg_backend_setup setup;
    const btg_backend_table *table = NULL;
    if (!backend) return btg_fail(message, BTG_ERROR_ARGUMENT, "back end: the result is NULL");
    bool any = false;
    btg_status status = make_setup(def, part, tool, solver, &setup, message);
    if (status == BTG_OK) status = find(def->name, &table, &any, message);
    if (status == BTG_OK && !any) status = check_ready(table, message);
    if (status != BTG_OK) return status;
    if (!any) return open_front(table, &setup, backend, message);
    const btg_fallback_def all = {btg_backend_registry, btg_backend_registry_count, table};
    setup.user = &all;
    return open_front(&btg_backend_fallback, &setup, backend, message);
}

btg_status btg_backend_open_table(const btg_backend_table *table, const void *user,
                                  const btg_backend_def *def, const btg_part *part,
                                  const btg_tool *tool, const btg_solver_def *solver,
                                  btg_backend **backend, btg_message *message) {
    btg_backend_setup setup;
    btg_status status = make_setup(def, part, tool, solver, &setup, message);
    if (status != BTG_OK) return status;
    setup.user = user;
    return open_front(table, &setup, backend, message);
}

void btg_backend_close(btg_backend *backend) {
    if (!backend) return;
    btg_allocator allocator = backend->setup.allocator;
    if (backend->state) backend->table->close(backend->state);
    btg_release(&allocator, backend->drop_queries);
    btg_release(&allocator, backend->drop_results);
    btg_release(&allocator, backend->tilt_queries);
    btg_release(&allocator, backend->tilt_results);
    btg_release(&allocator, backend->tilt_owner);
    btg_release(&allocator, backend->searches);
    btg_release(&allocator, backend->searched);
    btg_release(&allocator, backend->workspace);
    btg_release(&allocator, backend);
}

const char *btg_backend_name(const btg_backend *backend) {
    return backend->table->ran ? backend->table->ran(backend->state) : backend->table->name;
}

const char *btg_backend_note(const btg_backend *backend) {
    return backend->table->note ? backend->table->note(backend->state) : "";
}

uint32_t btg_backend_threads(const btg_backend *backend) {
    return backend->table->threads ? backend->table->threads(backend->state) : 1;
}

void btg_backend_get_times(const btg_backend *backend, btg_backend_times *times) {
    *times = (btg_backend_times){0};
    if (backend->table->times) backend->table->times(backend->state, times);
}

/* ---- batches ------------------------------------------------------------------------------ */

static btg_status refuse(size_t index, size_t *bad) {
    if (bad) *bad = index;
    return BTG_ERROR_ARGUMENT;
}

btg_status btg_backend_drop(btg_backend *backend, const btg_drop_query *queries, size_t count,
                            btg_drop_result *results, size_t *bad) {
    if (count == 0) return BTG_OK;
    if (!backend || !queries || !results) return refuse(0, bad);
    for (size_t i = 0; i < count; i++) {
        if (!btg_check_drop(&queries[i], &backend->info)) return refuse(i, bad);
    }
    return backend->table->drop(backend->state, queries, count, results);
}

btg_status btg_backend_tilt(btg_backend *backend, const btg_tilt_query *queries, size_t count,
                            btg_tilt_result *results, size_t *bad) {
    if (count == 0) return BTG_OK;
    if (!backend || !queries || !results) return refuse(0, bad);
    for (size_t i = 0; i < count; i++) {
        if (!btg_check_tilt(&queries[i], &backend->setup.tool, &backend->info))
            return refuse(i, bad);
    }
    return backend->table->tilt(backend->state, queries, count, results);
}

/* ---- positions ---------------------------------------------------------------------------- */

/* Collects the tilt queries of those drops that leave one; returns how many. */
static size_t collect_tilts(btg_backend *b, size_t count) {
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        if (b->drop_results[i].status != BTG_OK) continue;
        btg_status status =
            btg_position_tilt_query(&b->setup.tool, &b->setup.solver, &b->drop_queries[i],
                                    &b->drop_results[i], &b->tilt_queries[n]);
        if (status != BTG_OK) continue;
        b->tilt_owner[n++] = i;
    }
    return n;
}

/* No answer: a position of an error and the footprint alone. */
static void give_error(btg_status status, const double *foot, btg_position *position) {
    btg_position p = {.status = status, .foot_x_mm = foot[0], .foot_y_mm = foot[1]};
    p.tip = p.axis = p.p.point = p.p.normal = p.q.point = p.q.normal = vec_nan();
    p.drop_z_mm = p.tilt_rad = p.spin_rad = p.inclination_rad = p.bound_mm = NAN;
    *position = p;
}

static void assemble(const btg_backend *b, const double *foot, size_t i, size_t tilt,
                     btg_position *position) {
    const btg_drop_result *drop = &b->drop_results[i];
    const btg_tilt_result *result = tilt != SIZE_MAX ? &b->tilt_results[tilt] : NULL;
    const btg_tilt_query *query = result ? &b->tilt_queries[tilt] : NULL;
    btg_position p = {0};
    btg_status status = btg_position_assemble(&b->setup.tool, &b->setup.solver, foot[0], foot[1],
                                              &b->drop_queries[i], drop, query, result, &p);
    if (status < 0) {
        give_error(status, foot, position);
    } else {
        *position = p;
    }
}

static btg_status solve_tilts(btg_backend *b, const double *foot, size_t count,
                              btg_position *positions) {
    btg_status status = BTG_OK;
    size_t tilts = collect_tilts(b, count);
    if (tilts > 0) status = b->table->tilt(b->state, b->tilt_queries, tilts, b->tilt_results);
    if (status < 0) return status;
    size_t next = 0;
    for (size_t i = 0; i < count; i++) {
        bool tilted = next < tilts && b->tilt_owner[next] == i;
        assemble(b, &foot[2 * i], i, tilted ? next : SIZE_MAX, &positions[i]);
        if (tilted) next++;
    }
    return BTG_OK;
}

static void begin_searches(btg_backend *b, size_t count) {
    const btg_backend_setup *s = &b->setup;
    for (size_t i = 0; i < count; i++) {
        btg_tilt_query unspun;
        b->searched[i] = b->drop_results[i].status == BTG_OK &&
                         btg_position_tilt_query(&s->tool, &s->solver, &b->drop_queries[i],
                                                 &b->drop_results[i], &unspun) == BTG_OK;
        if (b->searched[i])
            btg_spin_begin(&b->searches[i], s->part, &s->tool, &s->solver, &unspun, NAN);
    }
}

/* The next tilt that a search asks of the back end; false: it is over. */
static bool next_tilt(btg_backend *b, btg_spin_search *search, btg_tilt_query *query) {
    const btg_backend_setup *s = &b->setup;
    while (btg_spin_next(search, query)) {
        if (!search->may_guess || !b->workspace) return true;
        btg_tilt_result guess = {0};
        guess.status = btg_tilt_near(s->part, &s->tool, &s->solver, query, b->workspace,
                                     btg_workspace_size(s->part), &guess);
        btg_spin_take(search, query, &guess, true);
    }
    return false;
}

/* Rounds of batches: in each, every search that goes on asks one tilt. */
static btg_status solve_searches(btg_backend *b, const double *foot, size_t count,
                                 btg_position *positions) {
    begin_searches(b, count);
    for (;;) {
        size_t tilts = 0;
        for (size_t i = 0; i < count; i++) {
            if (!b->searched[i] || !next_tilt(b, &b->searches[i], &b->tilt_queries[tilts]))
                continue;
            b->tilt_owner[tilts++] = i;
        }
        if (tilts == 0) break;
        btg_status status = b->table->tilt(b->state, b->tilt_queries, tilts, b->tilt_results);
        if (status < 0) return status;
        for (size_t k = 0; k < tilts; k++)
            btg_spin_take(&b->searches[b->tilt_owner[k]], &b->tilt_queries[k], &b->tilt_results[k],
                          false);
    }
    for (size_t i = 0; i < count; i++) {
        if (!b->searched[i]) {
            assemble(b, &foot[2 * i], i, SIZE_MAX, &positions[i]);
            continue;
        }
        btg_position p = {0};
        btg_status status = btg_spin_finish(&b->searches[i], foot[2 * i], foot[2 * i + 1],
                                            &b->drop_queries[i], &b->drop_results[i], &p);
        if (status < 0) {
            give_error(status, &foot[2 * i], &positions[i]);
        } else {
            positions[i] = p;
        }
    }
    return BTG_OK;
}

static btg_status solve_block(btg_backend *b, const double *foot, size_t count,
                              btg_position *positions) {
    for (size_t i = 0; i < count; i++) {
        b->drop_queries[i] = btg_position_drop_query(foot[2 * i], foot[2 * i + 1]);
    }
    btg_status status = b->table->drop(b->state, b->drop_queries, count, b->drop_results);
    if (status < 0) return status;
    if (b->searches) return solve_searches(b, foot, count, positions);
    return solve_tilts(b, foot, count, positions);
}

btg_status btg_backend_positions(btg_backend *backend, const double *foot_xy_mm, size_t count,
                                 btg_position *positions, size_t *bad) {
    if (count == 0) return BTG_OK;
    if (!backend || !foot_xy_mm || !positions) return refuse(0, bad);
    for (size_t i = 0; i < count; i++) {
        if (!btg_check_foot(foot_xy_mm[2 * i], foot_xy_mm[2 * i + 1])) return refuse(i, bad);
    }
    for (size_t i = 0; i < count; i += backend->block) {
        size_t n = count - i < backend->block ? count - i : backend->block;
        btg_status status = solve_block(backend, &foot_xy_mm[2 * i], n, &positions[i]);
        if (status < 0) return status;
    }
    return BTG_OK;
}
