#include "core/part.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TEXT_OF(x)       #x
#define VERSION(a, b, c) TEXT_OF(a) "." TEXT_OF(b) "." TEXT_OF(c)

const char *btg_version(void) {
    return VERSION(BTG_VERSION_MAJOR, BTG_VERSION_MINOR, BTG_VERSION_PATCH);
}

const char *btg_status_name(btg_status status) {
    switch (status) {
    case BTG_OK:
        return "two-contact";
    case BTG_OSCULATING:
        return "osculating";
    case BTG_SINGLE_CONTACT:
        return "single-contact";
    case BTG_NO_CONTACT:
        return "no-contact";
    case BTG_BUDGET:
        return "budget";
    case BTG_ERROR_ARGUMENT:
        return "error-argument";
    case BTG_ERROR_MEMORY:
        return "error-memory";
    case BTG_ERROR_UNSUPPORTED:
        return "error-unsupported";
    case BTG_ERROR_NOT_BUILT:
        return "error-not-built";
    case BTG_ERROR_NO_DEVICE:
        return "error-no-device";
    case BTG_ERROR_FILE:
        return "error-file";
    case BTG_ERROR_FORMAT:
        return "error-format";
    case BTG_ERROR_GOUGE:
        return "error-gouge";
    case BTG_ERROR_DEVICE:
        return "error-device";
    }
    return "unknown";
}

void *btg_allocate(const btg_allocator *allocator, size_t count, size_t size) {
    if (size > 0 && count > SIZE_MAX / size) return NULL;
    size_t bytes = count * size;
    if (bytes == 0) bytes = 1;
    if (allocator->allocate) return allocator->allocate(bytes, allocator->user);
    return malloc(bytes);
}

void *btg_shrink(const btg_allocator *allocator, void *memory, size_t count, size_t size) {
    void *shrunk = allocator->allocate ? btg_allocate(allocator, count, size)
                                       : realloc(memory, count * size > 0 ? count * size : 1);
    if (shrunk && allocator->allocate) {
        memcpy(shrunk, memory, count * size);
        btg_release(allocator, memory);
    }
    return shrunk;
}

void btg_release(const btg_allocator *allocator, void *memory) {
    if (!memory) return;
    if (!allocator->allocate) {
        free(memory);
    } else if (allocator->release) {
        allocator->release(memory, allocator->user);
    }
}

btg_status btg_fail(btg_message *message, btg_status status, const char *format, ...) {
    if (!message) return status;
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(message->text, sizeof message->text, format, arguments);
    va_end(arguments);
    if (n < 0) message->text[0] = '\0';
    /* File names may hold anything; a message is one line. */
    for (char *c = message->text; *c; c++) {
        if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
    }
    return status;
}
