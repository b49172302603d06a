/* One picture without a window. */
#ifndef BTG_VIEW_FRAME_H
#define BTG_VIEW_FRAME_H

#include "view/panel.h"

namespace view {

/* What a finished frame tells of itself, for --json. */
struct frame_facts {
    glm::dvec3 p_pixel{0, 0, -1}, q_pixel{0, 0, -1}, target_pixel{0};
    std::size_t frames = 0;
};

/* Draws part, tool, path and, between ImGui::NewFrame and here, the panel into the target of `s`;
 * afterwards canvas_read has it. */
bool draw_frame(scene *s, panel *p, state *st, int width, int height, frame_facts *facts,
                std::string *why);

/* Off screen, by OSMesa or EGL. */
btg_status render_picture(state *st, int width, int height, picture *out, frame_facts *facts,
                          btg_message *message);

/* Writes a picture under its name, whole or not at all. */
btg_status save_picture(const picture &p, const char *file, btg_message *message);

} // namespace view

#endif
