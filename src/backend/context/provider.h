/* Who makes contexts, and what else may be current on a thread. Internal to the room. */
#ifndef BTG_BACKEND_CONTEXT_PROVIDER_H
#define BTG_BACKEND_CONTEXT_PROVIDER_H

#include "bitangent/bitangent.h"

#include <stdbool.h>

typedef void (*btg_context_function)(void);

/* One provider. `made` is what make() returned. */
typedef struct btg_context_provider_table {
    const char *name;
    const char *library; /* of the system */
    const char *package; /* of Debian, that brings it */
    /* `library` is open and stays so for good. The context is not current afterwards, nor is any
     * other; it may be for a while in between. ERROR_NO_DEVICE with a message. */
    btg_status (*make)(void *library, const btg_allocator *allocator, void **made,
                       btg_message *message);
    bool (*bind)(void *made);
    void (*unbind)(void *made);
    void (*end)(void *made); /* nothing is current */
    btg_context_function (*function)(void *made, const char *name);
} btg_context_provider_table;

extern const btg_context_provider_table btg_context_osmesa;
extern const btg_context_provider_table btg_context_egl;

/* A function's address out of a library, into a pointer to a function; false: not there. */
bool btg_library_symbol(void *library, const char *name, void *function);

/* What the host had current on this thread, through whichever library it loaded. */
typedef struct btg_host_current {
    struct {
        void *display, *context;
        unsigned long draw, read;
        int (*bind)(void *display, unsigned long draw, unsigned long read, void *context);
    } glx;
    struct {
        void *display, *context, *draw, *read;
        unsigned api;
        unsigned (*bind_api)(unsigned api);
        unsigned (*bind)(void *display, void *draw, void *read, void *context);
    } egl;
    struct {
        void *context, *buffer;
        int type, width, height;
        unsigned char (*bind)(void *context, void *buffer, unsigned type, int width, int height);
    } osmesa;
} btg_host_current;

/* Remembers it and leaves nothing current. */
void btg_host_current_take(btg_host_current *host);
/* Makes it current again; nothing else may be. */
void btg_host_current_give_back(const btg_host_current *host);

#endif
