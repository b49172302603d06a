#include "backend/internal.h"

static btg_status drop(const btg_backend_setup *setup, const void *data,
                       const btg_drop_query *query, void *workspace, size_t workspace_size,
                       btg_drop_result *result) {
    (void)data;
    return btg_drop(setup->part, &setup->tool, &setup->solver, query, workspace, workspace_size,
                    result);
}

static btg_status tilt(const btg_backend_setup *setup, const void *data,
                       const btg_tilt_query *query, void *workspace, size_t workspace_size,
                       btg_tilt_result *result) {
    (void)data;
    return btg_tilt(setup->part, &setup->tool, &setup->solver, query, workspace, workspace_size,
                    result);
}

static const btg_host_ops ops = {.workspace_size = btg_workspace_size, .drop = drop, .tilt = tilt};

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    return btg_host_open(&ops, setup, state, message);
}

const btg_backend_table btg_backend_cpu = {
    .name = "cpu",
    .summary = "exact search in double precision on all threads of the processor",
    .probe = btg_host_probe,
    .open = open,
    .close = btg_host_close,
    .drop = btg_host_drop,
    .tilt = btg_host_tilt,
    .guesses = true,
    .threads = btg_host_threads,
};
