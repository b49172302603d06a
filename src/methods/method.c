#include "methods/method.h"
#include "methods/internal.h"

#include <string.h>

#define RAY_SPACING_MM 0.1
#define WINDOW_MAX     4096
#define LEVELS         2
#define SEED           1

struct btg_method {
    btg_method_info info;
    btg_method_def def;
    btg_method_counts counts;
    btg_method_context context;
    btg_backend *front;
};

/* `table` NULL: the back end itself is the method. */
static const struct {
    btg_method_info info;
    const btg_backend_table *table;
} methods[] = {
    {{"vcrf", "vertical and circular rays: the exact solver", true, true, false}, NULL},
    {{"vcrf-grid", "the rays of a dense grid under the tool's shadow", false, false, false},
     &btg_method_vcrf_grid},
    {{"depth", "drops on the part turned at bisected angles, by any back end", true, false, false},
     &btg_method_depth},
    {{"dst", "drop, spin and tilt by Newton's method from random seeds", false, true, false},
     &btg_method_dst},
    {{"drd", "drops by rays from a grid on the tool, on the turned part", false, false, true},
     &btg_method_drd},
    {{"sr", "surface rotation: drops by a grid's rays on the turned part", false, false, true},
     &btg_method_sr},
    {{"direct", "Newton's method where x and y are linear in u and v", false, false, true},
     &btg_method_direct},
    {{"bisection", "a gouge grid, bisected, where x and y are linear in u and v", false, false,
      true},
     &btg_method_bisection},
};

#define METHODS (sizeof methods / sizeof *methods)

btg_method_def btg_method_def_default(void) {
    return (btg_method_def){.backend = btg_backend_def_default(),
                            .ray_spacing_mm = RAY_SPACING_MM,
                            .levels = LEVELS,
                            .seed = SEED};
}

size_t btg_method_count(void) {
    return METHODS;
}

btg_method_info btg_method_get_info(size_t index) {
    return methods[index].info;
}

static size_t find(const char *name) {
    size_t i = 0;
    while (i < METHODS && strcmp(methods[i].info.name, name) != 0)
        i++;
    return i;
}

bool btg_method_find(const char *name, btg_method_info *info) {
    size_t i = find(name);
    if (i < METHODS) *info = methods[i].info;
    return i < METHODS;
}

btg_contact btg_method_contact(const btg_ray_query *query, double value, uint32_t element,
                               btg_place place, btg_vec3 point) {
    btg_ray_distance d =
        btg_ray_tool_distance(&query->tool->element[element], btg_ray_place(query, value), point);
    return (btg_contact){place, point, vec_scale(d.normal, -1)};
}

/* ---- opening ------------------------------------------------------------------------------ */

static btg_status check(const btg_method_def *def, const btg_method_info *info,
                        const btg_solver_def *solver, btg_message *message) {
    if (!(def->ray_spacing_mm > 0))
        return btg_fail(message, BTG_ERROR_ARGUMENT, "method %s: the ray spacing is not above 0",
                        info->name);
    if (def->window > WINDOW_MAX)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "method %s: a window of %u pixels; give %d",
                        info->name, def->window, WINDOW_MAX);
    if (def->levels != 1 && def->levels != 2)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "method %s: %d levels; give 1 or 2",
                        info->name, def->levels);
    if (solver->spin != BTG_SPIN_NONE && !info->spins)
        return btg_fail(message, BTG_ERROR_UNSUPPORTED,
                        "method %s does not spin the tool; leave --spin out, or take vcrf or dst",
                        info->name);
    const char *backend = def->backend.name;
    if (!info->uses_backend && backend && strcmp(backend, "auto") != 0)
        return btg_fail(message, BTG_ERROR_ARGUMENT,
                        "method %s works by itself, not on '%.64s'; leave --backend out",
                        info->name, backend);
    return BTG_OK;
}

/* The method's own front, around the back end where it uses one. */
static btg_status open_fronts(btg_method *m, const btg_backend_table *table, const btg_part *part,
                              const btg_tool *tool, const btg_solver_def *solver,
                              btg_message *message) {
    btg_backend **outer = table ? &m->context.inner : &m->front;
    btg_status status = BTG_OK;
    if (m->info.uses_backend)
        status = btg_backend_open(&m->def.backend, part, tool, solver, outer, message);
    if (status != BTG_OK || !table) return status;
    m->context.def = &m->def;
    m->context.counts = &m->counts;
    return btg_backend_open_table(table, &m->context, &m->def.backend, part, tool, solver,
                                  &m->front, message);
}

btg_status btg_method_open(const btg_method_def *def, const btg_part *part, const btg_tool *tool,
                           const btg_solver_def *solver, btg_method **method,
                           btg_message *message) {
    if (!def || !part || !tool || !solver || !method)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "method: an argument is NULL");
    size_t i = find(def->name ? def->name : "vcrf");
    if (i == METHODS)
        return btg_fail(message, BTG_ERROR_ARGUMENT, "unknown method '%.64s'", def->name);
    btg_status status = check(def, &methods[i].info, solver, message);
    if (status != BTG_OK) return status;
    const btg_allocator *allocator = &def->backend.allocator;
    btg_method *m = btg_allocate(allocator, 1, sizeof *m);
    if (!m) return btg_fail(message, BTG_ERROR_MEMORY, "method: out of memory");
    *m = (btg_method){.info = methods[i].info, .def = *def};
    m->def.backend.levels = (uint32_t)def->levels;
    m->def.backend.window_pixels = def->window;
    status = open_fronts(m, methods[i].table, part, tool, solver, message);
    if (status != BTG_OK) {
        btg_method_close(m);
        return status;
    }
    *method = m;
    return BTG_OK;
}

void btg_method_close(btg_method *method) {
    if (!method) return;
    btg_allocator allocator = method->def.backend.allocator;
    btg_backend_close(method->front);
    btg_backend_close(method->context.inner);
    btg_release(&allocator, method);
}

/* ---- what it is --------------------------------------------------------------------------- */

/* The back end that answers; NULL: the method itself. */
static btg_backend *backend_of(const btg_method *m) {
    return m->context.inner ? m->context.inner : m->info.uses_backend ? m->front : NULL;
}

btg_backend *btg_method_front(const btg_method *method) {
    return method->front;
}

const char *btg_method_backend_name(const btg_method *method) {
    const btg_backend *b = backend_of(method);
    return b ? btg_backend_name(b) : "none";
}

const char *btg_method_note(const btg_method *method) {
    const btg_backend *b = backend_of(method);
    return b ? btg_backend_note(b) : "";
}

uint32_t btg_method_threads(const btg_method *method) {
    const btg_backend *b = backend_of(method);
    return b ? btg_backend_threads(b) : 1;
}

void btg_method_get_times(const btg_method *method, btg_backend_times *times) {
    const btg_backend *b = backend_of(method);
    *times = (btg_backend_times){0};
    if (b) btg_backend_get_times(b, times);
}

btg_method_counts btg_method_get_counts(const btg_method *method) {
    return method->counts;
}
