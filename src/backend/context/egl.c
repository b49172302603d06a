/* Contexts from EGL without a surface (EGL_MESA_platform_surfaceless): a graphics card's driver, or
 * Mesa on the processor. */
#include "backend/context/provider.h"
#include "core/part.h"

#include <string.h>

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#define EGL_FUNCTIONS(X)                                                                           \
    X(GetProcAddress, GETPROCADDRESS)                                                              \
    X(QueryString, QUERYSTRING)                                                                    \
    X(Initialize, INITIALIZE)                                                                      \
    X(BindAPI, BINDAPI)                                                                            \
    X(CreateContext, CREATECONTEXT)                                                                \
    X(DestroyContext, DESTROYCONTEXT)                                                              \
    X(MakeCurrent, MAKECURRENT)                                                                    \
    X(GetError, GETERROR)

typedef struct egl {
    btg_allocator allocator;
#define MEMBER(name, NAME) PFNEGL##NAME##PROC name;
    EGL_FUNCTIONS(MEMBER)
#undef MEMBER
    EGLDisplay display;
    EGLContext context;
} egl;

static bool bind(void *made) {
    egl *e = made;
    return e->BindAPI(EGL_OPENGL_API) &&
           e->MakeCurrent(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE, e->context);
}

static void unbind(void *made) {
    egl *e = made;
    e->MakeCurrent(e->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

/* The display is the process's: the host may use it too, so it stays initialised. */
static void end(void *made) {
    egl *e = made;
    btg_allocator allocator = e->allocator;
    if (e->context) e->DestroyContext(e->display, e->context);
    btg_release(&allocator, e);
}

static btg_context_function function(void *made, const char *name) {
    const egl *e = made;
    return (btg_context_function)e->GetProcAddress(name);
}

static bool load(egl *e, void *library) {
#define LOAD(name, NAME)                                                                           \
    if (!btg_library_symbol(library, "egl" #name, &e->name)) return false;
    EGL_FUNCTIONS(LOAD)
#undef LOAD
    return true;
}

/* A whole word of a list. */
static bool lists(const char *list, const char *word) {
    size_t length = strlen(word);
    for (const char *at = list; at && (at = strstr(at, word)); at += length) {
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
    }
    return false;
}

static btg_status open_display(egl *e, btg_message *message) {
    const char *client = e->QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    PFNEGLGETPLATFORMDISPLAYEXTPROC get =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)e->GetProcAddress("eglGetPlatformDisplayEXT");
    if (!lists(client, "EGL_MESA_platform_surfaceless") || !get) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "egl: no EGL_MESA_platform_surfaceless; a driver is missing (Debian: "
                        "libegl-mesa0)");
    }
    e->display = get(EGL_PLATFORM_SURFACELESS_MESA, (void *)EGL_DEFAULT_DISPLAY, NULL);
    if (e->display == EGL_NO_DISPLAY || !e->Initialize(e->display, NULL, NULL)) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "egl: the display without a surface does not start (EGL error 0x%x); a "
                        "driver is missing (Debian: libgl1-mesa-dri)",
                        (unsigned)e->GetError());
    }
    return BTG_OK;
}

static btg_status make_context(egl *e, btg_message *message) {
    static const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                        4,
                                        EGL_CONTEXT_MINOR_VERSION,
                                        3,
                                        EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                        EGL_NONE};
    const char *has = e->QueryString(e->display, EGL_EXTENSIONS);
    if (!lists(has, "EGL_KHR_no_config_context") || !lists(has, "EGL_KHR_surfaceless_context")) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "egl: the driver makes no contexts without a surface; another is needed");
    }
    if (e->BindAPI(EGL_OPENGL_API))
        e->context = e->CreateContext(e->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (e->context) return BTG_OK;
    return btg_fail(message, BTG_ERROR_NO_DEVICE,
                    "egl: no OpenGL 4.3 core context (EGL error 0x%x); a newer driver has it",
                    (unsigned)e->GetError());
}

static btg_status make(void *library, const btg_allocator *allocator, void **made,
                       btg_message *message) {
    egl *e = btg_allocate(allocator, 1, sizeof *e);
    if (!e) return btg_fail(message, BTG_ERROR_MEMORY, "egl: out of memory");
    *e = (egl){.allocator = *allocator};
    btg_status status = BTG_OK;
    if (!load(e, library))
        status = btg_fail(message, BTG_ERROR_NO_DEVICE, "egl: the library is no EGL 1.4");
    if (status == BTG_OK) status = open_display(e, message);
    if (status == BTG_OK) status = make_context(e, message);
    if (status == BTG_OK)
        *made = e;
    else
        end(e);
    return status;
}

const btg_context_provider_table btg_context_egl = {
    .name = "egl",
    .library = "libEGL.so.1",
    .package = "libegl1",
    .make = make,
    .bind = bind,
    .unbind = unbind,
    .end = end,
    .function = function,
};
