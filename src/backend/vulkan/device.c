#include "backend/vulkan/device.h"
#include "core/part.h"

#include <string.h>

#include "drop_spv.h"
#include "tilt_spv.h"

/* A dispatch that takes longer hangs. */
#define TIMEOUT_NS 60000000000u
/* Invocations a workgroup: some subgroups, for a wide device; where subgroups are narrow, as on a
 * processor, more would only wait for each other. */
#define GROUP_WIDE   64
#define GROUP_NARROW 16
#define NARROW       8

size_t btg_vulkan_buffer_max(const btg_vulkan *vulkan) {
    return vulkan->limits.maxStorageBufferRange;
}

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

static VkResult make_buffer(btg_vulkan_device *d, uint32_t at, VkDeviceSize size) {
    const btg_vulkan *vk = &d->vk;
    btg_vulkan_buffer *b = &d->buffer[at];
    VkBufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                               .size = size,
                               .usage = at == BTG_GPU_SCENE ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT
                                                            : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT};
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
    return result;
}

static VkResult make_buffers(btg_vulkan_device *d, const btg_scene *scene) {
    const VkDeviceSize size[BTG_GPU_BINDINGS] = {
        [BTG_GPU_SCENE] = sizeof scene->head,
        [BTG_GPU_GEOMETRY] = scene->count * sizeof *scene->geometry,
        [BTG_GPU_QUERIES] = d->capacity * sizeof(btg_gpu_query),
        [BTG_GPU_WINNERS] = d->capacity * sizeof(btg_gpu_winner)};
    for (uint32_t i = 0; i < BTG_GPU_BINDINGS; i++) {
        VkResult result = make_buffer(d, i, size[i]);
        if (result != VK_SUCCESS) return result;
    }
    memcpy(d->buffer[BTG_GPU_SCENE].mapped, &scene->head, sizeof scene->head);
    memcpy(d->buffer[BTG_GPU_GEOMETRY].mapped, scene->geometry, size[BTG_GPU_GEOMETRY]);
    return VK_SUCCESS;
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

static VkResult make_set(btg_vulkan_device *d) {
    const btg_vulkan *vk = &d->vk;
    VkDescriptorPoolSize sizes[2] = {
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1},
        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, BTG_GPU_BINDINGS - 1},
    };
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .maxSets = 1,
                                       .poolSizeCount = 2,
                                       .pPoolSizes = sizes};
    VkResult result = vk->CreateDescriptorPool(vk->device, &pool, NULL, &d->descriptor_pool);
    if (result != VK_SUCCESS) return result;
    VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                       .descriptorPool = d->descriptor_pool,
                                       .descriptorSetCount = 1,
                                       .pSetLayouts = &d->set_layout};
    result = vk->AllocateDescriptorSets(vk->device, &set, &d->set);
    if (result != VK_SUCCESS) return result;
    for (uint32_t i = 0; i < BTG_GPU_BINDINGS; i++) {
        VkDescriptorBufferInfo buffer = {.buffer = d->buffer[i].buffer, .range = VK_WHOLE_SIZE};
        VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                      .dstSet = d->set,
                                      .dstBinding = i,
                                      .descriptorCount = 1,
                                      .descriptorType = type_of(i),
                                      .pBufferInfo = &buffer};
        vk->UpdateDescriptorSets(vk->device, 1, &write, 0, NULL);
    }
    return VK_SUCCESS;
}

/* ---- pipelines ---------------------------------------------------------------------------- */

static VkResult make_pipeline(btg_vulkan_device *d, btg_op op, const uint32_t *code, size_t size) {
    const btg_vulkan *vk = &d->vk;
    VkShaderModule module;
    VkShaderModuleCreateInfo shader = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = code};
    VkResult result = vk->CreateShaderModule(vk->device, &shader, NULL, &module);
    if (result != VK_SUCCESS) return result;
    uint32_t group = vk->subgroup > NARROW ? GROUP_WIDE : GROUP_NARROW;
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

static VkResult make_command(btg_vulkan_device *d) {
    const btg_vulkan *vk = &d->vk;
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                    .queueFamilyIndex = vk->queue_family};
    VkResult result = vk->CreateCommandPool(vk->device, &pool, NULL, &d->command_pool);
    if (result != VK_SUCCESS) return result;
    VkCommandBufferAllocateInfo command = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                           .commandPool = d->command_pool,
                                           .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                           .commandBufferCount = 1};
    result = vk->AllocateCommandBuffers(vk->device, &command, &d->command);
    if (result != VK_SUCCESS) return result;
    VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    return vk->CreateFence(vk->device, &fence, NULL, &d->fence);
}

/* ---- whole -------------------------------------------------------------------------------- */

btg_status btg_vulkan_load(btg_vulkan_device *d, const btg_scene *scene, uint32_t wanted,
                           btg_message *message) {
    uint32_t most = d->vk.limits.maxComputeWorkGroupCount[0];
    d->capacity = wanted < most ? wanted : most;
    const char *what = "buffers for the part";
    VkResult result = make_buffers(d, scene);
    if (result == VK_SUCCESS) {
        what = "compiling shaders";
        result = make_layout(d);
        if (result == VK_SUCCESS) result = make_set(d);
        if (result == VK_SUCCESS) result = make_pipeline(d, BTG_OP_DROP, drop_spv, sizeof drop_spv);
        if (result == VK_SUCCESS) result = make_pipeline(d, BTG_OP_TILT, tilt_spv, sizeof tilt_spv);
        if (result == VK_SUCCESS) result = make_command(d);
    }
    if (result == VK_SUCCESS) return BTG_OK;
    btg_vulkan_unload(d);
    return btg_vulkan_fail(message, result, what);
}

void btg_vulkan_unload(btg_vulkan_device *d) {
    btg_vulkan vk = d->vk;
    if (!vk.device) return;
    vk.DeviceWaitIdle(vk.device);
    vk.DestroyFence(vk.device, d->fence, NULL);
    vk.DestroyCommandPool(vk.device, d->command_pool, NULL);
    for (int i = 0; i < 2; i++)
        vk.DestroyPipeline(vk.device, d->pipeline[i], NULL);
    vk.DestroyDescriptorPool(vk.device, d->descriptor_pool, NULL);
    vk.DestroyPipelineLayout(vk.device, d->layout, NULL);
    vk.DestroyDescriptorSetLayout(vk.device, d->set_layout, NULL);
    for (int i = 0; i < BTG_GPU_BINDINGS; i++) {
        vk.DestroyBuffer(vk.device, d->buffer[i].buffer, NULL);
        vk.FreeMemory(vk.device, d->buffer[i].memory, NULL); /* unmaps */
    }
    *d = (btg_vulkan_device){.vk = vk};
}

static VkResult record(btg_vulkan_device *d, btg_op op, uint32_t count) {
    const btg_vulkan *vk = &d->vk;
    VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                      .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    VkResult result = vk->BeginCommandBuffer(d->command, &begin);
    if (result != VK_SUCCESS) return result;
    vk->CmdBindPipeline(d->command, VK_PIPELINE_BIND_POINT_COMPUTE, d->pipeline[op]);
    vk->CmdBindDescriptorSets(d->command, VK_PIPELINE_BIND_POINT_COMPUTE, d->layout, 0, 1, &d->set,
                              0, NULL);
    vk->CmdDispatch(d->command, count, 1, 1);
    VkMemoryBarrier to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                               .srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT,
                               .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vk->CmdPipelineBarrier(d->command, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                           VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &to_host, 0, NULL, 0, NULL);
    return vk->EndCommandBuffer(d->command);
}

btg_status btg_vulkan_run(btg_vulkan_device *d, btg_op op, uint32_t count) {
    const btg_vulkan *vk = &d->vk;
    VkResult result = record(d, op, count);
    VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                           .commandBufferCount = 1,
                           .pCommandBuffers = &d->command};
    if (result == VK_SUCCESS) result = vk->ResetFences(vk->device, 1, &d->fence);
    if (result == VK_SUCCESS) result = vk->QueueSubmit(vk->queue, 1, &submit, d->fence);
    if (result == VK_SUCCESS)
        result = vk->WaitForFences(vk->device, 1, &d->fence, VK_TRUE, TIMEOUT_NS);
    return btg_vulkan_status(result);
}
