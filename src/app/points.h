/* A file of footprint points: two columns, x and y in mm, between blanks, tabs or a comma; `#`
 * starts a comment, empty lines are skipped. */
#ifndef BTG_APP_POINTS_H
#define BTG_APP_POINTS_H

#include "bitangent/bitangent.h"

/* x, y pairs in *xy, to be freed by free(). Errors: ERROR_FILE, ERROR_FORMAT (message: file,
 * line, reason), ERROR_MEMORY. */
btg_status points_read(const char *path, double **xy, size_t *count, btg_message *message);

#endif
