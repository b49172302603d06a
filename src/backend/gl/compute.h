/* A scene in an OpenGL context, and dispatches over it. Internal. */
#ifndef BTG_BACKEND_GL_COMPUTE_H
#define BTG_BACKEND_GL_COMPUTE_H

#include "backend/context/context.h"
#include "backend/device/batch.h"

/* One dispatch in flight. */
typedef struct btg_gl_slot {
    GLuint queries, winners;
    GLsync fence;
} btg_gl_slot;

typedef struct btg_gl_compute {
    btg_context *context;
    const btg_gl *gl;
    GLuint scene, geometry;
    GLuint program[2]; /* by btg_op */
    btg_gl_slot slot[BTG_BATCH_SLOTS];
} btg_gl_compute;

/* All of these between enter and leave of the context. */

void btg_gl_limits(const btg_context *context, btg_device_limits *limits);
/* As the btg_device_ops of those names; c->context is open. On error nothing is left. */
btg_status btg_gl_load(btg_gl_compute *c, const btg_scene *scene, uint32_t capacity, size_t *bytes,
                       btg_message *message);
void btg_gl_unload(btg_gl_compute *c);
btg_status btg_gl_write(btg_gl_compute *c, uint32_t slot, const btg_gpu_query *queries,
                        uint32_t count);
btg_status btg_gl_dispatch(btg_gl_compute *c, uint32_t slot, btg_op op, uint32_t count);
btg_status btg_gl_wait(btg_gl_compute *c, uint32_t slot);
btg_status btg_gl_read(btg_gl_compute *c, uint32_t slot, btg_gpu_winner *winners, uint32_t count);

#endif
