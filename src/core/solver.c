/* Drop and tilt: arguments checked, and handed to the build of the run phase for this processor. */
#include "core/check.h"
#include "core/run.h"
#include "core/search.h"
#include "core/spin.h"

btg_solver_def btg_solver_def_default(void) {
    return (btg_solver_def){.version = 1,
                            .tolerance_mm = 0.001,
                            .max_tilt_rad = BTG_PI / 4,
                            .spin = BTG_SPIN_NONE,
                            .node_budget = 1000000};
}

/* ---- workspace ---------------------------------------------------------------------------- */

/* Room to begin where the search is aligned. */
static size_t search_size(const btg_part *part) {
    return _Alignof(btg_search) + sizeof(btg_search) +
           btg_search_stack_size(part) * sizeof(btg_entry);
}

size_t btg_workspace_size(const btg_part *part) {
    return search_size(part) + sizeof(btg_position_parts);
}

btg_position_parts *btg_workspace_parts(const btg_part *part, void *workspace) {
    return (btg_position_parts *)((char *)workspace + search_size(part));
}

const btg_run *btg_run_choose(void) {
#ifdef BTG_HAVE_AVX512
    if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        return &btg_run_avx512;
#endif
#ifdef BTG_HAVE_AVX2
    if (__builtin_cpu_supports("avx2")) return &btg_run_avx2;
#endif
    return &btg_run_baseline;
}

/* ---- the two questions -------------------------------------------------------------------- */

static bool fit(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                const void *workspace, size_t workspace_size) {
    return part && tool && solver && workspace && !btg_check_solver(solver, NULL) &&
           workspace_size >= btg_workspace_size(part);
}

btg_status btg_drop(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                    const btg_drop_query *query, void *workspace, size_t workspace_size,
                    btg_drop_result *result) {
    if (!fit(part, tool, solver, workspace, workspace_size) || !query || !result ||
        !btg_check_drop(query, &part->info))
        return BTG_ERROR_ARGUMENT;
    return btg_run_choose()->drop(part, tool, solver, query, workspace, result);
}

btg_status btg_tilt(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                    const btg_tilt_query *query, void *workspace, size_t workspace_size,
                    btg_tilt_result *result) {
    if (!fit(part, tool, solver, workspace, workspace_size) || !query || !result ||
        !btg_check_tilt(query, tool, &part->info))
        return BTG_ERROR_ARGUMENT;
    return btg_run_choose()->tilt(part, tool, solver, query, workspace, result);
}

btg_status btg_tilt_near(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                         const btg_tilt_query *query, void *workspace, size_t workspace_size,
                         btg_tilt_result *result) {
    if (!fit(part, tool, solver, workspace, workspace_size) || !query || !result ||
        !query->has_start || !btg_check_tilt(query, tool, &part->info))
        return BTG_ERROR_ARGUMENT;
    return btg_run_choose()->tilt_near(part, tool, solver, query, workspace, result);
}
