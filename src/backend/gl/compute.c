#include "backend/gl/compute.h"
#include "core/part.h"

#include <stdio.h>
#include <string.h>

#include "drop_gl_spv.h"
#include "drop_glsl.h"
#include "tilt_gl_spv.h"
#include "tilt_glsl.h"

/* A dispatch that takes longer hangs. */
#define TIMEOUT_NS 60000000000u
#define LOG_SIZE   256

static bool software(const btg_gl *gl) {
    const char *renderer = (const char *)gl->GetString(GL_RENDERER);
    return renderer && (strstr(renderer, "llvmpipe") || strstr(renderer, "softpipe"));
}

void btg_gl_limits(const btg_context *context, btg_device_limits *limits) {
    const btg_gl *gl = btg_context_gl(context);
    GLint groups = 0;
    GLint64 bytes = 0;
    gl->GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, 0, &groups);
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    limits->groups = groups > 0 ? (uint32_t)groups : 0;
    limits->buffer_bytes = bytes > 0 ? (size_t)bytes : 0;
}

/* ---- errors ------------------------------------------------------------------------------- */

/* What went wrong since the last look: the worst of it. */
static btg_status trouble(const btg_gl *gl) {
    btg_status status = BTG_OK;
    if (gl->GetGraphicsResetStatus() != GL_NO_ERROR) return BTG_ERROR_DEVICE;
    /* A context that is gone may report for ever. */
    for (int i = 0; i < 16; i++) {
        GLenum error = gl->GetError();
        if (error == GL_NO_ERROR) return status;
        status = error == GL_OUT_OF_MEMORY ? BTG_ERROR_MEMORY : BTG_ERROR_DEVICE;
    }
    return BTG_ERROR_DEVICE;
}

static btg_status told(const btg_gl *gl, const char *what, btg_message *message) {
    btg_status status = trouble(gl);
    if (status == BTG_OK) return BTG_OK;
    return btg_fail(message, status, "gl: %s: %s", what,
                    status == BTG_ERROR_MEMORY ? "the device is out of memory; split the part"
                                               : "the device failed; try another --backend");
}

/* ---- buffers ------------------------------------------------------------------------------ */

static void make_buffer(const btg_gl *gl, GLenum target, const void *data, size_t size,
                        GLuint *buffer, size_t *bytes) {
    gl->GenBuffers(1, buffer);
    gl->BindBuffer(target, *buffer);
    gl->BufferData(target, (GLsizeiptr)size, data, data ? GL_STATIC_DRAW : GL_STREAM_READ);
    *bytes += size;
}

static btg_status make_buffers(btg_gl_compute *c, const btg_scene *scene, uint32_t capacity,
                               size_t *bytes, btg_message *message) {
    const btg_gl *gl = c->gl;
    *bytes = 0;
    make_buffer(gl, GL_UNIFORM_BUFFER, &scene->head, sizeof scene->head, &c->scene, bytes);
    make_buffer(gl, GL_SHADER_STORAGE_BUFFER, scene->geometry,
                scene->count * sizeof *scene->geometry, &c->geometry, bytes);
    for (uint32_t i = 0; i < BTG_BATCH_SLOTS; i++) {
        make_buffer(gl, GL_SHADER_STORAGE_BUFFER, NULL, capacity * sizeof(btg_gpu_query),
                    &c->slot[i].queries, bytes);
        make_buffer(gl, GL_SHADER_STORAGE_BUFFER, NULL, capacity * sizeof(btg_gpu_winner),
                    &c->slot[i].winners, bytes);
    }
    return told(gl, "buffers for the part", message);
}

/* ---- programs ----------------------------------------------------------------------------- */

/* A shader in both its forms. */
typedef struct shader_code {
    const uint32_t *binary;
    size_t size; /* bytes */
    const unsigned char *source;
} shader_code;

/* By btg_op. */
static const shader_code codes[2] = {{drop_gl_spv, sizeof drop_gl_spv, drop_glsl},
                                     {tilt_gl_spv, sizeof tilt_gl_spv, tilt_glsl}};

static void compile_binary(const btg_gl *gl, GLuint shader, const shader_code *code, GLuint group) {
    static const GLuint index = 0;
    gl->ShaderBinary(1, &shader, GL_SHADER_BINARY_FORMAT_SPIR_V_ARB, code->binary,
                     (GLsizei)code->size);
    gl->SpecializeShaderARB(shader, "main", 1, &index, &group);
}

/* The source's first line is its version; what is chosen here comes after it. */
static void compile_source(const btg_gl *gl, GLuint shader, const shader_code *code, GLuint group) {
    const char *version = (const char *)code->source, *rest = strchr(version, '\n') + 1;
    char chosen[40];
    snprintf(chosen, sizeof chosen, "#define BTG_GROUP %u\n", (unsigned)group);
    const GLchar *texts[3] = {version, chosen, rest};
    const GLint lengths[3] = {(GLint)(rest - version), -1, -1};
    gl->ShaderSource(shader, 3, texts, lengths);
    gl->CompileShader(shader);
}

/* Links one shader; the shader's or the program's own words where it does not work. */
static btg_status make_program(btg_gl_compute *c, btg_op op, btg_message *message) {
    const btg_gl *gl = c->gl;
    GLuint group = software(gl) ? BTG_GPU_GROUP_NARROW : BTG_GPU_GROUP_WIDE;
    GLuint shader = gl->CreateShader(GL_COMPUTE_SHADER);
    GLint done = 0;
    char log[LOG_SIZE] = "";
    if (btg_context_spirv(c->context))
        compile_binary(gl, shader, &codes[op], group);
    else
        compile_source(gl, shader, &codes[op], group);
    gl->GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (!done) gl->GetShaderInfoLog(shader, sizeof log, NULL, log);
    GLuint program = c->program[op] = gl->CreateProgram();
    gl->AttachShader(program, shader);
    if (done) {
        gl->LinkProgram(program);
        gl->GetProgramiv(program, GL_LINK_STATUS, &done);
        if (!done) gl->GetProgramInfoLog(program, sizeof log, NULL, log);
    }
    gl->DeleteShader(shader);
    if (done) return told(gl, "compiling shaders", message);
    trouble(gl);
    return btg_fail(message, BTG_ERROR_DEVICE,
                    "gl: the driver refuses the shaders: %s; try another --backend",
                    log[0] ? log : "no reason given");
}

/* ---- dispatches --------------------------------------------------------------------------- */

btg_status btg_gl_write(btg_gl_compute *c, uint32_t slot, const btg_gpu_query *queries,
                        uint32_t count) {
    const btg_gl *gl = c->gl;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, c->slot[slot].queries);
    gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(count * sizeof *queries), queries);
    return trouble(gl);
}

btg_status btg_gl_dispatch(btg_gl_compute *c, uint32_t slot, btg_op op, uint32_t count) {
    const btg_gl *gl = c->gl;
    btg_gl_slot *s = &c->slot[slot];
    gl->BindBufferBase(GL_UNIFORM_BUFFER, BTG_GPU_SCENE, c->scene);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BTG_GPU_GEOMETRY, c->geometry);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BTG_GPU_QUERIES, s->queries);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BTG_GPU_WINNERS, s->winners);
    gl->UseProgram(c->program[op]);
    gl->DispatchCompute(count, 1, 1);
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    s->fence = gl->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl->Flush();
    btg_status status = trouble(gl);
    return s->fence ? status : BTG_ERROR_DEVICE;
}

btg_status btg_gl_wait(btg_gl_compute *c, uint32_t slot) {
    btg_gl_slot *s = &c->slot[slot];
    GLenum done = c->gl->ClientWaitSync(s->fence, GL_SYNC_FLUSH_COMMANDS_BIT, TIMEOUT_NS);
    c->gl->DeleteSync(s->fence);
    s->fence = NULL;
    bool ended = done == GL_ALREADY_SIGNALED || done == GL_CONDITION_SATISFIED;
    return ended ? trouble(c->gl) : BTG_ERROR_DEVICE;
}

btg_status btg_gl_read(btg_gl_compute *c, uint32_t slot, btg_gpu_winner *winners, uint32_t count) {
    const btg_gl *gl = c->gl;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, c->slot[slot].winners);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(count * sizeof *winners),
                         winners);
    return trouble(gl);
}

/* ---- whole -------------------------------------------------------------------------------- */

/* The first dispatch is when some drivers compile: better while opening. It asks nothing. */
static btg_status warm_up(btg_gl_compute *c, btg_op op, btg_message *message) {
    const btg_gpu_query none = {.u = {0}};
    btg_status status = btg_gl_write(c, 0, &none, 1);
    if (status == BTG_OK) status = btg_gl_dispatch(c, 0, op, 1);
    if (status == BTG_OK) status = btg_gl_wait(c, 0);
    if (status == BTG_OK) return BTG_OK;
    return btg_fail(message, status, "gl: the first dispatch fails (%s); try another --backend",
                    btg_status_name(status));
}

btg_status btg_gl_load(btg_gl_compute *c, const btg_scene *scene, uint32_t capacity, size_t *bytes,
                       btg_message *message) {
    c->gl = btg_context_gl(c->context);
    btg_status status = make_buffers(c, scene, capacity, bytes, message);
    for (int op = 0; op < 2 && status == BTG_OK; op++)
        status = make_program(c, (btg_op)op, message);
    for (int op = 0; op < 2 && status == BTG_OK; op++)
        status = warm_up(c, (btg_op)op, message);
    if (status != BTG_OK) btg_gl_unload(c);
    return status;
}

void btg_gl_unload(btg_gl_compute *c) {
    const btg_gl *gl = c->gl;
    if (!gl) return;
    gl->Finish();
    for (int i = 0; i < BTG_BATCH_SLOTS; i++) {
        if (c->slot[i].fence) gl->DeleteSync(c->slot[i].fence);
        gl->DeleteBuffers(1, &c->slot[i].queries);
        gl->DeleteBuffers(1, &c->slot[i].winners);
    }
    for (int i = 0; i < 2; i++)
        gl->DeleteProgram(c->program[i]);
    gl->DeleteBuffers(1, &c->scene);
    gl->DeleteBuffers(1, &c->geometry);
    *c = (btg_gl_compute){.context = c->context};
}
