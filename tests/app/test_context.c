/* OpenGL without a window: by every provider; what was current on the thread stays so, whoever made
 * it; and the words when a library is missing. Exit code 77: no provider runs here. */
#define _GNU_SOURCE
#include "backend/context/context.h"
#include "check.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>

static const btg_allocator heap;
static const char *const providers[] = {"osmesa", "egl"};

static btg_context *open_by(const char *provider) {
    btg_context_def def = {.provider = provider};
    btg_message message = {""};
    btg_context *context = NULL;
    btg_status status = btg_context_open(&def, &heap, &context, &message);
    CHECK(status == BTG_OK || status == BTG_ERROR_NO_DEVICE);
    CHECK((status == BTG_OK) == (message.text[0] == '\0'));
    if (status != BTG_OK) printf("%s: %s\n", provider, message.text);
    return context;
}

/* A depth image in 32-bit float holds what it was cleared to. */
static void draw_with(btg_context *context, float depth) {
    GLuint texture = 0, frame = 0;
    float got = -1;
    CHECK(btg_context_enter(context) == BTG_OK);
    const btg_gl *gl = btg_context_gl(context);
    gl->GenTextures(1, &texture);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT32F, 8, 8);
    gl->GenFramebuffers(1, &frame);
    gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl->FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, texture, 0);
    CHECK(gl->CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE);
    gl->ClearBufferfv(GL_DEPTH, 0, &depth);
    gl->ReadPixels(3, 5, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &got);
    CHECK(got == depth);
    gl->DeleteFramebuffers(1, &frame);
    gl->DeleteTextures(1, &texture);
    CHECK(gl->GetError() == GL_NO_ERROR);
    btg_context_leave(context);
}

static bool test_provider(const char *provider) {
    btg_context *context = open_by(provider);
    if (!context) return false;
    CHECK(strcmp(btg_context_provider(context), provider) == 0);
    CHECK(strstr(btg_context_name(context), "OpenGL 4.") != NULL);
    draw_with(context, 0.123456789f);
    CHECK(btg_context_extension(context, "GL_ARB_gl_spirv"));
    CHECK(!btg_context_extension(context, "GL_ARB_gl_spir"));
    CHECK(!btg_context_extension(context, "GL_BTG_nothing"));
    btg_context_close(context);
    return true;
}

/* ---- missing ------------------------------------------------------------------------------ */

static void refuses(btg_context_def def, btg_status expected, const char *a, const char *b) {
    btg_context *context = NULL;
    btg_message message = {""};
    CHECK(btg_context_open(&def, &heap, &context, &message) == expected);
    CHECK(context == NULL);
    CHECK(strstr(message.text, a) && strstr(message.text, b));
    CHECK(btg_context_open(&def, &heap, &context, NULL) == expected);
}

static void test_missing(void) {
    const char *none = "libbtg-none.so", *other = "libm.so.6";
    refuses((btg_context_def){"osmesa", none, NULL}, BTG_ERROR_NO_DEVICE, none, "libosmesa6");
    refuses((btg_context_def){"egl", NULL, none}, BTG_ERROR_NO_DEVICE, none, "libegl1");
    refuses((btg_context_def){NULL, none, none}, BTG_ERROR_NO_DEVICE, "libosmesa6", "libegl1");
    refuses((btg_context_def){"osmesa", other, NULL}, BTG_ERROR_NO_DEVICE, "osmesa", "no OSMesa");
    refuses((btg_context_def){"egl", NULL, other}, BTG_ERROR_NO_DEVICE, "egl", "no EGL");
    refuses((btg_context_def){"glx", NULL, NULL}, BTG_ERROR_ARGUMENT, "glx", "osmesa, egl");
}

/* Where the first is missing the second runs. */
static void test_second(void) {
    btg_context_def def = {NULL, "libbtg-none.so", NULL};
    btg_context *context = NULL;
    CHECK(btg_context_open(&def, &heap, &context, NULL) == BTG_OK);
    if (!context) return;
    CHECK(strcmp(btg_context_provider(context), "egl") == 0);
    draw_with(context, 0.75f);
    btg_context_close(context);
}

static void *take_none(size_t size, void *user) {
    size_t *left = user;
    return (*left)-- > 0 ? malloc(size) : NULL;
}

static void give_back(void *memory, void *user) {
    (void)user;
    free(memory);
}

static void test_memory(const char *provider) {
    for (size_t n = 0; n < 3; n++) {
        size_t left = n;
        btg_allocator poor = {take_none, give_back, &left};
        btg_context_def def = {.provider = provider};
        btg_context *context = NULL;
        CHECK(btg_context_open(&def, &poor, &context, NULL) == BTG_ERROR_MEMORY);
        CHECK(context == NULL);
    }
}

/* ---- the host's own ----------------------------------------------------------------------- */

static void use_all(void) {
    for (int i = 0; i < 2; i++) {
        btg_context *context = open_by(providers[i]);
        if (!context) continue;
        draw_with(context, 0.5f);
        btg_context_close(context);
    }
}

#define SYMBOL(library, name, function)                                                            \
    do {                                                                                           \
        void *symbol = dlsym(library, name);                                                       \
        CHECK(symbol != NULL);                                                                     \
        if (!symbol) return;                                                                       \
        memcpy(&(function), &symbol, sizeof symbol);                                               \
    } while (0)

/* A host that draws with OSMesa into memory of its own, and goes on doing so. */
static void test_host_osmesa(void) {
    enum { SIDE = 4, RGBA = 0x1908 };
    static uint8_t image[SIDE * SIDE][4];
    void *library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    if (!library) return;
    void *(*create)(int, void *), *(*current)(void), *(*address)(const char *);
    unsigned char (*bind)(void *, void *, int, int, int);
    void (*destroy)(void *);
    SYMBOL(library, "OSMesaCreateContext", create);
    SYMBOL(library, "OSMesaGetCurrentContext", current);
    SYMBOL(library, "OSMesaGetProcAddress", address);
    SYMBOL(library, "OSMesaMakeCurrent", bind);
    SYMBOL(library, "OSMesaDestroyContext", destroy);
    void *context = create(RGBA, NULL), *f = address("glClear");
    PFNGLCLEARPROC clear;
    PFNGLCLEARCOLORPROC color;
    PFNGLFINISHPROC finish;
    memcpy(&clear, &f, sizeof f);
    f = address("glClearColor");
    memcpy(&color, &f, sizeof f);
    f = address("glFinish");
    memcpy(&finish, &f, sizeof f);
    CHECK(bind(context, image, GL_UNSIGNED_BYTE, SIDE, SIDE));
    color(0, 1, 0, 1);
    use_all();
    CHECK(current() == context);
    clear(GL_COLOR_BUFFER_BIT); /* the colour of before is still set */
    finish();
    CHECK(image[5][0] == 0 && image[5][1] == 255);
    bind(NULL, NULL, 0, 0, 0);
    use_all();
    CHECK(current() == NULL);
    destroy(context);
    dlclose(library);
}

/* A host with a context of EGL, of OpenGL ES: both its context and its choice of API stay. */
static void test_host_egl(void) {
    void *library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) return;
    PFNEGLGETPROCADDRESSPROC address;
    SYMBOL(library, "eglGetProcAddress", address);
#define GET(TYPE, name) TYPE name = (TYPE)address("egl" #name)
    GET(PFNEGLGETPLATFORMDISPLAYEXTPROC, GetPlatformDisplayEXT);
    GET(PFNEGLINITIALIZEPROC, Initialize);
    GET(PFNEGLBINDAPIPROC, BindAPI);
    GET(PFNEGLQUERYAPIPROC, QueryAPI);
    GET(PFNEGLCREATECONTEXTPROC, CreateContext);
    GET(PFNEGLDESTROYCONTEXTPROC, DestroyContext);
    GET(PFNEGLMAKECURRENTPROC, MakeCurrent);
    GET(PFNEGLGETCURRENTCONTEXTPROC, GetCurrentContext);
    PFNGLGETSTRINGPROC GetString = (PFNGLGETSTRINGPROC)address("glGetString");
    static const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 2, EGL_NONE};
    EGLDisplay display =
        GetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, (void *)EGL_DEFAULT_DISPLAY, NULL);
    if (!display || !Initialize(display, NULL, NULL)) return;
    BindAPI(EGL_OPENGL_ES_API);
    EGLContext context = CreateContext(display, EGL_NO_CONFIG_KHR, NULL, version);
    CHECK(context && MakeCurrent(display, NULL, NULL, context));
    use_all();
    CHECK(GetCurrentContext() == context);
    CHECK(QueryAPI() == EGL_OPENGL_ES_API);
    const char *text = (const char *)GetString(GL_VERSION);
    CHECK(text && strstr(text, "OpenGL ES"));
    MakeCurrent(display, NULL, NULL, NULL);
    use_all();
    CHECK(GetCurrentContext() == NULL);
    CHECK(QueryAPI() == EGL_OPENGL_ES_API);
    DestroyContext(display, context);
    dlclose(library);
}

/* One of ours inside another: the outer one's objects are there again afterwards. */
static void test_nested(const char *outer, const char *inner) {
    btg_context *a = open_by(outer), *b = open_by(inner);
    if (a && b && btg_context_enter(a) == BTG_OK) {
        GLuint buffers[2] = {0, 0};
        const btg_gl *gl = btg_context_gl(a);
        gl->GenBuffers(2, buffers);
        gl->BindBuffer(GL_ARRAY_BUFFER, buffers[1]);
        draw_with(b, 0.25f);
        CHECK(btg_context_gl(a)->IsBuffer(buffers[1]));
        if (btg_context_enter(b) == BTG_OK) {
            CHECK(!btg_context_gl(b)->IsBuffer(buffers[1]));
            btg_context_leave(b);
        }
        CHECK(btg_context_gl(a)->IsBuffer(buffers[1]));
        CHECK(gl->GetError() == GL_NO_ERROR);
        btg_context_leave(a);
    }
    btg_context_close(a);
    btg_context_close(b);
}

/* ---- threads ------------------------------------------------------------------------------ */

static void *work(void *provider) {
    btg_context *context = open_by(provider);
    for (int i = 0; context && i < 20; i++)
        draw_with(context, (float)i / 32);
    btg_context_close(context);
    return NULL;
}

static void test_threads(const char *provider) {
    pthread_t threads[4];
    for (int i = 0; i < 4; i++)
        CHECK(pthread_create(&threads[i], NULL, work, (void *)provider) == 0);
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
}

int main(void) {
    test_missing();
    bool runs[2];
    for (int i = 0; i < 2; i++)
        runs[i] = test_provider(providers[i]);
    if (!runs[0] && !runs[1]) {
        printf("skipped: no provider runs here\n");
        return check_failures > 0 ? check_result() : 77;
    }
    if (runs[1]) test_second();
    for (int i = 0; i < 2; i++) {
        if (!runs[i]) continue;
        test_memory(providers[i]);
        test_threads(providers[i]);
        for (int k = 0; k < 2; k++)
            if (runs[k]) test_nested(providers[i], providers[k]);
    }
    test_host_osmesa();
    test_host_egl();
    return check_result();
}
