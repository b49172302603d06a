/* A scene on a Vulkan device, and dispatches over it. Internal. */
#ifndef BTG_BACKEND_VULKAN_DEVICE_H
#define BTG_BACKEND_VULKAN_DEVICE_H

#include "backend/device/scene.h"
#include "backend/vulkan/loader.h"
#include "core/ray.h"

typedef struct btg_vulkan_buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *mapped;
} btg_vulkan_buffer;

typedef struct btg_vulkan_device {
    btg_vulkan vk;
    uint32_t capacity; /* queries a dispatch */
    btg_vulkan_buffer buffer[BTG_GPU_BINDINGS];
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkDescriptorPool descriptor_pool;
    VkDescriptorSet set;
    VkPipeline pipeline[2]; /* by btg_op */
    VkCommandPool command_pool;
    VkCommandBuffer command;
    VkFence fence;
} btg_vulkan_device;

/* Bytes that one buffer of the device takes. */
size_t btg_vulkan_buffer_max(const btg_vulkan *vulkan);

/* Loads a scene; takes over d->vk, which must be started. On error nothing is left but d->vk. */
btg_status btg_vulkan_load(btg_vulkan_device *d, const btg_scene *scene, uint32_t wanted,
                           btg_message *message);
void btg_vulkan_unload(btg_vulkan_device *d);

/* Answers the first `count` <= capacity queries in the query buffer; winners are in theirs when it
 * returns. Errors: ERROR_MEMORY, ERROR_DEVICE (lost, or not done in a minute). */
btg_status btg_vulkan_run(btg_vulkan_device *d, btg_op op, uint32_t count);

#endif
