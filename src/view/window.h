/* The window, by GLFW: mouse, keys, dropped files, playing. */
#ifndef BTG_VIEW_WINDOW_H
#define BTG_VIEW_WINDOW_H

#include "view/frame.h"

namespace view {

struct window_def {
    int width, height; /* of the window; of the picture where the display has other pixels */
    const path_options *options;
    std::vector<std::string> keys; /* pressed one a frame from the start */
};

/* Until the user, or a key, quits. ERROR_NO_DEVICE: no display, or no OpenGL 3.3 on it. */
btg_status show_window(state *st, const window_def &def, frame_facts *facts, btg_message *message);

} // namespace view

#endif
