/* What a picture is drawn with: OpenGL 3.3, whatever the window or the context. Objects belong to
 * the context that is current when they are made and freed. */
#ifndef BTG_VIEW_CANVAS_H
#define BTG_VIEW_CANVAS_H

#include "view/shapes.h"

extern "C" {
#include "backend/context/gl.h"
}

#include <string>
#include <vector>

namespace view {

/* Triangles or lines on the device. */
struct buffer {
    GLuint array = 0, points = 0, indices = 0;
    GLsizei count = 0; /* of indices, or of the lines' ends */
};

/* How something is drawn. */
struct ink {
    glm::vec4 colour{1};
    bool lit = true;
    bool behind = false; /* only where something stands before it */
    bool mapped = false; /* the map's colour where the map has one */
};

/* A texture over the part's x and y, relative to the scene's origin. */
struct ground_map {
    GLuint texture = 0;
    glm::vec4 rectangle{0}; /* x, y of the lower left; 1 / width, 1 / height */
};

/* RGB, rows from the top. */
struct picture {
    int width = 0, height = 0;
    std::vector<unsigned char> rgb;
};

struct canvas {
    const btg_gl *gl = nullptr;
    GLuint program = 0;
    GLint at_matrix = -1, at_model = -1, at_colour = -1, at_eye = -1, at_kind = -1, at_map = -1;
    GLuint framebuffer[2] = {0, 0}, target[3] = {0, 0, 0}; /* many samples, one */
    int width = 0, height = 0;
    glm::mat4 matrix{1};
    glm::vec3 eye{0};
    ground_map map;
};

/* False: *why says what the driver refused. */
bool canvas_open(canvas *c, const btg_gl *gl, std::string *why);
void canvas_close(canvas *c);

buffer canvas_triangles(canvas *c, const mesh &m);
/* Two ends a line, one pixel wide. */
buffer canvas_lines(canvas *c, const std::vector<glm::vec3> &ends);
void canvas_free(canvas *c, buffer *b);
/* RGBA, rows along +y. */
void canvas_set_map(canvas *c, int width, int height, const unsigned char *rgba,
                    glm::vec4 rectangle);
void canvas_free_map(canvas *c);

/* Makes the target of this size and clears it, light above and darker below. */
bool canvas_begin(canvas *c, int width, int height, std::string *why);
void canvas_draw(canvas *c, const buffer &b, const glm::mat4 &model, const ink &i);
/* See-through: far sides first, then near ones, without hiding what comes later. */
void canvas_draw_clear(canvas *c, const buffer &b, const glm::mat4 &model, const ink &i);
void canvas_draw_lines(canvas *c, const buffer &b, const ink &i);
void canvas_draw_once(canvas *c, const mesh &m, const ink &i);
/* Many samples become one; what is drawn afterwards lies on top of it all. */
void canvas_flatten(canvas *c);
/* To the framebuffer numbered 0, the window's. */
void canvas_show(canvas *c);
picture canvas_read(canvas *c);

/* A program of a vertex and a fragment shader, `names` bound to attributes 0, 1, ...; 0: *why. */
GLuint canvas_program(const btg_gl *gl, const char *vertex, const char *fragment,
                      const std::vector<const char *> &names, std::string *why);

} // namespace view

#endif
