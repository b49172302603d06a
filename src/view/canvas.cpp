#include "view/canvas.h"

#include <algorithm>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>

namespace view {

static constexpr int samples_wanted = 4;

static const char vertex_text[] = R"(#version 330 core
in vec3 point;
in vec3 normal;
uniform mat4 matrix;
uniform mat4 model;
out vec3 at;
out vec3 up;
void main() {
    vec4 p = model * vec4(point, 1.0);
    at = p.xyz;
    up = mat3(model) * normal;
    gl_Position = matrix * p;
}
)";

/* Both sides are lit alike: a part's orientation says nothing. A lamp over the viewer's left
 * shoulder, a weak one from the eye, light from the sky. */
static const char fragment_text[] = R"(#version 330 core
in vec3 at;
in vec3 up;
uniform vec4 colour;
uniform vec3 eye;
uniform ivec2 kind; /* lit, mapped */
uniform vec4 map_rectangle;
uniform sampler2D map;
out vec4 result;
void main() {
    vec4 base = colour;
    if (kind.y != 0) {
        vec2 where = (at.xy - map_rectangle.xy) * map_rectangle.zw;
        vec4 there = texture(map, where);
        bool inside = all(greaterThanEqual(where, vec2(0.0))) && all(lessThanEqual(where, vec2(1.0)));
        if (inside && there.a > 0.5) base.rgb = there.rgb / there.a;
    }
    if (kind.x == 0) {
        result = base;
        return;
    }
    vec3 n = normalize(up);
    vec3 ahead = normalize(eye - at);
    if (dot(n, ahead) < 0.0) n = -n;
    vec3 lamp = normalize(vec3(-0.35, -0.30, 0.89));
    float sky = 0.5 + 0.5 * n.z;
    float light = 0.28 + 0.12 * sky + 0.42 * max(dot(n, lamp), 0.0) + 0.18 * dot(n, ahead);
    float shine = pow(max(dot(reflect(-lamp, n), ahead), 0.0), 30.0);
    result = vec4(base.rgb * light + 0.07 * shine, base.a);
}
)";

static GLuint shader(const btg_gl *gl, GLenum kind, const char *text, std::string *why) {
    GLuint s = gl->CreateShader(kind);
    GLint good = 0;
    gl->ShaderSource(s, 1, &text, nullptr);
    gl->CompileShader(s);
    gl->GetShaderiv(s, GL_COMPILE_STATUS, &good);
    if (good) return s;
    char log[400] = "";
    gl->GetShaderInfoLog(s, sizeof log, nullptr, log);
    gl->DeleteShader(s);
    *why = std::string("the driver refuses a shader: ") + log;
    return 0;
}

GLuint canvas_program(const btg_gl *gl, const char *vertex, const char *fragment,
                      const std::vector<const char *> &names, std::string *why) {
    GLuint v = shader(gl, GL_VERTEX_SHADER, vertex, why);
    GLuint f = v ? shader(gl, GL_FRAGMENT_SHADER, fragment, why) : 0;
    if (!v || !f) {
        if (v) gl->DeleteShader(v);
        return 0;
    }
    GLuint p = gl->CreateProgram();
    GLint good = 0;
    gl->AttachShader(p, v);
    gl->AttachShader(p, f);
    for (std::size_t i = 0; i < names.size(); i++)
        gl->BindAttribLocation(p, static_cast<GLuint>(i), names[i]);
    gl->LinkProgram(p);
    gl->GetProgramiv(p, GL_LINK_STATUS, &good);
    gl->DeleteShader(v);
    gl->DeleteShader(f);
    if (good) return p;
    gl->DeleteProgram(p);
    *why = "the driver cannot link a shader program";
    return 0;
}

bool canvas_open(canvas *c, const btg_gl *gl, std::string *why) {
    *c = canvas();
    c->gl = gl;
    c->program = canvas_program(gl, vertex_text, fragment_text, {"point", "normal"}, why);
    if (!c->program) return false;
    c->at_matrix = gl->GetUniformLocation(c->program, "matrix");
    c->at_model = gl->GetUniformLocation(c->program, "model");
    c->at_colour = gl->GetUniformLocation(c->program, "colour");
    c->at_eye = gl->GetUniformLocation(c->program, "eye");
    c->at_kind = gl->GetUniformLocation(c->program, "kind");
    c->at_map = gl->GetUniformLocation(c->program, "map_rectangle");
    return true;
}

static void free_target(canvas *c) {
    c->gl->DeleteFramebuffers(2, c->framebuffer);
    c->gl->DeleteRenderbuffers(3, c->target);
    std::fill_n(c->framebuffer, 2, 0u);
    std::fill_n(c->target, 3, 0u);
    c->width = c->height = 0;
}

void canvas_close(canvas *c) {
    if (!c->gl) return;
    free_target(c);
    canvas_free_map(c);
    c->gl->DeleteProgram(c->program);
    *c = canvas();
}

/* ---- what is drawn ------------------------------------------------------------------------ */

static void attribute(const btg_gl *gl, GLuint number, std::size_t stride, std::size_t offset) {
    gl->EnableVertexAttribArray(number);
    gl->VertexAttribPointer(number, 3, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                            reinterpret_cast<const void *>(offset));
}

static void fill(const btg_gl *gl, GLenum kind, GLuint *name, std::size_t bytes, const void *data) {
    gl->GenBuffers(1, name);
    gl->BindBuffer(kind, *name);
    gl->BufferData(kind, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
}

buffer canvas_triangles(canvas *c, const mesh &m) {
    buffer b;
    if (m.indices.empty()) return b;
    c->gl->GenVertexArrays(1, &b.array);
    c->gl->BindVertexArray(b.array);
    fill(c->gl, GL_ARRAY_BUFFER, &b.points, m.vertices.size() * sizeof(vertex), m.vertices.data());
    attribute(c->gl, 0, sizeof(vertex), offsetof(vertex, point));
    attribute(c->gl, 1, sizeof(vertex), offsetof(vertex, normal));
    fill(c->gl, GL_ELEMENT_ARRAY_BUFFER, &b.indices, m.indices.size() * sizeof(std::uint32_t),
         m.indices.data());
    c->gl->BindVertexArray(0);
    b.count = static_cast<GLsizei>(m.indices.size());
    return b;
}

buffer canvas_lines(canvas *c, const std::vector<glm::vec3> &points) {
    buffer b;
    if (points.empty()) return b;
    c->gl->GenVertexArrays(1, &b.array);
    c->gl->BindVertexArray(b.array);
    fill(c->gl, GL_ARRAY_BUFFER, &b.points, points.size() * sizeof(glm::vec3), points.data());
    attribute(c->gl, 0, sizeof(glm::vec3), 0);
    c->gl->BindVertexArray(0);
    b.count = static_cast<GLsizei>(points.size());
    return b;
}

void canvas_free(canvas *c, buffer *b) {
    if (!b->array) return;
    c->gl->DeleteVertexArrays(1, &b->array);
    c->gl->DeleteBuffers(1, &b->points);
    if (b->indices) c->gl->DeleteBuffers(1, &b->indices);
    *b = buffer();
}

void canvas_set_map(canvas *c, int width, int height, const unsigned char *rgba,
                    glm::vec4 rectangle) {
    const btg_gl *gl = c->gl;
    canvas_free_map(c);
    gl->GenTextures(1, &c->map.texture);
    gl->BindTexture(GL_TEXTURE_2D, c->map.texture);
    gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl->TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    c->map.rectangle = rectangle;
}

void canvas_free_map(canvas *c) {
    if (c->map.texture) c->gl->DeleteTextures(1, &c->map.texture);
    c->map = ground_map();
}

/* ---- the target --------------------------------------------------------------------------- */

static bool make_target(canvas *c, int width, int height, std::string *why) {
    const btg_gl *gl = c->gl;
    free_target(c);
    GLint most = 1;
    gl->GetIntegerv(GL_MAX_SAMPLES, &most);
    GLsizei samples = std::min(most, samples_wanted);
    gl->GenFramebuffers(2, c->framebuffer);
    gl->GenRenderbuffers(3, c->target);
    const GLenum format[3] = {GL_RGBA8, GL_DEPTH_COMPONENT24, GL_RGBA8};
    for (int i = 0; i < 3; i++) {
        gl->BindRenderbuffer(GL_RENDERBUFFER, c->target[i]);
        gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, i < 2 ? samples : 0, format[i], width,
                                           height);
        gl->BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer[i / 2]);
        gl->FramebufferRenderbuffer(GL_FRAMEBUFFER,
                                    i == 1 ? GL_DEPTH_ATTACHMENT : GL_COLOR_ATTACHMENT0,
                                    GL_RENDERBUFFER, c->target[i]);
    }
    for (int i = 0; i < 2; i++) {
        gl->BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer[i]);
        if (gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) continue;
        free_target(c);
        *why = "the driver refuses a picture of that size; give a smaller one";
        return false;
    }
    c->width = width, c->height = height;
    return true;
}

bool canvas_begin(canvas *c, int width, int height, std::string *why) {
    const btg_gl *gl = c->gl;
    if ((c->width != width || c->height != height) && !make_target(c, width, height, why))
        return false;
    gl->BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer[0]);
    gl->Viewport(0, 0, width, height);
    gl->Disable(GL_SCISSOR_TEST);
    gl->Disable(GL_BLEND);
    gl->Disable(GL_CULL_FACE);
    gl->DepthMask(GL_TRUE);
    gl->ClearColor(0.965f, 0.972f, 0.98f, 1);
    gl->ClearDepth(1);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(GL_LEQUAL);
    gl->BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    /* Lines that lie on faces are seen. */
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    gl->PolygonOffset(1, 1);
    return true;
}

static void use(canvas *c, const glm::mat4 &model, const ink &i) {
    const btg_gl *gl = c->gl;
    gl->UseProgram(c->program);
    gl->UniformMatrix4fv(c->at_matrix, 1, GL_FALSE, glm::value_ptr(c->matrix));
    gl->UniformMatrix4fv(c->at_model, 1, GL_FALSE, glm::value_ptr(model));
    gl->Uniform4fv(c->at_colour, 1, glm::value_ptr(i.colour));
    gl->Uniform3f(c->at_eye, c->eye.x, c->eye.y, c->eye.z);
    bool mapped = i.mapped && c->map.texture;
    gl->Uniform2i(c->at_kind, i.lit, mapped);
    if (mapped) {
        gl->ActiveTexture(GL_TEXTURE0);
        gl->BindTexture(GL_TEXTURE_2D, c->map.texture);
        gl->Uniform4fv(c->at_map, 1, glm::value_ptr(c->map.rectangle));
    }
    gl->DepthFunc(i.behind ? GL_GREATER : GL_LEQUAL);
    bool clear = i.colour.a < 1;
    gl->DepthMask(clear || i.behind ? GL_FALSE : GL_TRUE);
    if (clear)
        gl->Enable(GL_BLEND);
    else
        gl->Disable(GL_BLEND);
}

void canvas_draw(canvas *c, const buffer &b, const glm::mat4 &model, const ink &i) {
    if (!b.array) return;
    use(c, model, i);
    c->gl->BindVertexArray(b.array);
    c->gl->DrawElements(GL_TRIANGLES, b.count, GL_UNSIGNED_INT, nullptr);
    c->gl->BindVertexArray(0);
}

void canvas_draw_clear(canvas *c, const buffer &b, const glm::mat4 &model, const ink &i) {
    c->gl->Enable(GL_CULL_FACE);
    for (GLenum side : {GL_FRONT, GL_BACK}) {
        c->gl->CullFace(side);
        canvas_draw(c, b, model, i);
    }
    c->gl->Disable(GL_CULL_FACE);
}

void canvas_draw_lines(canvas *c, const buffer &b, const ink &i) {
    if (!b.array) return;
    use(c, glm::mat4(1), i);
    c->gl->BindVertexArray(b.array);
    c->gl->DrawArrays(GL_LINES, 0, b.count);
    c->gl->BindVertexArray(0);
}

void canvas_draw_once(canvas *c, const mesh &m, const ink &i) {
    buffer b = canvas_triangles(c, m);
    canvas_draw(c, b, glm::mat4(1), i);
    canvas_free(c, &b);
}

void canvas_flatten(canvas *c) {
    const btg_gl *gl = c->gl;
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, c->framebuffer[0]);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, c->framebuffer[1]);
    gl->BlitFramebuffer(0, 0, c->width, c->height, 0, 0, c->width, c->height, GL_COLOR_BUFFER_BIT,
                        GL_NEAREST);
    gl->BindFramebuffer(GL_FRAMEBUFFER, c->framebuffer[1]);
    gl->Disable(GL_DEPTH_TEST);
    gl->DepthMask(GL_TRUE);
}

void canvas_show(canvas *c) {
    const btg_gl *gl = c->gl;
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, c->framebuffer[1]);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    gl->BlitFramebuffer(0, 0, c->width, c->height, 0, 0, c->width, c->height, GL_COLOR_BUFFER_BIT,
                        GL_NEAREST);
}

picture canvas_read(canvas *c) {
    const btg_gl *gl = c->gl;
    picture p;
    p.width = c->width, p.height = c->height;
    std::size_t row = 3 * static_cast<std::size_t>(p.width);
    p.rgb.resize(row * static_cast<std::size_t>(p.height));
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, c->framebuffer[1]);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->ReadPixels(0, 0, p.width, p.height, GL_RGB, GL_UNSIGNED_BYTE, p.rgb.data());
    for (int top = 0, bottom = p.height - 1; top < bottom; top++, bottom--)
        std::swap_ranges(p.rgb.begin() + static_cast<std::ptrdiff_t>(row) * top,
                         p.rgb.begin() + static_cast<std::ptrdiff_t>(row) * (top + 1),
                         p.rgb.begin() + static_cast<std::ptrdiff_t>(row) * bottom);
    return p;
}

} // namespace view
