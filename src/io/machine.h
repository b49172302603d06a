/* Machine files. Internal to the program.
 *
 * A JSON object; numbers in mm, degrees, seconds. See the README for what each member means. */
#ifndef BTG_IO_MACHINE_H
#define BTG_IO_MACHINE_H

#include "bitangent/post.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A built-in machine's name, or a file. `tool_length_mm` replaces the machine's own unless it is
 * NaN. Errors: ERROR_FILE, ERROR_FORMAT, ERROR_MEMORY, with a message: file, JSON path, reason,
 * remedy. */
btg_status btg_machine_load(const char *name_or_file, double tool_length_mm, btg_machine *machine,
                            btg_message *message);

#ifdef __cplusplus
}
#endif
#endif
