/* Buffers that every entry point has. */
#ifdef VULKAN
#define BTG_BIND(layout_, at) layout(layout_, set = 0, binding = at)
#else
#define BTG_BIND(layout_, at) layout(layout_, binding = at)
#endif

#include "layout.h"

BTG_BIND(std140, BTG_GPU_SCENE) uniform scene_block {
    btg_gpu_scene scene;
};
BTG_BIND(std430, BTG_GPU_GEOMETRY) readonly buffer geometry_block {
    vec4 geometry[];
};
BTG_BIND(std430, BTG_GPU_QUERIES) readonly buffer query_block {
    btg_gpu_query queries[];
};
BTG_BIND(std430, BTG_GPU_WINNERS) writeonly buffer winner_block {
    btg_gpu_winner winners[];
};
