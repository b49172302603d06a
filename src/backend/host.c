/* Fork and join over queries that are each solved alone: threads take chunks from one counter, so
 * which thread solves what changes from run to run, and no result does. */
#define _GNU_SOURCE
#include "backend/internal.h"
#include "core/part.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

/* Queries a thread must have to be worth its start (some 20 us; a query takes 3 us and more). */
#define QUERIES_PER_THREAD 16
/* Largest share taken at once: small enough that all threads end together. */
#define CHUNK_MAX 64

typedef struct host {
    btg_backend_setup setup;
    const btg_host_ops *ops;
    void *data;
    size_t workspace_size;
    uint32_t threads;  /* that can be had: falls when the system refuses to start one */
    uint32_t capacity; /* of the arrays below */
    void **workspaces;
    pthread_t *handles;
    struct worker *workers;
} host;

typedef struct job {
    const host *host;
    const btg_drop_query *drop_queries; /* or NULL, and then: */
    btg_drop_result *drop_results;
    const btg_tilt_query *tilt_queries;
    btg_tilt_result *tilt_results;
    size_t count, chunk;
    atomic_size_t next;
} job;

typedef struct worker {
    job *job;
    void *workspace;
} worker;

static void solve_drop(const job *j, size_t i, void *workspace) {
    const host *h = j->host;
    btg_drop_result result = {0};
    btg_status status = h->ops->drop(&h->setup, h->data, &j->drop_queries[i], workspace,
                                     h->workspace_size, &result);
    if (status < 0) result = (btg_drop_result){.status = status};
    j->drop_results[i] = result;
}

static void solve_tilt(const job *j, size_t i, void *workspace) {
    const host *h = j->host;
    btg_tilt_result result = {0};
    btg_status status = h->ops->tilt(&h->setup, h->data, &j->tilt_queries[i], workspace,
                                     h->workspace_size, &result);
    if (status < 0) result = (btg_tilt_result){.status = status};
    j->tilt_results[i] = result;
}

static void *work(void *argument) {
    worker *w = argument;
    job *j = w->job;
    for (;;) {
        size_t begin = atomic_fetch_add_explicit(&j->next, j->chunk, memory_order_relaxed);
        if (begin >= j->count) return NULL;
        size_t end = j->count - begin < j->chunk ? j->count : begin + j->chunk;
        for (size_t i = begin; i < end; i++) {
            if (j->drop_queries) {
                solve_drop(j, i, w->workspace);
            } else {
                solve_tilt(j, i, w->workspace);
            }
        }
    }
}

static uint32_t share(const host *h, size_t count) {
    size_t useful = (count + QUERIES_PER_THREAD - 1) / QUERIES_PER_THREAD;
    return useful < h->threads ? (uint32_t)useful : h->threads;
}

/* Starts threads 1 .. wanted - 1 with all signals blocked: those belong to the application's own
 * threads. Returns how many there are with the calling one. */
static uint32_t start(host *h, job *j, uint32_t wanted) {
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    uint32_t n = 1;
    while (n < wanted) {
        h->workers[n] = (worker){j, h->workspaces[n]};
        if (pthread_create(&h->handles[n], NULL, work, &h->workers[n]) != 0) break;
        n++;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (n < wanted) h->threads = n;
    return n;
}

static btg_status run(host *h, job *j) {
    uint32_t wanted = share(h, j->count);
    j->host = h;
    j->chunk = j->count / ((size_t)wanted * 8) + 1;
    if (j->chunk > CHUNK_MAX) j->chunk = CHUNK_MAX;
    atomic_init(&j->next, 0);
    uint32_t n = start(h, j, wanted);
    h->workers[0] = (worker){j, h->workspaces[0]};
    work(&h->workers[0]);
    for (uint32_t i = 1; i < n; i++)
        pthread_join(h->handles[i], NULL);
    return BTG_OK;
}

btg_status btg_host_drop(void *state, const btg_drop_query *queries, size_t count,
                         btg_drop_result *results) {
    job j = {.drop_queries = queries, .drop_results = results, .count = count};
    return run(state, &j);
}

btg_status btg_host_tilt(void *state, const btg_tilt_query *queries, size_t count,
                         btg_tilt_result *results) {
    job j = {.tilt_queries = queries, .tilt_results = results, .count = count};
    return run(state, &j);
}

uint32_t btg_host_threads(void *state) {
    return ((const host *)state)->threads;
}

btg_backend_state btg_host_probe(char *device, size_t size) {
    snprintf(device, size, "processor");
    return BTG_BACKEND_READY;
}

/* One workspace is needed; where memory ends before all have one, fewer threads run. */
static btg_status make_room(host *h) {
    const btg_allocator *a = &h->setup.allocator;
    h->workspaces = btg_allocate(a, h->capacity, sizeof *h->workspaces);
    h->handles = btg_allocate(a, h->capacity, sizeof *h->handles);
    h->workers = btg_allocate(a, h->capacity, sizeof *h->workers);
    if (!h->workspaces || !h->handles || !h->workers) return BTG_ERROR_MEMORY;
    memset(h->workspaces, 0, h->capacity * sizeof *h->workspaces);
    while (h->threads < h->capacity) {
        h->workspaces[h->threads] = btg_allocate(a, 1, h->workspace_size);
        if (!h->workspaces[h->threads]) break;
        h->threads++;
    }
    return h->threads > 0 ? BTG_OK : BTG_ERROR_MEMORY;
}

static void dispose(host *h) {
    btg_allocator allocator = h->setup.allocator;
    for (uint32_t i = 0; i < h->threads && h->workspaces; i++) {
        btg_release(&allocator, h->workspaces[i]);
    }
    btg_release(&allocator, h->workspaces);
    btg_release(&allocator, h->handles);
    btg_release(&allocator, h->workers);
    btg_release(&allocator, h);
}

btg_status btg_host_open(const btg_host_ops *ops, const btg_backend_setup *setup, void **state,
                         btg_message *message) {
    host *h = btg_allocate(&setup->allocator, 1, sizeof *h);
    if (!h) return btg_fail(message, BTG_ERROR_MEMORY, "back end: out of memory");
    *h = (host){.setup = *setup, .ops = ops, .capacity = setup->threads};
    h->workspace_size = ops->workspace_size(setup->part);
    btg_status status = make_room(h);
    if (status != BTG_OK) {
        btg_fail(message, status, "back end: out of memory for the workspace (%zu bytes a thread)",
                 h->workspace_size);
    } else if (ops->prepare) {
        status = ops->prepare(&h->setup, &h->data, message);
    }
    if (status != BTG_OK) {
        dispose(h);
        return status;
    }
    *state = h;
    return BTG_OK;
}

void btg_host_close(void *state) {
    host *h = state;
    if (h->ops->release) h->ops->release(&h->setup, h->data);
    dispose(h);
}
