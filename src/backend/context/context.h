/* OpenGL without a window: a core context, 4.3 or later, from OSMesa or from EGL's surfaceless
 * platform, both opened at run time. Apart from what is done with it, so that whoever embeds a back
 * end keeps the context that was current on the thread. Internal. */
#ifndef BTG_BACKEND_CONTEXT_CONTEXT_H
#define BTG_BACKEND_CONTEXT_CONTEXT_H

#include "backend/context/gl.h"
#include "bitangent/bitangent.h"

#include <stdbool.h>

typedef struct btg_context_def {
    const char *provider;       /* "osmesa", "egl"; NULL or "auto": osmesa, else egl */
    const char *osmesa_library; /* to open instead of the system's; NULL: that */
    const char *egl_library;    /* the same */
} btg_context_def;

/* Thread-safety: one thread at a time an object; contexts on several threads are fine. */
typedef struct btg_context btg_context;

/* Makes a context and loads its functions; what was current on this thread stays so. `def` may be
 * NULL. Errors: ERROR_ARGUMENT (unknown provider), ERROR_NO_DEVICE (message: what is missing and
 * what to install), ERROR_MEMORY. */
btg_status btg_context_open(const btg_context_def *def, const btg_allocator *allocator,
                            btg_context **context, btg_message *message);
/* NULL is fine. Must not be entered. */
void btg_context_close(btg_context *context);

/* Makes the context current and remembers what was: GLX, EGL or OSMesa, with its surfaces. Every
 * enter is followed by a leave on the same thread, which puts that back. Pairs of different
 * contexts nest. ERROR_DEVICE: refused; then nothing has changed and there is nothing to leave. */
btg_status btg_context_enter(btg_context *context);
void btg_context_leave(btg_context *context);

/* The functions; to be called between enter and leave. */
const btg_gl *btg_context_gl(const btg_context *context);
/* Has the driver this extension? Any time. */
bool btg_context_extension(const btg_context *context, const char *name);
/* Does it take shaders as SPIR-V? Any time. */
bool btg_context_spirv(const btg_context *context);
/* "osmesa" or "egl". */
const char *btg_context_provider(const btg_context *context);
/* Renderer, driver and version: one line. */
const char *btg_context_name(const btg_context *context);

#endif
