/* How much stack the run phase uses: a thread's stack is painted, positions are solved, and the
 * deepest byte that changed is looked for. The functions of libm that it calls count too. */
#define _GNU_SOURCE /* for pthread_attr_setstack, MAP_ANONYMOUS */
#include "run_load.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* Most bytes of stack a run call may use, its callees' included. gcc and clang make 1.8 KB of it on
 * x86-64, for every kind of vectors, and gcc 1.9 KB on arm64. 32-bit arm has no vectors of doubles:
 * 2.8 KB. */
#if defined(__x86_64__) || defined(__aarch64__)
#define RUN_STACK_MAX_BYTES 2048
#else
#define RUN_STACK_MAX_BYTES 3100
#endif

#define STEPS_PER_LOAD 60 /* of each kind */
#define STACK_BYTES    ((size_t)1 << 20)
#define PAINT          0xa5
/* Painting starts this far below the painter's own frame. */
#define FRAME_BYTES 256

typedef struct probe {
    unsigned char *bottom; /* of the thread's stack, which grows down to it */
    run_load *load;
    size_t deepest;
    int deepest_kind, errors;
    bool control; /* measure a function of known depth instead */
} probe;

#define CONTROL_BYTES 6000

__attribute__((noinline)) static int uses_much(void) {
    volatile unsigned char block[CONTROL_BYTES];
    for (size_t i = 0; i < sizeof block; i++)
        block[i] = 0;
    return block[0];
}

__attribute__((noinline)) static void paint(unsigned char *from, size_t count) {
    memset(from, PAINT, count);
}

/* Depth below this frame, which itself is some 50 bytes: counted in favour of the limit. */
__attribute__((noinline)) static size_t depth_of_step(probe *p, int kind) {
    unsigned char *here = __builtin_frame_address(0);
    size_t room = (size_t)(here - p->bottom);
    paint(p->bottom, room - FRAME_BYTES);
    if (p->control)
        p->errors += uses_much();
    else
        p->errors += run_load_step(p->load, kind) < 0;
    size_t untouched = 0;
    while (untouched < room - FRAME_BYTES && p->bottom[untouched] == PAINT)
        untouched++;
    return room - untouched;
}

static void *measure(void *user) {
    probe *p = user;
    const char *quick = getenv("BTG_TEST_QUICK");
    int each = quick && *quick && *quick != '0' ? STEPS_PER_LOAD / 10 : STEPS_PER_LOAD;
    int steps = p->control ? 1 : each * RUN_KINDS;
    for (int i = 0; i < steps; i++) {
        if (!p->control) run_load_prepare(p->load, i % RUN_KINDS);
        size_t depth = depth_of_step(p, i % RUN_KINDS);
        if (depth <= p->deepest) continue;
        p->deepest = depth;
        p->deepest_kind = i % RUN_KINDS;
    }
    return NULL;
}

static void on_thread(probe *p) {
    pthread_attr_t attributes;
    pthread_t thread;
    if (pthread_attr_init(&attributes) != 0 ||
        pthread_attr_setstack(&attributes, p->bottom, STACK_BYTES) != 0 ||
        pthread_create(&thread, &attributes, measure, p) != 0 || pthread_join(thread, NULL) != 0) {
        fprintf(stderr, "no thread on a stack of our own\n");
        exit(2);
    }
    pthread_attr_destroy(&attributes);
}

int main(void) {
#ifdef SANITIZED
    printf("left out: a sanitizer widens every frame\n");
    return EXIT_SKIPPED;
#endif
#ifndef __OPTIMIZE__
    printf("left out: without optimization frames are wider\n");
    return EXIT_SKIPPED;
#endif
    unsigned char *stack =
        mmap(NULL, STACK_BYTES, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (stack == MAP_FAILED) return 2;
    probe known = {.bottom = stack, .control = true};
    on_thread(&known);
    int bad = known.deepest < CONTROL_BYTES || known.deepest > CONTROL_BYTES + 512;
    if (bad)
        fprintf(stderr, "%d bytes of a known function measured as %zu\n", CONTROL_BYTES,
                known.deepest);
    probe worst = {0};
    run_load worst_load = {0};
    run_load load = {0};
    for (int i = 0; i < RUN_LOADS; i++) {
        run_load_open(&load, i);
        probe p = {.bottom = stack, .load = &load};
        on_thread(&p);
        if (p.errors > 0) {
            fprintf(stderr, "%s with %s: %d errors\n", load.part_name, load.tool_name, p.errors);
            bad = 1;
        }
        if (p.deepest > worst.deepest) {
            worst = p;
            worst_load = load;
        }
    }
    run_load_close(&load);
    printf("deepest: %zu bytes of stack (%s with %s, step %d); limit %d\n", worst.deepest,
           worst_load.part_name, worst_load.tool_name, worst.deepest_kind, RUN_STACK_MAX_BYTES);
    if (worst.deepest > RUN_STACK_MAX_BYTES) {
        fprintf(stderr, "the run phase uses %zu bytes of stack, more than %d\n", worst.deepest,
                RUN_STACK_MAX_BYTES);
        bad = 1;
    }
    return bad;
}
