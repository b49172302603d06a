#include "app/solve.h"
#include "core/vec.h"

btg_status solve_open(const path_options *o, const btg_part *part, const btg_tool *tool,
                      btg_method **method, btg_message *message) {
    btg_method_def def = btg_method_def_default();
    def.name = o->method;
    def.ray_spacing_mm = o->ray_spacing_mm;
    def.levels = o->levels;
    def.window = o->window;
    def.backend.name = o->backend;
    def.backend.threads = o->threads;
    def.backend.raw = o->raw;
    def.backend.gl_context = o->gl_context;
    btg_solver_def solver = o->solver;
    solver.feed_x = cos(o->feed_deg * (BTG_PI / 180));
    solver.feed_y = sin(o->feed_deg * (BTG_PI / 180));
    return btg_method_open(&def, part, tool, &solver, method, message);
}
