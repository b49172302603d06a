#define _GNU_SOURCE /* RTLD_NODELETE */
#include "backend/context/context.h"
#include "backend/context/provider.h"
#include "core/part.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

struct btg_context {
    btg_allocator allocator;
    const btg_context_provider_table *provider;
    void *made;
    btg_gl gl;
    int version;           /* 10 major + minor */
    btg_host_current host; /* while entered */
    char name[160];
    char *extensions; /* each between two blanks */
};

/* ---- in and out --------------------------------------------------------------------------- */

btg_status btg_context_enter(btg_context *c) {
    btg_host_current_take(&c->host);
    if (c->provider->bind(c->made)) return BTG_OK;
    btg_host_current_give_back(&c->host);
    return BTG_ERROR_DEVICE;
}

void btg_context_leave(btg_context *c) {
    c->provider->unbind(c->made);
    btg_host_current_give_back(&c->host);
}

/* ---- opening ------------------------------------------------------------------------------ */

static bool load_functions(btg_context *c) {
    btg_context_function f;
    bool all = true;
#define LOAD(name, NAME)                                                                           \
    f = c->provider->function(c->made, "gl" #name);                                                \
    c->gl.name = (PFNGL##NAME##PROC)f;                                                             \
    all = all && f;
    BTG_GL(LOAD)
#undef LOAD
    return all;
}

static GLenum APIENTRY no_reset(void) {
    return GL_NO_ERROR;
}

/* What later versions or extensions have; named as the one that is there names it. */
static void load_extras(btg_context *c) {
    btg_context_function f = (btg_context_function)no_reset;
    if (c->version >= 45)
        f = c->provider->function(c->made, "glGetGraphicsResetStatus");
    else if (btg_context_extension(c, "GL_ARB_robustness"))
        f = c->provider->function(c->made, "glGetGraphicsResetStatusARB");
    c->gl.GetGraphicsResetStatus = (PFNGLGETGRAPHICSRESETSTATUSARBPROC)f;
    f = c->provider->function(c->made,
                              c->version >= 46 ? "glSpecializeShader" : "glSpecializeShaderARB");
    c->gl.SpecializeShaderARB = (PFNGLSPECIALIZESHADERARBPROC)f;
}

static const char *extension(const btg_context *c, GLint i) {
    return (const char *)c->gl.GetStringi(GL_EXTENSIONS, (GLuint)i);
}

static bool read_extensions(btg_context *c) {
    GLint count = 0;
    size_t size = 2;
    c->gl.GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; i++)
        size += strlen(extension(c, i)) + 1;
    c->extensions = btg_allocate(&c->allocator, size, 1);
    if (!c->extensions) return false;
    char *at = c->extensions;
    *at++ = ' ';
    for (GLint i = 0; i < count; i++) {
        size_t length = strlen(extension(c, i));
        memcpy(at, extension(c, i), length);
        at += length;
        *at++ = ' ';
    }
    *at = '\0';
    return true;
}

/* What a context that is current tells of itself. */
static btg_status describe(btg_context *c, btg_message *message) {
    GLint major = 0, minor = 0;
    if (!load_functions(c)) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE, "%s: functions of OpenGL 4.3 are missing",
                        c->provider->name);
    }
    /* Addresses prove nothing: there is a stub for any name. */
    c->gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    c->gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    c->version = 10 * (int)major + (int)minor;
    if (c->version < 43) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "%s: OpenGL %d.%d; 4.3 is needed, a newer driver has it", c->provider->name,
                        (int)major, (int)minor);
    }
    snprintf(c->name, sizeof c->name, "%.80s; OpenGL %.70s",
             (const char *)c->gl.GetString(GL_RENDERER), (const char *)c->gl.GetString(GL_VERSION));
    if (!read_extensions(c))
        return btg_fail(message, BTG_ERROR_MEMORY, "%s: out of memory", c->provider->name);
    load_extras(c);
    return BTG_OK;
}

static btg_status fill(btg_context *c, void *library, btg_message *message) {
    btg_status status = c->provider->make(library, &c->allocator, &c->made, message);
    if (status != BTG_OK) return status;
    if (!c->provider->bind(c->made)) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE, "%s: the new context cannot be made current",
                        c->provider->name);
    }
    status = describe(c, message);
    c->provider->unbind(c->made);
    return status;
}

/* With nothing current. */
static void dispose(btg_context *c) {
    btg_allocator allocator = c->allocator;
    if (c->made) c->provider->end(c->made);
    btg_release(&allocator, c->extensions);
    btg_release(&allocator, c);
}

static btg_status open_with(const btg_context_provider_table *provider, const char *name,
                            const btg_allocator *allocator, btg_context **context,
                            btg_message *message) {
    if (!name) name = provider->library;
    /* Stays: drivers bring a compiler, take long to load and leave memory behind when they go. */
    void *library = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!library) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "%s: %.64s cannot be opened; install it (Debian: %s)", provider->name, name,
                        provider->package);
    }
    btg_status status = BTG_ERROR_MEMORY;
    btg_context *c = btg_allocate(allocator, 1, sizeof *c);
    if (!c) {
        btg_fail(message, status, "%s: out of memory", provider->name);
    } else {
        *c = (btg_context){.allocator = *allocator, .provider = provider};
        btg_host_current host;
        btg_host_current_take(&host);
        status = fill(c, library, message);
        if (status == BTG_OK)
            *context = c;
        else
            dispose(c);
        btg_host_current_give_back(&host);
    }
    dlclose(library);
    return status;
}

btg_status btg_context_open(const btg_context_def *def, const btg_allocator *allocator,
                            btg_context **context, btg_message *message) {
    const btg_context_def none = {0};
    if (!def) def = &none;
    bool any = !def->provider || strcmp(def->provider, "auto") == 0;
    bool osmesa = any || strcmp(def->provider, "osmesa") == 0;
    bool egl = any || strcmp(def->provider, "egl") == 0;
    btg_message first = {""}, second = {""};
    btg_status status = BTG_ERROR_ARGUMENT;
    if (!osmesa && !egl) {
        return btg_fail(message, status,
                        "unknown provider of OpenGL contexts '%.64s'; known are "
                        "auto, osmesa, egl",
                        def->provider);
    }
    if (osmesa)
        status = open_with(&btg_context_osmesa, def->osmesa_library, allocator, context, &first);
    if (egl && status != BTG_OK)
        status = open_with(&btg_context_egl, def->egl_library, allocator, context, &second);
    if (status == BTG_OK) return status;
    return btg_fail(message, status, "no OpenGL without a window: %.200s%s%.200s", first.text,
                    first.text[0] && second.text[0] ? "; " : "", second.text);
}

void btg_context_close(btg_context *c) {
    if (!c) return;
    btg_host_current host;
    btg_host_current_take(&host);
    dispose(c);
    btg_host_current_give_back(&host);
}

/* ---- what there is ------------------------------------------------------------------------ */

const btg_gl *btg_context_gl(const btg_context *c) {
    return &c->gl;
}

bool btg_context_extension(const btg_context *c, const char *name) {
    char word[96];
    int n = snprintf(word, sizeof word, " %s ", name);
    return n > 0 && (size_t)n < sizeof word && strstr(c->extensions, word);
}

bool btg_context_spirv(const btg_context *c) {
    return c->version >= 46 || btg_context_extension(c, "GL_ARB_gl_spirv");
}

const char *btg_context_provider(const btg_context *c) {
    return c->provider->name;
}

const char *btg_context_name(const btg_context *c) {
    return c->name;
}
