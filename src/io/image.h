/* Pixels as a PNG file. Internal to the program. */
#ifndef BTG_IO_IMAGE_H
#define BTG_IO_IMAGE_H

#include "io/output.h"

/* `rgb`: 3 bytes a pixel, rows from the top. ERROR_FILE, ERROR_MEMORY. */
btg_status btg_image_write(const unsigned char *rgb, int width, int height, btg_output *output,
                           btg_message *message);

#endif
