/* Put before the program (LD_PRELOAD): a machine without Vulkan, OSMesa and EGL. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <string.h>

__attribute__((visibility("default"))) void *dlopen(const char *name, int flags);

void *dlopen(const char *name, int flags) {
    static const char *const missing[] = {"libvulkan", "libOSMesa", "libEGL"};
    void *(*next)(const char *, int);
    void *symbol = dlsym(RTLD_NEXT, "dlopen");
    memcpy(&next, &symbol, sizeof next);
    for (int i = 0; i < 3 && name; i++)
        if (strstr(name, missing[i])) return NULL;
    return next(name, flags);
}
