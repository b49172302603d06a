/* What the host has current on a thread. Mesa keeps one current context a thread for GLX, EGL and
 * OSMesa together, but each interface remembers its own and does nothing when asked for what it
 * thinks is current: so each is told to let go before, and asked again after. */
#define _GNU_SOURCE /* RTLD_NOLOAD */
#include "backend/context/provider.h"

#include <dlfcn.h>
#include <string.h>

#define OSMESA_TYPE 0x23

bool btg_library_symbol(void *library, const char *name, void *function) {
    /* A function through a data pointer: POSIX allows it, ISO C has no word for it. */
    void *symbol = dlsym(library, name);
    memcpy(function, &symbol, sizeof symbol);
    return symbol != NULL;
}

/* A library if the host loaded it; dlclose it. */
static void *loaded(const char *name) {
    return dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);
}

static void take_glx(btg_host_current *host) {
    void *library = loaded("libGLX.so.0");
    if (!library) library = loaded("libGL.so.1");
    if (!library) return;
    void *(*context)(void), *(*display)(void);
    unsigned long (*draw)(void), (*read)(void);
    if (btg_library_symbol(library, "glXGetCurrentContext", &context) &&
        btg_library_symbol(library, "glXGetCurrentDisplay", &display) &&
        btg_library_symbol(library, "glXGetCurrentDrawable", &draw) &&
        btg_library_symbol(library, "glXGetCurrentReadDrawable", &read) &&
        btg_library_symbol(library, "glXMakeContextCurrent", &host->glx.bind) &&
        (host->glx.context = context())) {
        host->glx.display = display();
        host->glx.draw = draw();
        host->glx.read = read();
        host->glx.bind(host->glx.display, 0, 0, NULL);
    }
    dlclose(library);
}

static void take_egl(btg_host_current *host) {
    enum { DRAW = 0x3059, READ = 0x305A };
    void *library = loaded("libEGL.so.1");
    if (!library) return;
    void *(*context)(void), *(*display)(void), *(*surface)(int);
    unsigned (*api)(void);
    if (btg_library_symbol(library, "eglGetCurrentContext", &context) &&
        btg_library_symbol(library, "eglGetCurrentDisplay", &display) &&
        btg_library_symbol(library, "eglGetCurrentSurface", &surface) &&
        btg_library_symbol(library, "eglQueryAPI", &api) &&
        btg_library_symbol(library, "eglBindAPI", &host->egl.bind_api) &&
        btg_library_symbol(library, "eglMakeCurrent", &host->egl.bind)) {
        host->egl.api = api();
        host->egl.context = context();
        if (host->egl.context) {
            host->egl.display = display();
            host->egl.draw = surface(DRAW);
            host->egl.read = surface(READ);
            host->egl.bind(host->egl.display, NULL, NULL, NULL);
        }
    }
    dlclose(library);
}

/* After the others: while one of theirs is current, OSMesa takes it for its own. */
static void take_osmesa(btg_host_current *host) {
    void *library = loaded("libOSMesa.so.8");
    if (!library) return;
    void *(*context)(void);
    unsigned char (*buffer)(void *, int *, int *, int *, void **);
    void (*get)(int, int *);
    int format;
    if (btg_library_symbol(library, "OSMesaGetCurrentContext", &context) &&
        btg_library_symbol(library, "OSMesaGetColorBuffer", &buffer) &&
        btg_library_symbol(library, "OSMesaGetIntegerv", &get) &&
        btg_library_symbol(library, "OSMesaMakeCurrent", &host->osmesa.bind) &&
        (host->osmesa.context = context())) {
        buffer(host->osmesa.context, &host->osmesa.width, &host->osmesa.height, &format,
               &host->osmesa.buffer);
        get(OSMESA_TYPE, &host->osmesa.type);
        host->osmesa.bind(NULL, NULL, 0, 0, 0);
    }
    dlclose(library);
}

void btg_host_current_take(btg_host_current *host) {
    memset(host, 0, sizeof *host);
    take_glx(host);
    take_egl(host);
    take_osmesa(host);
}

void btg_host_current_give_back(const btg_host_current *host) {
    if (host->glx.context)
        host->glx.bind(host->glx.display, host->glx.draw, host->glx.read, host->glx.context);
    if (host->egl.api) host->egl.bind_api(host->egl.api);
    if (host->egl.context)
        host->egl.bind(host->egl.display, host->egl.draw, host->egl.read, host->egl.context);
    if (host->osmesa.context)
        host->osmesa.bind(host->osmesa.context, host->osmesa.buffer, (unsigned)host->osmesa.type,
                          host->osmesa.width, host->osmesa.height);
}
