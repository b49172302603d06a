/* Contexts from OSMesa, Mesa's rendering on the processor into memory (up to Mesa 25.0). Its few
 * functions are declared here: the headers went with it. */
#include "backend/context/provider.h"
#include "core/part.h"

#include <GL/glcorearb.h>

#define OSMESA_FORMAT                0x22
#define OSMESA_DEPTH_BITS            0x30
#define OSMESA_STENCIL_BITS          0x31
#define OSMESA_ACCUM_BITS            0x32
#define OSMESA_PROFILE               0x33
#define OSMESA_CORE_PROFILE          0x34
#define OSMESA_CONTEXT_MAJOR_VERSION 0x36
#define OSMESA_CONTEXT_MINOR_VERSION 0x37

typedef struct osmesa {
    btg_allocator allocator;
    void *context;
    void *(*create)(const int *attributes, void *share);
    unsigned char (*bind)(void *context, void *buffer, unsigned type, int width, int height);
    void (*destroy)(void *context);
    btg_context_function (*function)(const char *name);
    uint32_t pixel; /* a buffer there must be; all work goes to framebuffer objects */
} osmesa;

static bool bind(void *made) {
    osmesa *o = made;
    return o->bind(o->context, &o->pixel, GL_UNSIGNED_BYTE, 1, 1);
}

static void unbind(void *made) {
    osmesa *o = made;
    o->bind(NULL, NULL, GL_UNSIGNED_BYTE, 0, 0);
}

static void end(void *made) {
    osmesa *o = made;
    btg_allocator allocator = o->allocator;
    if (o->context) o->destroy(o->context);
    btg_release(&allocator, o);
}

static btg_context_function function(void *made, const char *name) {
    const osmesa *o = made;
    return o->function(name);
}

static btg_status make(void *library, const btg_allocator *allocator, void **made,
                       btg_message *message) {
    static const int attributes[] = {OSMESA_FORMAT,
                                     GL_RGBA,
                                     OSMESA_DEPTH_BITS,
                                     0,
                                     OSMESA_STENCIL_BITS,
                                     0,
                                     OSMESA_ACCUM_BITS,
                                     0,
                                     OSMESA_PROFILE,
                                     OSMESA_CORE_PROFILE,
                                     OSMESA_CONTEXT_MAJOR_VERSION,
                                     4,
                                     OSMESA_CONTEXT_MINOR_VERSION,
                                     3,
                                     0};
    osmesa *o = btg_allocate(allocator, 1, sizeof *o);
    if (!o) return btg_fail(message, BTG_ERROR_MEMORY, "osmesa: out of memory");
    *o = (osmesa){.allocator = *allocator};
    if (!btg_library_symbol(library, "OSMesaCreateContextAttribs", &o->create) ||
        !btg_library_symbol(library, "OSMesaMakeCurrent", &o->bind) ||
        !btg_library_symbol(library, "OSMesaDestroyContext", &o->destroy) ||
        !btg_library_symbol(library, "OSMesaGetProcAddress", &o->function)) {
        end(o);
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "osmesa: the library is no OSMesa, or one older than Mesa 12");
    }
    o->context = o->create(attributes, NULL);
    if (!o->context) {
        end(o);
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "osmesa: no OpenGL 4.3 core context; a newer Mesa has it");
    }
    *made = o;
    return BTG_OK;
}

const btg_context_provider_table btg_context_osmesa = {
    .name = "osmesa",
    .library = "libOSMesa.so.8",
    .package = "libosmesa6",
    .make = make,
    .bind = bind,
    .unbind = unbind,
    .end = end,
    .function = function,
};
