/* The vulkan back end as its tests see it. Internal. */
#ifndef BTG_BACKEND_VULKAN_VULKAN_H
#define BTG_BACKEND_VULKAN_VULKAN_H

#include "backend/vulkan/loader.h"

/* As btg_backend_vulkan.open, under the Khronos validation layer. `debug` must stay until close.
 * `dispatch`: queries at once at the most; 0: the usual. */
btg_status btg_vulkan_open_debug(const btg_vulkan_debug *debug, uint32_t dispatch,
                                 const btg_backend_setup *setup, void **state,
                                 btg_message *message);

#endif
