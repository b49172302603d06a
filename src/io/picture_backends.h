/* The back ends beside each other as a picture. Internal to the program. */
#ifndef BTG_IO_PICTURE_BACKENDS_H
#define BTG_IO_PICTURE_BACKENDS_H

#include "io/output.h"

#define BTG_PICTURE_PHASES 4 /* upload, device, read-back, polish */

/* One back end; NaN where it has no such. */
typedef struct btg_picture_backend {
    const char *name;
    double per_second[2];             /* positions, of a small batch and of a large one */
    double phase[BTG_PICTURE_PHASES]; /* seconds of the large batch */
    double raw_mm[2], polished_mm[2]; /* error of the drop, and of the whole as clearance */
    double bytes;
} btg_picture_backend;

/* Speeds as bars, cut by where the time went, and errors before and after the polish, both on
 * logarithmic axes. `batches`: what the two batches are called. Errors: ERROR_NOT_BUILT,
 * ERROR_FILE, ERROR_MEMORY. */
btg_status btg_picture_backends(const btg_picture_backend *list, size_t count, const char *title,
                                const char *const batches[2], btg_output *output,
                                btg_message *message);

#endif
