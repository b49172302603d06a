/* Put before the program (LD_PRELOAD): Vulkan's loader and its devices are of the version that
 * BTG_TEST_LOADER and BTG_TEST_DEVICE say, 1.0 or 1.1. Whoever asks them for more ends. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

#include <vulkan/vulkan.h>

#define EXPORT __attribute__((visibility("default")))

EXPORT void *dlopen(const char *name, int flags);

static PFN_vkGetInstanceProcAddr next_address;
static PFN_vkCreateInstance next_create;
static PFN_vkGetPhysicalDeviceProperties2 next_properties;

static uint32_t version_of(const char *variable) {
    const char *word = getenv(variable);
    return word && strcmp(word, "1.0") == 0 ? VK_API_VERSION_1_0 : VK_API_VERSION_1_1;
}

static VkResult VKAPI_CALL version(uint32_t *out) {
    *out = version_of("BTG_TEST_LOADER");
    return VK_SUCCESS;
}

static VkResult VKAPI_CALL create(const VkInstanceCreateInfo *info,
                                  const VkAllocationCallbacks *memory, VkInstance *instance) {
    if (info->pApplicationInfo->apiVersion > VK_API_VERSION_1_1) abort();
    return next_create(info, memory, instance);
}

static void VKAPI_CALL properties(VkPhysicalDevice device, VkPhysicalDeviceProperties2 *all) {
    for (const VkBaseOutStructure *s = all->pNext; s; s = s->pNext)
        if (s->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES) abort();
    next_properties(device, all);
    all->properties.apiVersion = version_of("BTG_TEST_DEVICE");
}

/* ISO C has no word for one kind of function as another; Vulkan has no other way. */
EXPORT PFN_vkVoidFunction VKAPI_CALL vkGetInstanceProcAddr(VkInstance instance, const char *name) {
    PFN_vkVoidFunction function = next_address(instance, name);
    if (strcmp(name, "vkEnumerateInstanceVersion") == 0) return (PFN_vkVoidFunction)version;
    if (strcmp(name, "vkCreateInstance") == 0) {
        next_create = (PFN_vkCreateInstance)function;
        return (PFN_vkVoidFunction)create;
    }
    if (strcmp(name, "vkGetPhysicalDeviceProperties2") == 0) {
        next_properties = (PFN_vkGetPhysicalDeviceProperties2)function;
        return (PFN_vkVoidFunction)properties;
    }
    return function;
}

/* In the loader's place this library, which asks it. All stay loaded: what drivers leave behind is
 * then known by their names. */
void *dlopen(const char *name, int flags) {
    void *(*next)(const char *, int);
    void *symbol = dlsym(RTLD_NEXT, "dlopen");
    memcpy(&next, &symbol, sizeof next);
    void *library = next(name, flags | RTLD_NODELETE);
    if (!name || !strstr(name, "libvulkan.so") || !library) return library;
    symbol = dlsym(library, "vkGetInstanceProcAddr");
    memcpy(&next_address, &symbol, sizeof next_address);
    Dl_info self;
    return dladdr((void *)&next_address, &self) ? next(self.dli_fname, flags) : NULL;
}
