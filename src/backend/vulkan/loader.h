/* The system's Vulkan loader, opened at run time, and the device the work runs on. Internal. */
#ifndef BTG_BACKEND_VULKAN_LOADER_H
#define BTG_BACKEND_VULKAN_LOADER_H

#include "backend/internal.h"

#include <stdbool.h>

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

/* What is called before there is an instance, with one, and with a device. */
#define BTG_VULKAN_GLOBAL(X)                                                                       \
    X(EnumerateInstanceVersion)                                                                    \
    X(CreateInstance)
#define BTG_VULKAN_INSTANCE(X)                                                                     \
    X(DestroyInstance)                                                                             \
    X(EnumeratePhysicalDevices)                                                                    \
    X(GetPhysicalDeviceProperties2)                                                                \
    X(GetPhysicalDeviceQueueFamilyProperties)                                                      \
    X(GetPhysicalDeviceMemoryProperties)                                                           \
    X(CreateDevice)                                                                                \
    X(GetDeviceProcAddr)
#define BTG_VULKAN_DEVICE(X)                                                                       \
    X(DestroyDevice)                                                                               \
    X(GetDeviceQueue)                                                                              \
    X(CreateBuffer)                                                                                \
    X(DestroyBuffer)                                                                               \
    X(GetBufferMemoryRequirements)                                                                 \
    X(AllocateMemory)                                                                              \
    X(FreeMemory)                                                                                  \
    X(BindBufferMemory)                                                                            \
    X(MapMemory)                                                                                   \
    X(CreateDescriptorSetLayout)                                                                   \
    X(DestroyDescriptorSetLayout)                                                                  \
    X(CreatePipelineLayout)                                                                        \
    X(DestroyPipelineLayout)                                                                       \
    X(CreateDescriptorPool)                                                                        \
    X(DestroyDescriptorPool)                                                                       \
    X(AllocateDescriptorSets)                                                                      \
    X(UpdateDescriptorSets)                                                                        \
    X(CreateShaderModule)                                                                          \
    X(DestroyShaderModule)                                                                         \
    X(CreateComputePipelines)                                                                      \
    X(DestroyPipeline)                                                                             \
    X(CreateCommandPool)                                                                           \
    X(DestroyCommandPool)                                                                          \
    X(AllocateCommandBuffers)                                                                      \
    X(BeginCommandBuffer)                                                                          \
    X(EndCommandBuffer)                                                                            \
    X(CmdBindPipeline)                                                                             \
    X(CmdBindDescriptorSets)                                                                       \
    X(CmdDispatch)                                                                                 \
    X(CmdPipelineBarrier)                                                                          \
    X(CreateFence)                                                                                 \
    X(DestroyFence)                                                                                \
    X(ResetFences)                                                                                 \
    X(WaitForFences)                                                                               \
    X(QueueSubmit)                                                                                 \
    X(DeviceWaitIdle)

/* Where the validation layer reports: for tests. Called from any thread inside a Vulkan call. */
typedef struct btg_vulkan_debug {
    void (*report)(const char *text, void *user);
    void *user;
} btg_vulkan_debug;

typedef struct btg_vulkan {
    void *library;
    PFN_vkGetInstanceProcAddr GetInstanceProcAddr;
    VkInstance instance;
    VkDebugUtilsMessengerEXT messenger;
    VkPhysicalDevice physical;
    uint32_t queue_family;
    VkPhysicalDeviceLimits limits;
    uint32_t subgroup;
    char name[224]; /* device, driver, version, limits: one line */
    VkDevice device;
    VkQueue queue;
#define BTG_VULKAN_MEMBER(name) PFN_vk##name name;
    BTG_VULKAN_GLOBAL(BTG_VULKAN_MEMBER)
    BTG_VULKAN_INSTANCE(BTG_VULKAN_MEMBER)
    BTG_VULKAN_DEVICE(BTG_VULKAN_MEMBER)
#undef BTG_VULKAN_MEMBER
} btg_vulkan;

/* Opens the loader and finds the best device; no device is created yet. `debug` may be NULL; with
 * it the Khronos validation layer must be there. ERROR_NO_DEVICE, and message says what is
 * missing. */
btg_status btg_vulkan_find(const btg_vulkan_debug *debug, btg_vulkan *vulkan, btg_message *message);
/* And the device with its queue. */
btg_status btg_vulkan_start(btg_vulkan *vulkan, btg_message *message);
/* Ends both; a zeroed one is fine. */
void btg_vulkan_end(btg_vulkan *vulkan);

/* What a result means to the caller. */
btg_status btg_vulkan_status(VkResult result);
/* The same with a message about `what`. */
btg_status btg_vulkan_fail(btg_message *message, VkResult result, const char *what);

#endif
