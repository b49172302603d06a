/* A scene on a Vulkan device, and dispatches over it. Internal. */
#ifndef BTG_BACKEND_VULKAN_DEVICE_H
#define BTG_BACKEND_VULKAN_DEVICE_H

#include "backend/device/batch.h"
#include "backend/vulkan/loader.h"

typedef struct btg_vulkan_buffer {
    VkBuffer buffer;
    VkDeviceMemory memory;
    void *mapped;
} btg_vulkan_buffer;

/* One dispatch in flight. */
typedef struct btg_vulkan_slot {
    btg_vulkan_buffer queries, winners;
    VkDescriptorSet set;
    VkCommandBuffer command;
    VkFence fence;
} btg_vulkan_slot;

typedef struct btg_vulkan_device {
    btg_vulkan vk;
    btg_vulkan_buffer scene, geometry;
    size_t bytes; /* of all buffers */
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkDescriptorPool descriptor_pool;
    VkPipeline pipeline[2]; /* by btg_op */
    VkCommandPool command_pool;
    btg_vulkan_slot slot[BTG_BATCH_SLOTS];
} btg_vulkan_device;

/* As the btg_device_ops of those names; d->vk is started. btg_vulkan_unload leaves d->vk alone. */
btg_status btg_vulkan_load(btg_vulkan_device *d, const btg_scene *scene, uint32_t capacity,
                           btg_message *message);
void btg_vulkan_unload(btg_vulkan_device *d);
btg_status btg_vulkan_dispatch(btg_vulkan_device *d, uint32_t slot, btg_op op, uint32_t count);
btg_status btg_vulkan_wait(btg_vulkan_device *d, uint32_t slot);

#endif
