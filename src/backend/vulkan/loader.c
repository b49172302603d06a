#define _GNU_SOURCE /* dladdr */
#include "backend/vulkan/loader.h"
#include "core/part.h"

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

#define LIBRARY     "libvulkan.so.1"
#define VALIDATION  "VK_LAYER_KHRONOS_validation"
#define DEVICES_MAX 16
#define QUEUES_MAX  16

btg_status btg_vulkan_status(VkResult result) {
    switch (result) {
    case VK_SUCCESS:
        return BTG_OK;
    case VK_ERROR_OUT_OF_HOST_MEMORY:
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
    case VK_ERROR_TOO_MANY_OBJECTS:
        return BTG_ERROR_MEMORY;
    default:
        return BTG_ERROR_DEVICE;
    }
}

btg_status btg_vulkan_fail(btg_message *message, VkResult result, const char *what) {
    btg_status status = btg_vulkan_status(result);
    const char *why = "the device failed; try another --backend";
    if (status == BTG_ERROR_MEMORY) why = "the device is out of memory; split the part";
    return btg_fail(message, status, "vulkan: %s: %s (VkResult %d)", what, why, (int)result);
}

/* ---- loader and instance ------------------------------------------------------------------ */

static btg_status open_library(btg_vulkan *vk, btg_message *message) {
    vk->library = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (!vk->library) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "no Vulkan loader: %s cannot be opened; install it (Debian: libvulkan1)",
                        LIBRARY);
    }
    /* A function through a data pointer: POSIX allows it, ISO C has no word for it. */
    void *symbol = dlsym(vk->library, "vkGetInstanceProcAddr");
    memcpy(&vk->GetInstanceProcAddr, &symbol, sizeof symbol);
    if (!symbol) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE, "%s is no Vulkan loader", LIBRARY);
    }
#define LOAD(name) vk->name = (PFN_vk##name)vk->GetInstanceProcAddr(NULL, "vk" #name);
    BTG_VULKAN_GLOBAL(LOAD)
#undef LOAD
    uint32_t version = VK_API_VERSION_1_0;
    if (vk->EnumerateInstanceVersion) vk->EnumerateInstanceVersion(&version);
    if (!vk->CreateInstance || version < VK_API_VERSION_1_1) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE, "%s is older than Vulkan 1.1", LIBRARY);
    }
    return BTG_OK;
}

static VKAPI_ATTR VkBool32 VKAPI_CALL report(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                             VkDebugUtilsMessageTypeFlagsEXT types,
                                             const VkDebugUtilsMessengerCallbackDataEXT *data,
                                             void *user) {
    const btg_vulkan_debug *debug = user;
    (void)severity;
    (void)types;
    debug->report(data->pMessage ? data->pMessage : "", debug->user);
    return VK_FALSE;
}

/* A messenger of its own: one that hangs on the instance's creation hears of nothing later. */
static btg_status listen(const btg_vulkan_debug *debug, btg_vulkan *vk, btg_message *message) {
    VkDebugUtilsMessengerCreateInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                           VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                       VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT,
        .pfnUserCallback = report,
        .pUserData = (void *)debug};
    PFN_vkCreateDebugUtilsMessengerEXT create =
        (PFN_vkCreateDebugUtilsMessengerEXT)vk->GetInstanceProcAddr(
            vk->instance, "vkCreateDebugUtilsMessengerEXT");
    if (!create) return btg_fail(message, BTG_ERROR_UNSUPPORTED, "vulkan: no debug messenger");
    VkResult result = create(vk->instance, &info, NULL, &vk->messenger);
    return result ? btg_vulkan_fail(message, result, "debug messenger") : BTG_OK;
}

static btg_status make_instance(const btg_vulkan_debug *debug, btg_vulkan *vk,
                                btg_message *message) {
    const char *layer = VALIDATION, *extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                     .pApplicationName = "bitangent",
                                     .apiVersion = VK_API_VERSION_1_1};
    VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                 .pApplicationInfo = &application,
                                 .enabledLayerCount = debug != NULL,
                                 .ppEnabledLayerNames = &layer,
                                 .enabledExtensionCount = debug != NULL,
                                 .ppEnabledExtensionNames = &extension};
    VkResult result = vk->CreateInstance(&info, NULL, &vk->instance);
    if (result != VK_SUCCESS) {
        vk->instance = NULL;
        const char *why = result == VK_ERROR_INCOMPATIBLE_DRIVER ? "no Vulkan driver is installed"
                          : result == VK_ERROR_LAYER_NOT_PRESENT ? VALIDATION " is not installed"
                                                                 : "no Vulkan instance";
        return btg_fail(message, BTG_ERROR_NO_DEVICE, "%s (VkResult %d)", why, (int)result);
    }
#define LOAD(name) vk->name = (PFN_vk##name)vk->GetInstanceProcAddr(vk->instance, "vk" #name);
    BTG_VULKAN_INSTANCE(LOAD)
#undef LOAD
    return debug ? listen(debug, vk, message) : BTG_OK;
}

/* ---- the device --------------------------------------------------------------------------- */

/* The faster kinds first. */
static int rank(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return 4;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return 3;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return 2;
    default:
        return 1;
    }
}

static bool compute_queue(const btg_vulkan *vk, VkPhysicalDevice device, uint32_t *family) {
    VkQueueFamilyProperties queues[QUEUES_MAX];
    uint32_t count = QUEUES_MAX;
    vk->GetPhysicalDeviceQueueFamilyProperties(device, &count, queues);
    for (uint32_t i = 0; i < count; i++) {
        if (!(queues[i].queueFlags & VK_QUEUE_COMPUTE_BIT)) continue;
        *family = i;
        return true;
    }
    return false;
}

/* Drivers have names from Vulkan 1.2 on, versions always. */
static void name_device(btg_vulkan *vk, const VkPhysicalDeviceProperties *p,
                        const VkPhysicalDeviceDriverProperties *driver) {
    char version[40];
    snprintf(version, sizeof version, "%u.%u.%u", VK_VERSION_MAJOR(p->driverVersion),
             VK_VERSION_MINOR(p->driverVersion), VK_VERSION_PATCH(p->driverVersion));
    bool named = driver->driverName[0] != '\0';
    snprintf(vk->name, sizeof vk->name,
             "%.64s; driver %.24s %.32s; Vulkan %u.%u.%u; %u MB a buffer, %u positions a dispatch",
             p->deviceName, named ? driver->driverName : "version",
             named ? driver->driverInfo : version, VK_VERSION_MAJOR(p->apiVersion),
             VK_VERSION_MINOR(p->apiVersion), VK_VERSION_PATCH(p->apiVersion),
             p->limits.maxStorageBufferRange >> 20, p->limits.maxComputeWorkGroupCount[0]);
}

/* Takes the device when it is better than the one before. */
static void consider(btg_vulkan *vk, VkPhysicalDevice device, int *best) {
    VkPhysicalDeviceDriverProperties driver = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceSubgroupProperties subgroup = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    uint32_t family;
    vk->GetPhysicalDeviceProperties2(device, &all);
    if (all.properties.apiVersion < VK_API_VERSION_1_1) return;
    if (!compute_queue(vk, device, &family) || rank(all.properties.deviceType) <= *best) return;
    all.pNext = &subgroup;
    if (all.properties.apiVersion >= VK_API_VERSION_1_2) subgroup.pNext = &driver;
    vk->GetPhysicalDeviceProperties2(device, &all);
    *best = rank(all.properties.deviceType);
    vk->physical = device;
    vk->queue_family = family;
    vk->limits = all.properties.limits;
    vk->subgroup = subgroup.subgroupSize;
    name_device(vk, &all.properties, &driver);
}

btg_status btg_vulkan_find(const btg_vulkan_debug *debug, btg_vulkan *vulkan,
                           btg_message *message) {
    btg_vulkan vk = {0};
    btg_status status = open_library(&vk, message);
    if (status == BTG_OK) status = make_instance(debug, &vk, message);
    if (status == BTG_OK) {
        VkPhysicalDevice devices[DEVICES_MAX];
        uint32_t count = DEVICES_MAX;
        int best = 0;
        VkResult result = vk.EnumeratePhysicalDevices(vk.instance, &count, devices);
        for (uint32_t i = 0; result >= 0 && i < count; i++)
            consider(&vk, devices[i], &best);
        if (best == 0) {
            status = btg_fail(message, BTG_ERROR_NO_DEVICE,
                              "no device with Vulkan 1.1 and compute among %u",
                              result >= 0 ? (unsigned)count : 0u);
        }
    }
    if (status != BTG_OK)
        btg_vulkan_end(&vk);
    else
        *vulkan = vk;
    return status;
}

/* A driver once used stays loaded: those that bring a compiler take long to load and leave memory
 * behind each time they go. */
static void keep_driver(const btg_vulkan *vk) {
    Dl_info driver;
    void *function;
    memcpy(&function, &vk->CmdDispatch, sizeof function);
    if (!dladdr(function, &driver) || !driver.dli_fname) return;
    void *library = dlopen(driver.dli_fname, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (library) dlclose(library);
}

btg_status btg_vulkan_start(btg_vulkan *vk, btg_message *message) {
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                     .queueFamilyIndex = vk->queue_family,
                                     .queueCount = 1,
                                     .pQueuePriorities = &priority};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue};
    VkResult result = vk->CreateDevice(vk->physical, &info, NULL, &vk->device);
    if (result != VK_SUCCESS) {
        vk->device = NULL;
        return btg_vulkan_fail(message, result, "opening the device");
    }
#define LOAD(name) vk->name = (PFN_vk##name)vk->GetDeviceProcAddr(vk->device, "vk" #name);
    BTG_VULKAN_DEVICE(LOAD)
#undef LOAD
    vk->GetDeviceQueue(vk->device, vk->queue_family, 0, &vk->queue);
    keep_driver(vk);
    return BTG_OK;
}

void btg_vulkan_end(btg_vulkan *vk) {
    if (vk->device) vk->DestroyDevice(vk->device, NULL);
    if (vk->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy =
            (PFN_vkDestroyDebugUtilsMessengerEXT)vk->GetInstanceProcAddr(
                vk->instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy(vk->instance, vk->messenger, NULL);
    }
    if (vk->instance) vk->DestroyInstance(vk->instance, NULL);
    if (vk->library) dlclose(vk->library);
    *vk = (btg_vulkan){0};
}
