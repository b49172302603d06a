/* Stands in for picture.c, picture_backends.c and map_picture.c in a build without Cairo. */
#include "io/map.h"
#include "io/picture.h"
#include "io/picture_backends.h"
#include "core/part.h"

bool btg_picture_available(void) {
    return false;
}

void btg_picture_add(btg_picture *picture, const btg_position *position) {
    (void)picture, (void)position;
}

void btg_picture_release(btg_picture *picture) {
    (void)picture;
}

btg_status btg_picture_write(const btg_picture *picture, btg_output *output, const btg_part *part,
                             const btg_tool *tool, const char *title, btg_message *message) {
    (void)picture, (void)output, (void)part, (void)tool, (void)title;
    return btg_fail(message, BTG_ERROR_NOT_BUILT,
                    "picture: this build draws none; install libcairo2-dev and build again");
}

btg_status btg_map_png(const btg_verify_map *map, const btg_verify_result *result,
                       const btg_map_scale *scale, const char *title, btg_output *output,
                       btg_message *message) {
    (void)map, (void)result, (void)scale, (void)title, (void)output;
    return btg_fail(message, BTG_ERROR_NOT_BUILT,
                    "picture: this build draws none; install libcairo2-dev and build again");
}

btg_status btg_picture_backends(const btg_picture_backend *list, size_t count, const char *title,
                                const char *const batches[2], btg_output *output,
                                btg_message *message) {
    (void)list, (void)count, (void)title, (void)batches, (void)output;
    return btg_fail(message, BTG_ERROR_NOT_BUILT,
                    "picture: this build draws none; install libcairo2-dev and build again");
}
