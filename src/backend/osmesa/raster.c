#include "backend/osmesa/raster.h"
#include "core/part.h"

#include <string.h>

#include "raster_drop.h"
#include "raster_tilt.h"
#include "raster_reduce.h"
#include "raster_vertex.h"

#define INDICES 6 /* a cell */
/* Of the workgroup that looks through a tile; more than that where a tile is wider. */
#define LANES       16
#define LANES_LARGE 1024
#define LARGE_TILE  512

_Static_assert(sizeof(btg_raster_tile) == 48, "layout");
_Static_assert(sizeof(btg_raster_pass) == 32, "layout");
_Static_assert(sizeof(btg_raster_pick) == 16, "layout");

static btg_status status_of(GLenum error) {
    if (error == GL_NO_ERROR) return BTG_OK;
    return error == GL_OUT_OF_MEMORY ? BTG_ERROR_MEMORY : BTG_ERROR_DEVICE;
}

btg_status btg_raster_limits(const btg_context *context, size_t *buffer_bytes, uint32_t *side,
                             btg_message *message) {
    const btg_gl *gl = btg_context_gl(context);
    GLint64 bytes = 0;
    GLint texture = 0, view[2] = {0, 0}, blocks = 0;
    gl->GetIntegerv(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, &blocks);
    if (!btg_context_extension(context, "GL_ARB_gl_spirv") || blocks < 4) {
        return btg_fail(message, BTG_ERROR_NO_DEVICE,
                        "osmesa: %.100s has no GL_ARB_gl_spirv or no buffers for vertices; a newer "
                        "driver has",
                        btg_context_name(context));
    }
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    gl->GetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
    gl->GetIntegerv(GL_MAX_VIEWPORT_DIMS, view);
    for (int i = 0; i < 2; i++)
        if (view[i] < texture) texture = view[i];
    *buffer_bytes = bytes > 0 ? (size_t)bytes : 0;
    *side = texture > 0 ? (uint32_t)texture : 0;
    return BTG_OK;
}

/* ---- programs ----------------------------------------------------------------------------- */

#define CONSTANTS 4 /* of a shader, at the most */

/* `constants`: for the specialization constants 0 to count - 1. */
static GLuint make_shader(const btg_gl *gl, GLenum kind, const uint32_t *code, size_t size,
                          const GLuint *constants, GLuint count) {
    static const GLuint index[CONSTANTS] = {0, 1, 2, 3};
    GLint compiled = GL_FALSE;
    GLuint shader = gl->CreateShader(kind);
    gl->ShaderBinary(1, &shader, GL_SHADER_BINARY_FORMAT_SPIR_V, code, (GLsizei)size);
    gl->SpecializeShaderARB(shader, "main", count, index, constants);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled) return shader;
    gl->DeleteShader(shader);
    return 0;
}

/* Shaders as programs use them; 0: none. Takes them over. */
static GLuint link_program(const btg_gl *gl, const GLuint *shaders, int count) {
    GLint linked = GL_FALSE;
    GLuint program = gl->CreateProgram();
    bool all = true;
    for (int i = 0; i < count; i++) {
        all = all && shaders[i];
        if (shaders[i]) gl->AttachShader(program, shaders[i]);
    }
    if (all) {
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    }
    for (int i = 0; i < count; i++)
        gl->DeleteShader(shaders[i]);
    if (linked) return program;
    gl->DeleteProgram(program);
    return 0;
}

#define SHADER(kind, code, constants, count)                                                       \
    make_shader(gl, kind, code, sizeof code, constants, count)

static GLuint bits_of(float value) {
    GLuint bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* The shader of pixels, made for this tool: raster.glsl says what is what. */
static GLuint make_pixels(const btg_raster *r, btg_op op, const btg_gpu_scene *scene) {
    const btg_gl *gl = r->gl;
    const btg_gpu_vec4 cutter = scene->element[0];
    const GLuint constants[CONSTANTS] = {bits_of(cutter.x), bits_of(cutter.y), scene->counts.w,
                                         scene->counts.z};
    if (op == BTG_OP_DROP) return SHADER(GL_FRAGMENT_SHADER, raster_drop, constants, CONSTANTS);
    return SHADER(GL_FRAGMENT_SHADER, raster_tilt, constants, CONSTANTS);
}

/* `group`: lanes that look through a tile. */
static bool make_programs(btg_raster *r, const btg_gpu_scene *scene, GLuint group) {
    const btg_gl *gl = r->gl;
    bool all = true;
    for (int op = 0; op < 2; op++) {
        GLuint draws[2] = {SHADER(GL_VERTEX_SHADER, raster_vertex, NULL, 0), 0};
        draws[1] = make_pixels(r, (btg_op)op, scene);
        r->program[op] = link_program(gl, draws, 2);
        all = all && r->program[op];
    }
    GLuint reduce = SHADER(GL_COMPUTE_SHADER, raster_reduce, &group, 1);
    r->reduce = link_program(gl, &reduce, 1);
    return all && r->reduce;
}

/* ---- buffers and atlas -------------------------------------------------------------------- */

static void fill_buffer(const btg_raster *r, btg_raster_buffer which, size_t size,
                        const void *data) {
    r->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, r->buffer[which]);
    r->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_STREAM_DRAW);
}

/* Of what was filled before with no less. */
static void refill_buffer(const btg_raster *r, btg_raster_buffer which, size_t size,
                          const void *data) {
    r->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, r->buffer[which]);
    r->gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)size, data);
}

/* The scene's geometry, and room for pieces behind it, where a cell could stand. */
static size_t fill_geometry(btg_raster *r, const btg_scene *scene) {
    size_t start = scene->head.starts.x, cells = scene->count - start;
    cells = (cells + BTG_GPU_CELL - 1) / BTG_GPU_CELL;
    r->first_piece = (uint32_t)cells;
    r->pieces_at = (start + cells * BTG_GPU_CELL) * sizeof(btg_gpu_vec4);
    size_t size = r->pieces_at + (size_t)BTG_RASTER_DRAW * BTG_GPU_CELL * sizeof(btg_gpu_vec4);
    fill_buffer(r, BTG_RASTER_BUFFER_GEOMETRY, size, NULL);
    refill_buffer(r, BTG_RASTER_BUFFER_GEOMETRY, scene->count * sizeof *scene->geometry,
                  scene->geometry);
    return size;
}

static void fill_corners(const btg_raster *r) {
    static const GLuint corner[INDICES] = {0, 1, 2, 2, 1, 3};
    const btg_gl *gl = r->gl;
    const GLsizeiptr size = (GLsizeiptr)(BTG_RASTER_DRAW * INDICES * sizeof(GLuint));
    gl->BindVertexArray(r->vertices);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, r->buffer[BTG_RASTER_BUFFER_CORNERS]);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, size, NULL, GL_STATIC_DRAW);
    GLuint *index =
        gl->MapBufferRange(GL_ELEMENT_ARRAY_BUFFER, 0, size, GL_MAP_WRITE_BIT); /* or an error */
    if (!index) return;
    for (GLuint i = 0; i < BTG_RASTER_DRAW * INDICES; i++)
        index[i] = i / INDICES * 4 + corner[i % INDICES];
    gl->UnmapBuffer(GL_ELEMENT_ARRAY_BUFFER);
}

static GLuint make_texture(const btg_raster *r, GLenum format) {
    GLuint texture = 0;
    r->gl->GenTextures(1, &texture);
    r->gl->BindTexture(GL_TEXTURE_2D, texture);
    r->gl->TexStorage2D(GL_TEXTURE_2D, 1, format, (GLsizei)r->side, (GLsizei)r->side);
    r->gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    r->gl->TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

static bool make_atlas(btg_raster *r) {
    const btg_gl *gl = r->gl;
    const GLenum colour = GL_COLOR_ATTACHMENT0;
    r->depth = make_texture(r, GL_DEPTH_COMPONENT32F);
    r->place = make_texture(r, GL_RG32UI);
    gl->GenFramebuffers(1, &r->frame);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->frame);
    gl->FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, r->depth, 0);
    gl->FramebufferTexture(GL_FRAMEBUFFER, colour, r->place, 0);
    gl->DrawBuffers(1, &colour);
    return gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
}

/* The context is this back end's alone: what is set here holds. */
static void set_state(const btg_raster *r) {
    const btg_gl *gl = r->gl;
    gl->Viewport(0, 0, (GLsizei)r->side, (GLsizei)r->side);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_SCISSOR_TEST);
    gl->DepthFunc(GL_LESS);
    gl->BindVertexArray(r->vertices);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->frame);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, r->depth);
    gl->ActiveTexture(GL_TEXTURE1);
    gl->BindTexture(GL_TEXTURE_2D, r->place);
    const struct {
        GLenum target;
        GLuint at;
        btg_raster_buffer buffer;
    } bindings[] = {
        {GL_UNIFORM_BUFFER, BTG_GPU_SCENE, BTG_RASTER_BUFFER_SCENE},
        {GL_UNIFORM_BUFFER, BTG_RASTER_PASS, BTG_RASTER_BUFFER_PASS},
        {GL_SHADER_STORAGE_BUFFER, BTG_GPU_GEOMETRY, BTG_RASTER_BUFFER_GEOMETRY},
        {GL_SHADER_STORAGE_BUFFER, BTG_GPU_QUERIES, BTG_RASTER_BUFFER_QUERIES},
        {GL_SHADER_STORAGE_BUFFER, BTG_RASTER_TILES, BTG_RASTER_BUFFER_TILES},
        {GL_SHADER_STORAGE_BUFFER, BTG_RASTER_LIST, BTG_RASTER_BUFFER_LIST},
        {GL_SHADER_STORAGE_BUFFER, BTG_RASTER_PICKS, BTG_RASTER_BUFFER_PICKS},
    };
    for (size_t i = 0; i < sizeof bindings / sizeof *bindings; i++)
        gl->BindBufferBase(bindings[i].target, bindings[i].at, r->buffer[bindings[i].buffer]);
}

btg_status btg_raster_load(btg_raster *r, const btg_context *context, const btg_scene *scene,
                           uint32_t side, uint32_t window, size_t *bytes, btg_message *message) {
    const btg_gl *gl = btg_context_gl(context);
    *r = (btg_raster){.gl = gl, .side = side};
    if (!make_programs(r, &scene->head, window > LARGE_TILE ? LANES_LARGE : LANES)) {
        return btg_fail(message, BTG_ERROR_DEVICE,
                        "osmesa: %.100s does not take the shaders; try another --backend",
                        btg_context_name(context));
    }
    gl->GenVertexArrays(1, &r->vertices);
    gl->GenBuffers(BTG_RASTER_BUFFERS, r->buffer);
    fill_buffer(r, BTG_RASTER_BUFFER_SCENE, sizeof scene->head, &scene->head);
    fill_buffer(r, BTG_RASTER_BUFFER_LIST, BTG_RASTER_DRAW * sizeof(btg_raster_entry), NULL);
    size_t geometry = fill_geometry(r, scene);
    fill_corners(r);
    bool made = make_atlas(r);
    btg_status status = status_of(gl->GetError());
    if (status == BTG_OK && !made) status = BTG_ERROR_DEVICE;
    if (status != BTG_OK) {
        return btg_fail(message, status, "osmesa: no room for the part (%zu MB) and %u x %u pixels",
                        geometry >> 20, (unsigned)side, (unsigned)side);
    }
    set_state(r);
    *bytes = geometry + (size_t)side * side * (sizeof(float) + 2 * sizeof(uint32_t));
    return BTG_OK;
}

void btg_raster_unload(btg_raster *r) {
    const btg_gl *gl = r->gl;
    if (!gl) return;
    gl->DeleteProgram(r->program[0]);
    gl->DeleteProgram(r->program[1]);
    gl->DeleteProgram(r->reduce);
    gl->DeleteBuffers(BTG_RASTER_BUFFERS, r->buffer);
    gl->DeleteVertexArrays(1, &r->vertices);
    gl->DeleteFramebuffers(1, &r->frame);
    gl->DeleteTextures(1, &r->depth);
    gl->DeleteTextures(1, &r->place);
    *r = (btg_raster){0};
}

/* ---- a pass ------------------------------------------------------------------------------- */

uint32_t btg_raster_capacity(const btg_raster *r, uint32_t pixels) {
    uint32_t row = r->side / pixels;
    return row * row;
}

void btg_raster_queries(const btg_raster *r, const btg_gpu_query *queries, size_t count) {
    fill_buffer(r, BTG_RASTER_BUFFER_QUERIES, count * sizeof *queries, queries);
}

void btg_raster_begin(const btg_raster *r, btg_op op, const btg_raster_pass *pass,
                      btg_raster_tile *tiles, uint32_t count) {
    static const GLfloat far_away = 1;
    const btg_gl *gl = r->gl;
    uint32_t row = r->side / pass->size.x;
    for (uint32_t i = 0; i < count; i++) {
        tiles[i].at.z = i % row * pass->size.x;
        tiles[i].at.w = i / row * pass->size.x;
    }
    fill_buffer(r, BTG_RASTER_BUFFER_PASS, sizeof *pass, pass);
    fill_buffer(r, BTG_RASTER_BUFFER_TILES, count * sizeof *tiles, tiles);
    uint32_t columns = count < row ? count : row, rows = (count + row - 1) / row;
    gl->Scissor(0, 0, (GLsizei)(columns * pass->size.x), (GLsizei)(rows * pass->size.x));
    gl->ClearBufferfv(GL_DEPTH, 0, &far_away);
    gl->UseProgram(r->program[op]);
}

void btg_raster_draw(const btg_raster *r, const btg_raster_entry *list, size_t count,
                     const btg_gpu_vec4 (*pieces)[BTG_GPU_CELL], size_t piece_count) {
    if (count == 0) return;
    if (piece_count > 0) {
        r->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, r->buffer[BTG_RASTER_BUFFER_GEOMETRY]);
        r->gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, (GLintptr)r->pieces_at,
                             (GLsizeiptr)(piece_count * sizeof *pieces), pieces);
    }
    refill_buffer(r, BTG_RASTER_BUFFER_LIST, count * sizeof *list, list);
    r->gl->DrawElements(GL_TRIANGLES, (GLsizei)(count * INDICES), GL_UNSIGNED_INT, NULL);
}

btg_status btg_raster_finish(const btg_raster *r, const btg_raster_pass *pass, uint32_t count,
                             btg_raster_pick *picks) {
    const btg_gl *gl = r->gl;
    size_t size = (size_t)count * pass->size.y * sizeof *picks;
    fill_buffer(r, BTG_RASTER_BUFFER_PICKS, size, NULL);
    gl->UseProgram(r->reduce);
    gl->DispatchCompute(count, 1, 1);
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, r->buffer[BTG_RASTER_BUFFER_PICKS]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)size, picks);
    return status_of(gl->GetError());
}
