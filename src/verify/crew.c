/* Threads that share work by one counter: which thread does what changes, and no result does. */
#define _GNU_SOURCE
#include "verify/internal.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <unistd.h>

#define THREADS_MAX 64

typedef struct crew {
    void (*work)(void *job, size_t i, uint32_t thread);
    void *job;
    size_t count;
    atomic_size_t next;
} crew;

typedef struct member {
    crew *crew;
    uint32_t thread;
} member;

static void *run(void *argument) {
    member *m = argument;
    crew *c = m->crew;
    for (;;) {
        size_t i = atomic_fetch_add_explicit(&c->next, 1, memory_order_relaxed);
        if (i >= c->count) return NULL;
        c->work(c->job, i, m->thread);
    }
}

uint32_t btg_crew_threads(uint32_t wanted) {
    long have = sysconf(_SC_NPROCESSORS_ONLN);
    if (wanted == 0) wanted = have > 0 ? (uint32_t)(have < THREADS_MAX ? have : THREADS_MAX) : 1;
    return wanted < THREADS_MAX ? wanted : THREADS_MAX;
}

void btg_crew_run(uint32_t threads, size_t count,
                  void (*work)(void *job, size_t i, uint32_t thread), void *job) {
    crew c = {.work = work, .job = job, .count = count};
    member members[THREADS_MAX];
    pthread_t handles[THREADS_MAX];
    sigset_t all, before;
    uint32_t n = 1;
    atomic_init(&c.next, 0);
    /* Signals belong to the application's own threads. */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    for (; n < threads && n < count; n++) {
        members[n] = (member){&c, n};
        if (pthread_create(&handles[n], NULL, run, &members[n]) != 0) break;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    members[0] = (member){&c, 0};
    run(&members[0]);
    for (uint32_t i = 1; i < n; i++)
        pthread_join(handles[i], NULL);
}
