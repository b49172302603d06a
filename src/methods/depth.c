/* depth: the tool dropped by depth buffers, and the part turned about the pseudo-insert until the
 * drop is the first one again (turn.c): M. Singh, S. Bedi, S. Mann, "A GPU Method and Error
 * Analysis of Multi-Point Positioning of a Toroidal Tool for 5-Axis Machining", 2024. It needs
 * nothing but DROP, and so runs on any back end: one that has a rasteriser drops by depth buffers,
 * `cpu` and `reference` exactly; or, when a window is asked for, by a ray a pixel (pixels.c). */
#include "methods/internal.h"

#include <string.h>

/* Heights closer than this are the same: above the rounding of a back end's polished drop. */
#define SAME_HEIGHT_MM 1e-6
/* Of a device's own answers in single precision: a pixel's error (the paper's equation 2). */
#define SAME_HEIGHT_RAW_MM 5e-3

typedef struct depth {
    btg_backend_setup setup;
    const btg_method_context *context;
    btg_pixels pixels; /* `under` NULL: a back end drops */
} depth;

static void close(void *state) {
    depth *d = state;
    btg_allocator allocator = d->setup.allocator;
    btg_under_destroy(d->pixels.under);
    btg_release(&allocator, d);
}

static bool is_host(const btg_backend *b) {
    const char *name = btg_backend_name(b);
    return strcmp(name, "cpu") == 0 || strcmp(name, "reference") == 0;
}

static btg_status open(const btg_backend_setup *setup, void **state, btg_message *message) {
    const btg_method_context *context = btg_method_context_of(setup);
    depth *d = btg_allocate(&setup->allocator, 1, sizeof *d);
    if (!d) return btg_fail(message, BTG_ERROR_MEMORY, "method depth: out of memory");
    *d = (depth){.setup = *setup, .context = context};
    if (context->def->window > 0 && is_host(context->inner)) {
        d->pixels = (btg_pixels){&d->setup, NULL, context->def->window, context->def->levels};
        btg_status status =
            btg_under_create(setup, "depth with a window", false, &d->pixels.under, message);
        if (status != BTG_OK) {
            close(d);
            return status;
        }
    }
    *state = d;
    return BTG_OK;
}

static btg_status inner_drop(void *user, const btg_drop_query *queries, size_t count,
                             btg_drop_result *results) {
    depth *d = user;
    if (d->pixels.under) return btg_pixels_drop(&d->pixels, queries, count, results);
    return btg_backend_drop(d->context->inner, queries, count, results, NULL);
}

static btg_status drop(void *state, const btg_drop_query *queries, size_t count,
                       btg_drop_result *results) {
    depth *d = state;
    d->context->counts->drops += count;
    return inner_drop(d, queries, count, results);
}

/* A sampled rest is lower than the true one, by up to the sagitta of a pixel; another sample of it
 * may be higher by that, and is no second contact. */
static double same_height(const depth *d) {
    double pitch = d->pixels.under ? btg_pixels_pitch(&d->pixels) : 0;
    double pixel = pitch * pitch / (2 * d->setup.tool.element[0].corner_radius_mm);
    double same = d->setup.raw ? SAME_HEIGHT_RAW_MM : SAME_HEIGHT_MM;
    return fmax(same, pixel);
}

static btg_status tilt(void *state, const btg_tilt_query *queries, size_t count,
                       btg_tilt_result *results) {
    depth *d = state;
    btg_turn turn = {&d->setup, inner_drop, d, same_height(d)};
    d->context->counts->tilts += count;
    return btg_turn_tilt(&turn, queries, count, results);
}

const btg_backend_table btg_method_depth = {
    .name = "depth",
    .summary = "drops of a back end, and the part turned until the drop is the same again",
    .open = open,
    .close = close,
    .drop = drop,
    .tilt = tilt};
