#include "backend/internal.h"

#include <stdio.h>
#include <string.h>

/* Left out of this build: known by name, so that asking for one gets a plain answer. */
#ifdef BTG_HAVE_OSMESA
#define OSMESA btg_backend_osmesa
#else
static const btg_backend_table osmesa = {.name = "osmesa",
                                         .summary = "depth images by OpenGL without a window"};
#define OSMESA osmesa
#endif
#ifdef BTG_HAVE_GL
#define GL btg_backend_gl
#else
static const btg_backend_table gl = {.name = "gl", .summary = "compute by OpenGL"};
#define GL gl
#endif
#ifdef BTG_HAVE_VULKAN
#define VULKAN btg_backend_vulkan
#else
static const btg_backend_table vulkan = {.name = "vulkan", .summary = "compute by Vulkan"};
#define VULKAN vulkan
#endif

const btg_backend_table *const btg_backend_registry[] = {&btg_backend_cpu, &btg_backend_reference,
                                                         &OSMESA, &GL, &VULKAN};
const size_t btg_backend_registry_count =
    sizeof btg_backend_registry / sizeof btg_backend_registry[0];

size_t btg_backend_count(void) {
    return btg_backend_registry_count;
}

btg_status btg_backend_get_info(size_t index, btg_backend_info *info) {
    if (!info || index >= btg_backend_registry_count) return BTG_ERROR_ARGUMENT;
    const btg_backend_table *table = btg_backend_registry[index];
    btg_backend_info result;
    memset(&result, 0, sizeof result);
    result.name = table->name;
    result.state = BTG_BACKEND_NOT_BUILT;
    if (table->probe) result.state = table->probe(result.device, sizeof result.device);
    snprintf(result.summary, sizeof result.summary, "%s", table->summary);
    *info = result;
    return BTG_OK;
}

const char *btg_backend_state_name(btg_backend_state state) {
    switch (state) {
    case BTG_BACKEND_NOT_BUILT:
        return "not-built";
    case BTG_BACKEND_NO_DEVICE:
        return "no-device";
    case BTG_BACKEND_READY:
        return "ready";
    }
    return "unknown";
}
