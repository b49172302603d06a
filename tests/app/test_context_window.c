/* A program with a window of its own (GLFW, by GLX, EGL and OSMesa) that uses contexts without one
 * on the same thread: its window's context stays current and goes on drawing. Exit code 77: no
 * display, or no provider. */
#define GLFW_INCLUDE_NONE
#include "backend/context/context.h"
#include "check.h"

#include <stdint.h>
#include <string.h>

#include <GLFW/glfw3.h>

#define SIDE 16

static const btg_allocator heap;

static bool use(const char *provider) {
    btg_context_def def = {.provider = provider};
    btg_context *context = NULL;
    btg_message message = {""};
    if (btg_context_open(&def, &heap, &context, &message) != BTG_OK) {
        printf("%s\n", message.text);
        return false;
    }
    for (int i = 0; i < 3; i++) {
        GLuint buffer = 0;
        CHECK(btg_context_enter(context) == BTG_OK);
        const btg_gl *gl = btg_context_gl(context);
        gl->GenBuffers(1, &buffer);
        gl->ClearColor(1, 0, 0, 1); /* not the window's */
        CHECK(strstr((const char *)gl->GetString(GL_VERSION), "4.") != NULL);
        gl->DeleteBuffers(1, &buffer);
        CHECK(gl->GetError() == GL_NO_ERROR);
        btg_context_leave(context);
    }
    btg_context_close(context);
    return true;
}

static void draw_green(GLFWwindow *window) {
    uint8_t pixel[4] = {0};
    PFNGLCLEARPROC clear = (PFNGLCLEARPROC)glfwGetProcAddress("glClear");
    PFNGLREADPIXELSPROC read = (PFNGLREADPIXELSPROC)glfwGetProcAddress("glReadPixels");
    CHECK(glfwGetCurrentContext() == window);
    clear(GL_COLOR_BUFFER_BIT);
    read(SIDE / 2, SIDE / 2, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    CHECK(pixel[0] == 0 && pixel[1] == 255);
    glfwSwapBuffers(window);
}

/* Answers how many providers were used beside the window. */
static int test_window(int api) {
    int used = 0;
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_CONTEXT_CREATION_API, api);
    GLFWwindow *window = glfwCreateWindow(SIDE, SIDE, "", NULL, NULL);
    if (!window) return 0;
    glfwMakeContextCurrent(window);
    PFNGLCLEARCOLORPROC color = (PFNGLCLEARCOLORPROC)glfwGetProcAddress("glClearColor");
    color(0, 1, 0, 1);
    draw_green(window);
    if (use("osmesa")) used++;
    draw_green(window);
    if (use("egl")) used++;
    draw_green(window);
    glfwMakeContextCurrent(NULL);
    glfwMakeContextCurrent(window);
    draw_green(window);
    glfwDestroyWindow(window);
    return used;
}

int main(void) {
    static const int apis[] = {GLFW_NATIVE_CONTEXT_API, GLFW_EGL_CONTEXT_API,
                               GLFW_OSMESA_CONTEXT_API};
    if (!glfwInit()) {
        printf("skipped: no display\n");
        return 77;
    }
    int used = 0;
    for (int i = 0; i < 3; i++) {
        int by_this = test_window(apis[i]);
        printf("window %d: %d providers beside it\n", i, by_this);
        used += by_this;
    }
    glfwTerminate();
    if (check_failures > 0) return check_result();
    if (used == 0) printf("skipped: no window and provider together\n");
    return used > 0 ? 0 : 77;
}
