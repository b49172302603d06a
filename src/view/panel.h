/* Words over the picture, by Dear ImGui: labels, the position's numbers, switches, help. */
#ifndef BTG_VIEW_PANEL_H
#define BTG_VIEW_PANEL_H

#include "view/scene.h"

struct ImGuiContext;

namespace view {

struct panel {
    const btg_gl *gl = nullptr;
    ImGuiContext *context = nullptr;
    GLuint program = 0, font = 0, array = 0, buffers[2] = {0, 0};
    GLint at_size = -1;
};

/* After the context is current. False: *why. */
bool panel_open(panel *p, const btg_gl *gl, std::string *why);
void panel_close(panel *p);

/* Says what is to be seen and what is clicked, into `st`. The caller has begun the frame: display
 * size, time, mouse and keys are ImGui's. */
void panel_say(state *st, const scene &s, int width, int height);
/* camera::aside with which the panel leaves the tool's contacts to be seen; 0 where there is room.
 */
double panel_aside(const state &st, int width, int height);
/* Onto the framebuffer that is bound. */
void panel_draw(panel *p, int width, int height);

} // namespace view

#endif
