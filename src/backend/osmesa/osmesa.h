/* The back end osmesa, opened in a context of one's choice: for tests. Internal. */
#ifndef BTG_BACKEND_OSMESA_OSMESA_H
#define BTG_BACKEND_OSMESA_OSMESA_H

#include "backend/context/context.h"
#include "backend/internal.h"

/* As btg_backend_osmesa.open; `context` may be NULL: as the setup says. */
btg_status btg_osmesa_open_with(const btg_context_def *context, const btg_backend_setup *setup,
                                void **state, btg_message *message);

#endif
