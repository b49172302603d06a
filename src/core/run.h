/* The run phase: DROP and TILT, built once for each kind of processor. All builds give the same
 * bits. Internal. */
#ifndef BTG_CORE_RUN_H
#define BTG_CORE_RUN_H

#include "bitangent/bitangent.h"

/* A position's parts, kept behind the search in the workspace: off the stack. */
typedef struct btg_position_parts {
    btg_drop_query query;
    btg_drop_result drop;
    btg_tilt_query frame;
    btg_tilt_result tilt;
} btg_position_parts;

btg_position_parts *btg_workspace_parts(const btg_part *part, void *workspace);

/* Arguments are checked; the workspace is large enough. */
typedef struct btg_run {
    const char *name;
    btg_status (*drop)(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                       const btg_drop_query *query, void *workspace, btg_drop_result *result);
    btg_status (*tilt)(const btg_part *part, const btg_tool *tool, const btg_solver_def *solver,
                       const btg_tilt_query *query, void *workspace, btg_tilt_result *result);
    /* From query->start uphill and no further: not proven, bound_mm infinite. */
    btg_status (*tilt_near)(const btg_part *part, const btg_tool *tool,
                            const btg_solver_def *solver, const btg_tilt_query *query,
                            void *workspace, btg_tilt_result *result);
} btg_run;

extern const btg_run btg_run_baseline; /* for any processor of the kind */
extern const btg_run btg_run_avx2;     /* where they were built */
extern const btg_run btg_run_avx512;

/* The one for this processor. */
const btg_run *btg_run_choose(void);

#endif
