/* Pictures of tool paths, as PNG. Internal to the program; drawn with Cairo. */
#ifndef BTG_IO_PICTURE_H
#define BTG_IO_PICTURE_H

#include "io/output.h"

/* What is drawn of a position; NaN where a value does not exist. */
typedef struct btg_picture_mark {
    double foot_mm[2], p_mm[2], q_mm[2]; /* x and y */
    float tilt_rad;
    int8_t status; /* btg_status */
} btg_picture_mark;

/* The positions of a picture; zeroed when empty. */
typedef struct btg_picture {
    btg_picture_mark *marks;
    size_t count, capacity;
    bool short_of_memory; /* latched, told by btg_picture_write */
} btg_picture;

/* False in a build without Cairo: then btg_picture_write is ERROR_NOT_BUILT. */
bool btg_picture_available(void);

void btg_picture_add(btg_picture *picture, const btg_position *position);
void btg_picture_release(btg_picture *picture);

/* A top view of the part (shaded, with lines of equal height) under the path: footprint, contacts
 * P and Q joined, osculating and single contacts marked apart; beside it the legend with counts,
 * the colours of the heights, how the tilt is spread, and the tool. 1400 pixels wide, 800 to 1000
 * high. `title` is UTF-8. Errors: ERROR_NOT_BUILT, ERROR_FILE, ERROR_MEMORY. */
btg_status btg_picture_write(const btg_picture *picture, btg_output *output, const btg_part *part,
                             const btg_tool *tool, const char *title, btg_message *message);

#endif
