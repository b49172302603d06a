/* OpenGL compute: a device finds the places, the core starts from them and proves its answers. The
 * shaders are vulkan's. */
#include "backend/gl/gl.h"
#include "backend/gl/compute.h"
#include "core/part.h"

#include <stdio.h>

static btg_backend_state probe(char *device, size_t size) {
    const btg_allocator allocator = {0};
    btg_context *context = NULL;
    btg_message message = {""};
    btg_device_limits limits = {0, 0};
    btg_status status = btg_context_open(NULL, &allocator, &context, &message);
    if (status == BTG_OK) status = btg_context_enter(context);
    if (status == BTG_OK) {
        btg_gl_limits(context, &limits);
        btg_context_leave(context);
    }
    if (status == BTG_OK)
        snprintf(
            device, size, "%.150s; shaders as %s; by %s; %zu MB a buffer, %lu positions a dispatch",
            btg_context_name(context), btg_context_spirv(context) ? "SPIR-V" : "GLSL",
            btg_context_provider(context), limits.buffer_bytes >> 20, (unsigned long)limits.groups);
    else
        snprintf(device, size, "%s", message.text);
    btg_context_close(context);
    return status == BTG_OK ? BTG_BACKEND_READY : BTG_BACKEND_NO_DEVICE;
}

/* ---- a device as the batches use it ------------------------------------------------------- */

typedef struct state {
    btg_gl_compute compute;
    btg_gl_debug debug;
    btg_allocator allocator;
} state;

static void stop(void *device) {
    state *s = device;
    btg_context *context = s->compute.context;
    if (context && btg_context_enter(context) == BTG_OK) {
        btg_gl_unload(&s->compute);
        btg_context_leave(context);
    }
    btg_context_close(context);
    btg_allocator allocator = s->allocator;
    btg_release(&allocator, s);
}

static void APIENTRY hear(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                          const GLchar *text, const void *user) {
    const state *s = user;
    (void)source, (void)id, (void)severity, (void)length;
    bool fault = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR ||
                 type == GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR || type == GL_DEBUG_TYPE_PORTABILITY;
    if (fault) s->debug.report(text, s->debug.user);
}

static void listen(state *s, const btg_gl_debug *debug) {
    const btg_gl *gl = btg_context_gl(s->compute.context);
    s->debug = *debug;
    gl->Enable(GL_DEBUG_OUTPUT);
    gl->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    gl->DebugMessageCallback(hear, s);
}

static btg_status begin(state *s, const btg_gl_def *def, btg_device_limits *limits,
                        btg_message *message) {
    btg_gl_compute *c = &s->compute;
    btg_status status = btg_context_open(&def->context, &s->allocator, &c->context, message);
    if (status != BTG_OK) return status;
    status = btg_context_enter(c->context);
    if (status != BTG_OK) return btg_fail(message, status, "gl: the context is refused");
    if (def->debug) listen(s, def->debug);
    btg_gl_limits(c->context, limits);
    btg_context_leave(c->context);
    return BTG_OK;
}

static btg_status start(const btg_backend_setup *setup, const void *def, void **device,
                        btg_device_limits *limits, btg_message *message) {
    state *s = btg_allocate(&setup->allocator, 1, sizeof *s);
    if (!s) return btg_fail(message, BTG_ERROR_MEMORY, "gl: out of memory");
    *s = (state){.allocator = setup->allocator};
    const btg_gl_def named = {.context = {.provider = setup->gl_context}};
    btg_status status = begin(s, def ? def : &named, limits, message);
    if (status != BTG_OK)
        stop(s);
    else
        *device = s;
    return status;
}

static btg_status load(void *device, const btg_scene *scene, uint32_t capacity, size_t *bytes,
                       btg_message *message) {
    btg_gl_compute *c = &((state *)device)->compute;
    btg_status status = btg_context_enter(c->context);
    if (status != BTG_OK) return btg_fail(message, status, "gl: the context is refused");
    status = btg_gl_load(c, scene, capacity, bytes, message);
    btg_context_leave(c->context);
    return status;
}

static btg_status write(void *device, uint32_t slot, const btg_gpu_query *queries, uint32_t count) {
    btg_gl_compute *c = &((state *)device)->compute;
    btg_status status = btg_context_enter(c->context);
    if (status != BTG_OK) return status;
    status = btg_gl_write(c, slot, queries, count);
    btg_context_leave(c->context);
    return status;
}

static btg_status dispatch(void *device, uint32_t slot, btg_op op, uint32_t count) {
    btg_gl_compute *c = &((state *)device)->compute;
    btg_status status = btg_context_enter(c->context);
    if (status != BTG_OK) return status;
    status = btg_gl_dispatch(c, slot, op, count);
    btg_context_leave(c->context);
    return status;
}

static btg_status wait(void *device, uint32_t slot) {
    btg_gl_compute *c = &((state *)device)->compute;
    btg_status status = btg_context_enter(c->context);
    if (status != BTG_OK) return status;
    status = btg_gl_wait(c, slot);
    btg_context_leave(c->context);
    return status;
}

static btg_status read(void *device, uint32_t slot, btg_gpu_winner *winners, uint32_t count) {
    btg_gl_compute *c = &((state *)device)->compute;
    btg_status status = btg_context_enter(c->context);
    if (status != BTG_OK) return status;
    status = btg_gl_read(c, slot, winners, count);
    btg_context_leave(c->context);
    return status;
}

static const btg_device_ops ops = {.name = "gl",
                                   .start = start,
                                   .load = load,
                                   .write = write,
                                   .dispatch = dispatch,
                                   .wait = wait,
                                   .read = read,
                                   .stop = stop};

/* ---- table -------------------------------------------------------------------------------- */

btg_status btg_gl_open_with(const btg_gl_def *def, uint32_t dispatch,
                            const btg_backend_setup *setup, void **opened, btg_message *message) {
    return btg_batch_open(&ops, def, dispatch, setup, opened, message);
}

static btg_status open(const btg_backend_setup *setup, void **opened, btg_message *message) {
    return btg_gl_open_with(NULL, 0, setup, opened, message);
}

const btg_backend_table btg_backend_gl = {
    .name = "gl",
    .summary = "DROP and TILT by OpenGL compute: searched in single precision on the device, "
               "polished and proven in double",
    .probe = probe,
    .open = open,
    .close = btg_batch_close,
    .drop = btg_batch_drop,
    .tilt = btg_batch_tilt,
    .threads = btg_batch_threads,
    .times = btg_batch_times,
    .block = BTG_BATCH_BLOCK,
};
