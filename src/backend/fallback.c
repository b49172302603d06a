/* `auto`: the first back end that is ready; when its device fails the next one goes on, and the
 * caller is told. */
#include "backend/internal.h"
#include "core/part.h"

#include <stdio.h>
#include <string.h>

typedef struct fallback {
    btg_backend_setup setup;
    btg_fallback_def def;
    uint32_t tried; /* bits, by place in def.tables */
    const btg_backend_table *table;
    void *state; /* of the table; NULL: all have failed */
    btg_status failed;
    char note[256];
} fallback;

static void add_note(fallback *f, const char *name, const char *why) {
    size_t used = strlen(f->note);
    snprintf(f->note + used, sizeof f->note - used, "%s%s: %.120s", used > 0 ? "; " : "", name,
             why);
}

static const btg_backend_table *next_table(fallback *f) {
    size_t pick = f->def.count;
    for (size_t i = f->def.count; i-- > 0;) {
        if (f->tried >> i & 1) continue;
        if (pick == f->def.count || f->def.tables[pick] != f->def.first) pick = i;
    }
    if (pick == f->def.count) return NULL;
    f->tried |= 1u << pick;
    return f->def.tables[pick];
}

/* Opens the next that is ready and opens. What was asked for by name, or had a device, is told of
 * when it does not. */
static btg_status start(fallback *f, btg_message *message) {
    const btg_backend_table *table;
    while ((table = next_table(f))) {
        btg_message why = {""};
        btg_backend_state state =
            table->probe ? table->probe(why.text, sizeof why.text) : BTG_BACKEND_NOT_BUILT;
        if (state != BTG_BACKEND_READY) {
            const char *text = why.text[0] ? why.text : "not built into this version";
            if (table == f->def.first) add_note(f, table->name, text);
            continue;
        }
        void *opened = NULL;
        btg_status status = table->open(&f->setup, &opened, &why);
        if (status == BTG_ERROR_ARGUMENT) {
            if (message) *message = why;
            return status;
        }
        if (status != BTG_OK) {
            add_note(f, table->name, why.text);
            continue;
        }
        f->table = table;
        f->state = opened;
        return BTG_OK;
    }
    return btg_fail(message, BTG_ERROR_NO_DEVICE, "no back end is ready here%s%s",
                    f->note[0] ? ": " : "", f->note);
}

static const char *word_of(btg_status status) {
    return status == BTG_ERROR_MEMORY ? "the device ran out of memory"
                                      : "the device was lost, or did not answer in time";
}

/* Whether another one takes over; `status` is what the one before returned. */
static bool go_on(fallback *f, btg_status status) {
    f->failed = status;
    if (status != BTG_ERROR_DEVICE && status != BTG_ERROR_MEMORY) return false;
    add_note(f, f->table->name, word_of(status));
    f->table->close(f->state);
    f->state = NULL;
    return start(f, NULL) == BTG_OK;
}

static void close(void *state) {
    fallback *f = state;
    if (f->state) f->table->close(f->state);
    btg_allocator allocator = f->setup.allocator;
    btg_release(&allocator, f);
}

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    fallback *f = btg_allocate(&setup->allocator, 1, sizeof *f);
    if (!f) return btg_fail(message, BTG_ERROR_MEMORY, "back end: out of memory");
    *f = (fallback){.setup = *setup, .def = *(const btg_fallback_def *)setup->user};
    f->setup.user = NULL;
    btg_status status = start(f, message);
    if (status != BTG_OK)
        close(f);
    else
        *state = f;
    return status;
}

static btg_status drop(void *state, const btg_drop_query *queries, size_t count,
                       btg_drop_result *results) {
    fallback *f = state;
    while (f->state) {
        btg_status status = f->table->drop(f->state, queries, count, results);
        if (status >= 0 || !go_on(f, status)) return status;
    }
    return f->failed;
}

static btg_status tilt(void *state, const btg_tilt_query *queries, size_t count,
                       btg_tilt_result *results) {
    fallback *f = state;
    while (f->state) {
        btg_status status = f->table->tilt(f->state, queries, count, results);
        if (status >= 0 || !go_on(f, status)) return status;
    }
    return f->failed;
}

static uint32_t threads(void *state) {
    const fallback *f = state;
    return f->state && f->table->threads ? f->table->threads(f->state) : 1;
}

static void times(void *state, btg_backend_times *out) {
    const fallback *f = state;
    if (f->state && f->table->times) f->table->times(f->state, out);
}

static const char *ran(void *state) {
    return ((const fallback *)state)->table->name;
}

static const char *note(void *state) {
    return ((const fallback *)state)->note;
}

const btg_backend_table btg_backend_fallback = {
    .name = "auto",
    .summary = "the first that is ready",
    .probe = btg_host_probe,
    .open = open,
    .close = close,
    .drop = drop,
    .tilt = tilt,
    .threads = threads,
    .times = times,
    .ran = ran,
    .note = note,
    .guesses = true,
};
