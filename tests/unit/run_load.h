/* Work for the tests of the run phase: every run call on parts and with tools of every kind. */
#ifndef BTG_TESTS_RUN_LOAD_H
#define BTG_TESTS_RUN_LOAD_H

#include "bitangent/bitangent.h"

#include "../conformance/rng.h"

/* Sanitizers make system calls and use the stack themselves: such builds skip. */
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#endif

#define EXIT_SKIPPED 77

#define RUN_PARTS 6
#define RUN_TOOLS 6
#define RUN_LOADS (RUN_PARTS * RUN_TOOLS)

typedef struct run_load {
    const char *part_name, *tool_name;
    btg_part *part;
    int part_number;
    btg_tool tool;
    btg_solver_def solver;
    btg_vec3 low, high; /* footprint: the part's box and a tool's width about it */
    void *workspace;
    size_t workspace_size;
    rng numbers;
    /* where the steps leave their answers, so that they use no stack of the caller's */
    btg_position at, before;
    btg_drop_query drop_query;
    btg_drop_result drop;
    btg_tilt_query tilt_query;
    btg_tilt_result tilt;
    double strip_mm;
} run_load;

/* Sets up number 0 .. RUN_LOADS - 1 in a load that is zeroed or holds another number, whose part is
 * kept where it is the same: allocates, and exits with 2 where that fails. */
void run_load_open(run_load *load, int number);
void run_load_close(run_load *load);

/* The kinds of a step: a position by itself, one after its neighbour, one spun, one short of
 * nodes, DROP and TILT by themselves, and one whose spin is searched for, with its strip. */
#define RUN_KINDS 6

/* Random numbers and queries of the next step: not part of what is measured. */
void run_load_prepare(run_load *load, int kind);
/* The step: run calls only. Returns the last status, an error where one call gave one. */
btg_status run_load_step(run_load *load, int kind);

#endif
