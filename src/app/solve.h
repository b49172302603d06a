/* From options to an opened method. */
#ifndef BTG_APP_SOLVE_H
#define BTG_APP_SOLVE_H

#include "app/options.h"
#include "methods/method.h"

/* The method, back end and solver that the options name. Errors as btg_method_open. */
btg_status solve_open(const path_options *options, const btg_part *part, const btg_tool *tool,
                      btg_method **method, btg_message *message);

#endif
