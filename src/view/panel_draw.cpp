/* Dear ImGui's triangles through the viewer's own table of functions: ImGui's own renderer looks
 * for OpenGL in libraries that are not those of a context without a window. */
#include "view/panel.h"

#include <fontconfig/fontconfig.h>
#include <imgui.h>

namespace view {

static constexpr float font_pixels = 15;

static const char vertex_text[] = R"(#version 330 core
in vec2 where;
in vec2 letter;
in vec4 tint;
uniform vec2 size;
out vec2 at;
out vec4 colour;
void main() {
    at = letter;
    colour = tint;
    gl_Position = vec4(2.0 * where.x / size.x - 1.0, 1.0 - 2.0 * where.y / size.y, 0.0, 1.0);
}
)";

static const char fragment_text[] = R"(#version 330 core
in vec2 at;
in vec4 colour;
uniform sampler2D font;
out vec4 result;
void main() {
    result = colour * texture(font, at);
}
)";

/* The system's plain face; ImGui's own, coarser, where there is none. */
static void choose_font() {
    FcPattern *pattern = FcNameParse(reinterpret_cast<const FcChar8 *>("sans-serif"));
    FcConfigSubstitute(nullptr, pattern, FcMatchPattern);
    FcDefaultSubstitute(pattern);
    FcResult found = FcResultNoMatch;
    FcPattern *match = FcFontMatch(nullptr, pattern, &found);
    FcChar8 *file = nullptr;
    ImFontAtlas *fonts = ImGui::GetIO().Fonts;
    bool good = match && FcPatternGetString(match, FC_FILE, 0, &file) == FcResultMatch &&
                FcPatternGetString(match, FC_FONTFORMAT, 0, &file) == FcResultMatch &&
                std::string(reinterpret_cast<const char *>(file)) == "TrueType" &&
                FcPatternGetString(match, FC_FILE, 0, &file) == FcResultMatch;
    if (good) good = fonts->AddFontFromFileTTF(reinterpret_cast<const char *>(file), font_pixels);
    if (!good) fonts->AddFontDefault();
    if (match) FcPatternDestroy(match);
    FcPatternDestroy(pattern);
}

static void make_font(panel *p) {
    const btg_gl *gl = p->gl;
    unsigned char *pixels;
    int width, height;
    choose_font();
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
    gl->GenTextures(1, &p->font);
    gl->BindTexture(GL_TEXTURE_2D, p->font);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
}

static void make_buffers(panel *p) {
    const btg_gl *gl = p->gl;
    gl->GenVertexArrays(1, &p->array);
    gl->GenBuffers(2, p->buffers);
    gl->BindVertexArray(p->array);
    gl->BindBuffer(GL_ARRAY_BUFFER, p->buffers[0]);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, p->buffers[1]);
    const std::size_t offset[3] = {offsetof(ImDrawVert, pos), offsetof(ImDrawVert, uv),
                                   offsetof(ImDrawVert, col)};
    for (GLuint i = 0; i < 3; i++) {
        gl->EnableVertexAttribArray(i);
        gl->VertexAttribPointer(i, i < 2 ? 2 : 4, i < 2 ? GL_FLOAT : GL_UNSIGNED_BYTE, i == 2,
                                sizeof(ImDrawVert), reinterpret_cast<const void *>(offset[i]));
    }
    gl->BindVertexArray(0);
}

static void choose_style() {
    ImGui::StyleColorsLight();
    ImGuiStyle &style = ImGui::GetStyle();
    style.WindowRounding = 6, style.FrameRounding = 4, style.GrabRounding = 4;
    style.WindowBorderSize = 0;
    style.Colors[ImGuiCol_WindowBg] = ImVec4(1, 1, 1, 0.94f);
    style.Colors[ImGuiCol_TextDisabled] = ImVec4(0.36f, 0.39f, 0.44f, 1);
    style.Colors[ImGuiCol_FrameBg] = ImVec4(0.87f, 0.90f, 0.93f, 1);
    style.Colors[ImGuiCol_Text] = ImVec4(0.13f, 0.15f, 0.18f, 1);
}

bool panel_open(panel *p, const btg_gl *gl, std::string *why) {
    *p = panel();
    p->gl = gl;
    p->program = canvas_program(gl, vertex_text, fragment_text, {"where", "letter", "tint"}, why);
    if (!p->program) return false;
    p->at_size = gl->GetUniformLocation(p->program, "size");
    p->context = ImGui::CreateContext();
    ImGui::SetCurrentContext(p->context);
    /* Nothing is kept between runs, in no file. */
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::GetIO().LogFilename = nullptr;
    choose_style();
    make_font(p);
    make_buffers(p);
    return true;
}

void panel_close(panel *p) {
    if (!p->program) return;
    p->gl->DeleteProgram(p->program);
    if (p->font) p->gl->DeleteTextures(1, &p->font);
    if (p->array) p->gl->DeleteVertexArrays(1, &p->array);
    p->gl->DeleteBuffers(2, p->buffers);
    if (p->context) ImGui::DestroyContext(p->context);
    *p = panel();
}

static void draw_list(panel *p, const ImDrawList *list, int height, float scale) {
    const btg_gl *gl = p->gl;
    gl->BufferData(GL_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(sizeof(ImDrawVert)) * list->VtxBuffer.Size,
                   list->VtxBuffer.Data, GL_STREAM_DRAW);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER,
                   static_cast<GLsizeiptr>(sizeof(ImDrawIdx)) * list->IdxBuffer.Size,
                   list->IdxBuffer.Data, GL_STREAM_DRAW);
    for (const ImDrawCmd &c : list->CmdBuffer) {
        int x = static_cast<int>(scale * c.ClipRect.x), y = static_cast<int>(scale * c.ClipRect.y);
        int right = static_cast<int>(scale * c.ClipRect.z);
        int bottom = static_cast<int>(scale * c.ClipRect.w);
        if (right <= x || bottom <= y || c.UserCallback) continue;
        gl->Scissor(x, height - bottom, right - x, bottom - y);
        gl->DrawElements(GL_TRIANGLES, static_cast<GLsizei>(c.ElemCount),
                         sizeof(ImDrawIdx) == 2 ? GL_UNSIGNED_SHORT : GL_UNSIGNED_INT,
                         reinterpret_cast<const void *>(c.IdxOffset * sizeof(ImDrawIdx)));
    }
}

void panel_draw(panel *p, int width, int height) {
    const btg_gl *gl = p->gl;
    ImDrawData *data = ImGui::GetDrawData();
    if (!data || !(data->DisplaySize.y > 0)) return;
    /* Pixels to a unit of the window's. */
    float scale = static_cast<float>(height) / data->DisplaySize.y;
    gl->Viewport(0, 0, width, height);
    gl->Disable(GL_DEPTH_TEST);
    gl->Disable(GL_CULL_FACE);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    gl->Enable(GL_SCISSOR_TEST);
    gl->UseProgram(p->program);
    gl->Uniform2f(p->at_size, data->DisplaySize.x, data->DisplaySize.y);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, p->font);
    gl->BindVertexArray(p->array);
    gl->BindBuffer(GL_ARRAY_BUFFER, p->buffers[0]);
    for (int i = 0; i < data->CmdListsCount; i++)
        draw_list(p, data->CmdLists[i], height, scale);
    gl->BindVertexArray(0);
    gl->Disable(GL_SCISSOR_TEST);
}

} // namespace view
