#include "backend/vulkan/device.h"
#include "core/part.h"

#include <string.h>

#include "drop_spv.h"
#include "tilt_spv.h"

/* A dispatch that takes longer hangs. */
#define TIMEOUT_NS 60000000000u
/* Subgroups as narrow as a processor's. */
#define NARROW 8

/* ---- buffers ------------------------------------------------------------------------------ */

/* Memory the host sees; on the device's own side where there is such. */
static bool memory_type(const btg_vulkan *vk, uint32_t allowed, uint32_t *type) {
    const VkMemoryPropertyFlags need =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    VkPhysicalDeviceMemoryProperties all;
    vk->GetPhysicalDeviceMemoryProperties(vk->physical, &all);
    bool found = false;
    for (uint32_t i = 0; i < all.memoryTypeCount; i++) {
        VkMemoryPropertyFlags flags = all.memoryTypes[i].propertyFlags;
        if (!(allowed >> i & 1) || (flags & need) != need) continue;
        bool local = flags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
        if (found && !local) continue;
        *type = i;
        found = true;
        if (local) break;
    }
    return found;
}

static VkResult make_buffer(btg_vulkan_device *d, VkBufferUsageFlags usage, VkDeviceSize size,
                            btg_vulkan_buffer *b) {
    const btg_vulkan *vk = &d->vk;
    VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
    VkResult result = vk->CreateBuffer(vk->device, &info, NULL, &b->buffer);
    if (result != VK_SUCCESS) return result;
    VkMemoryRequirements need;
    VkMemoryAllocateInfo memory = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
    vk->GetBufferMemoryRequirements(vk->device, b->buffer, &need);
    memory.allocationSize = need.size;
    if (!memory_type(vk, need.memoryTypeBits, &memory.memoryTypeIndex))
        return VK_ERROR_FEATURE_NOT_PRESENT;
    result = vk->AllocateMemory(vk->device, &memory, NULL, &b->memory);
    if (result == VK_SUCCESS) result = vk->BindBufferMemory(vk->device, b->buffer, b->memory, 0);
    if (result == VK_SUCCESS)
        result = vk->MapMemory(vk->device, b->memory, 0, VK_WHOLE_SIZE, 0, &b->mapped);
    d->bytes += need.size;
    return result;
}

static VkResult make_filled(btg_vulkan_device *d, VkBufferUsageFlags usage, const void *data,
                            size_t size, btg_vulkan_buffer *b) {
    VkResult result = make_buffer(d, usage, size, b);
    if (result == VK_SUCCESS) memcpy(b->mapped, data, size);
    return result;
}

static VkResult make_buffers(btg_vulkan_device *d, const btg_scene *scene, uint32_t capacity) {
    const VkBufferUsageFlags uniform = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                             storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    VkResult result = make_filled(d, uniform, &scene->head, sizeof scene->head, &d->scene);
    if (result == VK_SUCCESS)
        result = make_filled(d, storage, scene->geometry, scene->count * sizeof *scene->geometry,
                             &d->geometry);
    for (uint32_t i = 0; i < BTG_BATCH_SLOTS && result == VK_SUCCESS; i++) {
        btg_vulkan_slot *s = &d->slot[i];
        result = make_buffer(d, storage, capacity * sizeof(btg_gpu_query), &s->queries);
        if (result == VK_SUCCESS)
            result = make_buffer(d, storage, capacity * sizeof(btg_gpu_winner), &s->winners);
    }
    return result;
}

/* ---- descriptors -------------------------------------------------------------------------- */

static VkDescriptorType type_of(uint32_t binding) {
    return binding == BTG_GPU_SCENE ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER
                                    : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

static VkResult make_layout(btg_vulkan_device *d) {
    const btg_vulkan *vk = &d->vk;
    VkDescriptorSetLayoutBinding bindings[BTG_GPU_BINDINGS];
    for (uint32_t i = 0; i < BTG_GPU_BINDINGS; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){.binding = i,
                                                     .descriptorType = type_of(i),
                                                     .descriptorCount = 1,
                                                     .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    VkDescriptorSetLayoutCreateInfo set = {.sType =
                                               VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                           .bindingCount = BTG_GPU_BINDINGS,
                                           .pBindings = bindings};
    VkResult result = vk->CreateDescriptorSetLayout(vk->device, &set, NULL, &d->set_layout);
    if (result != VK_SUCCESS) return result;
    VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .setLayoutCount = 1,
                                         .pSetLayouts = &d->set_layout};
    return vk->CreatePipelineLayout(vk->device, &layout, NULL, &d->layout);
}

static void write_set(const btg_vulkan_device *d, const btg_vulkan_slot *s) {
    const btg_vulkan *vk = &d->vk;
    const VkBuffer buffers[BTG_GPU_BINDINGS] = {[BTG_GPU_SCENE] = d->scene.buffer,
                                                [BTG_GPU_GEOMETRY] = d->geometry.buffer,
                                                [BTG_GPU_QUERIES] = s->queries.buffer,
                                                [BTG_GPU_WINNERS] = s->winners.buffer};
    for (uint32_t i = 0; i < BTG_GPU_BINDINGS; i++) {
        VkDescriptorBufferInfo buffer = {.buffer = buffers[i], .range = VK_WHOLE_SIZE};
        VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                      .dstSet = s->set,
                                      .dstBinding = i,
                                      .descriptorCount = 1,
                                      .descriptorType = type_of(i),
                                      .pBufferInfo = &buffer};
        vk->UpdateDescriptorSets(vk->device, 1, &write, 0, NULL);
    }
}

static VkResult make_sets(btg_vulkan_device *d) {
    const btg_vulkan *vk = &d->vk;
    VkDescriptorPoolSize sizes[2] = {
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, BTG_BATCH_SLOTS},
        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, (BTG_GPU_BINDINGS - 1) * BTG_BATCH_SLOTS},
    };
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = BTG_BATCH_SLOTS,
                                       .poolSizeCount = 2,
                                       .pPoolSizes = sizes};
    VkResult result = vk->CreateDescriptorPool(vk->device, &pool, NULL, &d->descriptor_pool);
    VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                       .descriptorPool = d->descriptor_pool,
                                       .descriptorSetCount = 1,
                                       .pSetLayouts = &d->set_layout};
    for (uint32_t i = 0; i < BTG_BATCH_SLOTS && result == VK_SUCCESS; i++) {
        result = vk->AllocateDescriptorSets(vk->device, &set, &d->slot[i].set);
        if (result == VK_SUCCESS) write_set(d, &d->slot[i]);
    }
    return result;
}

/* ---- pipelines ---------------------------------------------------------------------------- */

static VkResult make_pipeline(btg_vulkan_device *d, btg_op op, const uint32_t *code, size_t size) {
    const btg_vulkan *vk = &d->vk;
    VkShaderModule module;
    VkShaderModuleCreateInfo shader = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = code};
    VkResult result = vk->CreateShaderModule(vk->device, &shader, NULL, &module);
    if (result != VK_SUCCESS) return result;
    uint32_t group = vk->subgroup > NARROW ? BTG_GPU_GROUP_WIDE : BTG_GPU_GROUP_NARROW;
    VkSpecializationMapEntry entry = {.constantID = 0, .size = sizeof group};
    VkSpecializationInfo special = {1, &entry, sizeof group, &group};
    VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main",
                  .pSpecializationInfo = &special},
        .layout = d->layout};
    result =
        vk->CreateComputePipelines(vk->device, VK_NULL_HANDLE, 1, &info, NULL, &d->pipeline[op]);
    vk->DestroyShaderModule(vk->device, module, NULL);
    return result;
}

static VkResult make_commands(btg_vulkan_device *d) {
    const btg_vulkan *vk = &d->vk;
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = vk->queue_family};
    VkResult result = vk->CreateCommandPool(vk->device, &pool, NULL, &d->command_pool);
    VkCommandBufferAllocateInfo command = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                           .commandPool = d->command_pool,
                                           .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                           .commandBufferCount = 1};
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    for (uint32_t i = 0; i < BTG_BATCH_SLOTS && result == VK_SUCCESS; i++) {
        result = vk->AllocateCommandBuffers(vk->device, &command, &d->slot[i].command);
        if (result == VK_SUCCESS)
            result = vk->CreateFence(vk->device, &fence, NULL, &d->slot[i].fence);
    }
    return result;
}

/* ---- whole -------------------------------------------------------------------------------- */

btg_status btg_vulkan_load(btg_vulkan_device *d, const btg_scene *scene, uint32_t capacity,
                           btg_message *message) {
    const char *what = "buffers for the part";
    VkResult result = make_buffers(d, scene, capacity);
    if (result == VK_SUCCESS) {
        what = "compiling shaders";
        result = make_layout(d);
        if (result == VK_SUCCESS) result = make_sets(d);
        if (result == VK_SUCCESS) result = make_pipeline(d, BTG_OP_DROP, drop_spv, sizeof drop_spv);
        if (result == VK_SUCCESS) result = make_pipeline(d, BTG_OP_TILT, tilt_spv, sizeof tilt_spv);
        if (result == VK_SUCCESS) result = make_commands(d);
    }
    if (result == VK_SUCCESS) return BTG_OK;
    btg_vulkan_unload(d);
    return btg_vulkan_fail(message, result, what);
}

static void free_buffer(const btg_vulkan *vk, btg_vulkan_buffer *b) {
    vk->DestroyBuffer(vk->device, b->buffer, NULL);
    vk->FreeMemory(vk->device, b->memory, NULL); /* unmaps */
}

void btg_vulkan_unload(btg_vulkan_device *d) {
    btg_vulkan vk = d->vk;
    if (!vk.device) return;
    vk.DeviceWaitIdle(vk.device);
    for (uint32_t i = 0; i < BTG_BATCH_SLOTS; i++) {
        vk.DestroyFence(vk.device, d->slot[i].fence, NULL);
        free_buffer(&vk, &d->slot[i].queries);
        free_buffer(&vk, &d->slot[i].winners);
    }
    vk.DestroyCommandPool(vk.device, d->command_pool, NULL);
    for (int i = 0; i < 2; i++)
        vk.DestroyPipeline(vk.device, d->pipeline[i], NULL);
    vk.DestroyDescriptorPool(vk.device, d->descriptor_pool, NULL);
    vk.DestroyPipelineLayout(vk.device, d->layout, NULL);
    vk.DestroyDescriptorSetLayout(vk.device, d->set_layout, NULL);
    free_buffer(&vk, &d->scene);
    free_buffer(&vk, &d->geometry);
    *d = (btg_vulkan_device){.vk = vk};
}

static VkResult record(btg_vulkan_device *d, const btg_vulkan_slot *s, btg_op op, uint32_t count) {
    const btg_vulkan *vk = &d->vk;
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    VkResult result = vk->BeginCommandBuffer(s->command, &begin);
    if (result != VK_SUCCESS) return result;
    vk->CmdBindPipeline(s->command, VK_PIPELINE_BIND_POINT_COMPUTE, d->pipeline[op]);
    vk->CmdBindDescriptorSets(s->command, VK_PIPELINE_BIND_POINT_COMPUTE, d->layout, 0, 1, &s->set,
                              0, NULL);
    vk->CmdDispatch(s->command, count, 1, 1);
    VkMemoryBarrier to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                               .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                               .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vk->CmdPipelineBarrier(s->command, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                           VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_host, 0, NULL, 0, NULL);
    return vk->EndCommandBuffer(s->command);
}

btg_status btg_vulkan_dispatch(btg_vulkan_device *d, uint32_t slot, btg_op op, uint32_t count) {
    const btg_vulkan *vk = &d->vk;
    btg_vulkan_slot *s = &d->slot[slot];
    VkResult result = record(d, s, op, count);
    VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                           .commandBufferCount = 1,
                           .pCommandBuffers = &s->command};
    if (result == VK_SUCCESS) result = vk->ResetFences(vk->device, 1, &s->fence);
    if (result == VK_SUCCESS) result = vk->QueueSubmit(vk->queue, 1, &submit, s->fence);
    return btg_vulkan_status(result);
}

btg_status btg_vulkan_wait(btg_vulkan_device *d, uint32_t slot) {
    const btg_vulkan *vk = &d->vk;
    return btg_vulkan_status(
        vk->WaitForFences(vk->device, 1, &d->slot[slot].fence, VK_TRUE, TIMEOUT_NS));
}
