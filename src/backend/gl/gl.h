/* The gl back end as its tests see it. Internal. */
#ifndef BTG_BACKEND_GL_GL_H
#define BTG_BACKEND_GL_GL_H

#include "backend/context/context.h"
#include "backend/internal.h"

/* Hears what the driver has to say of errors and of undefined or deprecated use. */
typedef struct btg_gl_debug {
    void (*report)(const char *text, void *user);
    void *user;
} btg_gl_debug;

typedef struct btg_gl_def {
    btg_context_def context;
    const btg_gl_debug *debug; /* NULL: nobody; `user` stays until close */
} btg_gl_def;

/* As btg_backend_gl.open, in a context of that kind; NULL: any. `dispatch`: queries at once at the
 * most; 0: the usual. */
btg_status btg_gl_open_with(const btg_gl_def *def, uint32_t dispatch,
                            const btg_backend_setup *setup, void **state, btg_message *message);

#endif
