#include "view/frame.h"
#include "view/pose.h"

extern "C" {
#include "backend/context/context.h"
#include "io/image.h"
}

#include <imgui.h>

namespace view {

bool draw_frame(scene *s, panel *p, state *st, int width, int height, frame_facts *facts,
                std::string *why) {
    st->aspect = double(width) / height;
    ImVec2 room = ImGui::GetIO().DisplaySize;
    st->eye.aside = panel_aside(*st, static_cast<int>(room.x), static_cast<int>(room.y));
    if (!canvas_begin(s->on, width, height, why) || !scene_update(s, *st, why)) return false;
    scene_draw(s, *st);
    canvas_flatten(s->on);
    panel_say(st, *s, static_cast<int>(room.x), static_cast<int>(room.y));
    ImGui::Render();
    panel_draw(p, width, height);
    const btg_row *row = current(*st);
    pose at = row ? pose_of(st->part->tool, row->position) : pose();
    glm::dvec2 size(width, height);
    facts->p_pixel = at.has_p ? scene_project(*s, size, at.p) : glm::dvec3(0, 0, -1);
    facts->q_pixel = at.has_q ? scene_project(*s, size, at.q) : glm::dvec3(0, 0, -1);
    facts->target_pixel = {size.x * (0.5 - st->eye.aside), 0.5 * size.y, 0};
    facts->frames++;
    return true;
}

static btg_status render(const btg_gl *gl, state *st, int width, int height, picture *out,
                         frame_facts *facts, btg_message *message) {
    canvas c;
    scene s;
    std::string why;
    s.on = &c;
    panel p;
    bool drawn = canvas_open(&c, gl, &why) && panel_open(&p, gl, &why);
    /* Windows know their size from the frame before. */
    for (int i = 0; i < 3 && drawn; i++) {
        ImGui::GetIO().DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
        ImGui::NewFrame();
        drawn = draw_frame(&s, &p, st, width, height, facts, &why);
    }
    if (drawn) *out = canvas_read(&c);
    panel_close(&p);
    scene_free(&s);
    canvas_close(&c);
    if (drawn) return BTG_OK;
    return say(message, BTG_ERROR_DEVICE, "view: " + why);
}

btg_status render_picture(state *st, int width, int height, picture *out, frame_facts *facts,
                          btg_message *message) {
    btg_allocator allocator = {};
    btg_context *context = nullptr;
    btg_status status = btg_context_open(nullptr, &allocator, &context, message);
    if (status != BTG_OK) return status;
    status = btg_context_enter(context);
    if (status == BTG_OK) {
        status = render(btg_context_gl(context), st, width, height, out, facts, message);
        btg_context_leave(context);
    } else {
        say(message, status, "view: the OpenGL context refuses to start");
    }
    btg_context_close(context);
    return status;
}

btg_status save_picture(const picture &p, const char *file, btg_message *message) {
    btg_output output;
    btg_status status = btg_output_open(&output, file, message);
    if (status != BTG_OK) return status;
    status = btg_image_write(p.rgb.data(), p.width, p.height, &output, message);
    if (status == BTG_OK) status = btg_output_finish(&output, message);
    if (status == BTG_OK) status = btg_output_commit(&output, message);
    btg_output_discard(&output);
    return status;
}

} // namespace view
