/* Stands in for picture.c, picture_backends.c and map_picture.c in a build without Cairo. */
#include "io/chart.h"
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

btg_chart_panel btg_chart_panel_of(const char *title, const char *x_name, const char *y_name) {
    return (btg_chart_panel){.title = title, .x_name = x_name, .y_name = y_name};
}

bool btg_chart_add(btg_chart_panel *panel, btg_chart_kind kind, int ink, const char *name,
                   const double *x, const double *y, size_t count) {
    (void)panel, (void)kind, (void)ink, (void)name, (void)x, (void)y, (void)count;
    return false;
}

btg_status btg_chart_write(const char *path, const char *title, const btg_chart_panel *panels,
                           size_t panel_count, size_t columns, btg_message *message) {
    (void)path, (void)title, (void)panels, (void)panel_count, (void)columns;
    return btg_fail(message, BTG_ERROR_NOT_BUILT,
                    "picture: this build draws none; install libcairo2-dev and build again");
}
