/* Stands in for cmd_view.cpp in a build without it. */
#include "app/app.h"

#include <string.h>

int app_view(int count, char **words) {
    for (int i = 0; i < count; i++)
        if (strcmp(words[i], "--help") == 0 || strcmp(words[i], "-h") == 0) return app_help("view");
    return app_complain(APP_FAILED, "view: not in this build; install libglfw3-dev, libglm-dev, "
                                    "libimgui-dev and build again with -Dview=enabled");
}
