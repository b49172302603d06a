#include "view/window.h"
#include "view/worker.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <backends/imgui_impl_glfw.h>
#include <cctype>
#include <dlfcn.h>
#include <imgui.h>
#include <link.h>
#include <unistd.h>

namespace view {

/* A window that nothing happens in is drawn so often, seconds; one that plays at most so often. */
static constexpr double idle_s = 0.25, frame_s = 1.0 / 60;
/* ImGui answers a click some frames later. */
static constexpr int frames_after_event = 4;

struct view_window {
    state *st;
    GLFWwindow *handle = nullptr;
    btg_gl gl = {};
    canvas c;
    scene s;
    panel p;
    worker w;
    bool imgui = false;
    int busy = frames_after_event;
    double x = 0, y = 0; /* of the mouse, when last seen */
};

static std::string glfw_error;

static void take_error(int, const char *text) {
    glfw_error = text;
}

static view_window *of(GLFWwindow *handle) {
    auto *w = static_cast<view_window *>(glfwGetWindowUserPointer(handle));
    w->busy = frames_after_event;
    return w;
}

/* ---- what the user does ------------------------------------------------------------------- */

static const struct {
    int key;
    const char *name;
} named_keys[] = {
    {GLFW_KEY_SPACE, "space"}, {GLFW_KEY_LEFT, "left"}, {GLFW_KEY_RIGHT, "right"},
    {GLFW_KEY_UP, "up"},       {GLFW_KEY_DOWN, "down"}, {GLFW_KEY_HOME, "home"},
    {GLFW_KEY_END, "end"},     {GLFW_KEY_TAB, "tab"},   {GLFW_KEY_ESCAPE, "escape"},
};

static void on_key(GLFWwindow *handle, int key, int, int action, int mods) {
    view_window *w = of(handle);
    if (action == GLFW_RELEASE || ImGui::GetIO().WantTextInput) return;
    for (const auto &k : named_keys) {
        if (k.key != key) continue;
        std::string name = k.name;
        if ((mods & GLFW_MOD_SHIFT) && key_known("shift+" + name)) name = "shift+" + name;
        press(w->st, name);
    }
}

/* Letters as the user's keyboard has them. */
static void on_character(GLFWwindow *handle, unsigned code) {
    view_window *w = of(handle);
    if (ImGui::GetIO().WantTextInput || code > 126) return;
    if (code == '+' || code == '-')
        press(w->st, code == '+' ? "plus" : "minus");
    else
        press(w->st, std::string(1, static_cast<char>(std::tolower(static_cast<int>(code)))));
}

static void on_move(GLFWwindow *handle, double x, double y) {
    view_window *w = of(handle);
    double right = x - w->x, down = y - w->y;
    w->x = x, w->y = y;
    if (ImGui::GetIO().WantCaptureMouse) return;
    auto held = [&](int button) { return glfwGetMouseButton(handle, button) == GLFW_PRESS; };
    bool shift = glfwGetKey(handle, GLFW_KEY_LEFT_SHIFT) == GLFW_PRESS ||
                 glfwGetKey(handle, GLFW_KEY_RIGHT_SHIFT) == GLFW_PRESS;
    bool left = held(GLFW_MOUSE_BUTTON_LEFT);
    int width, height;
    glfwGetWindowSize(handle, &width, &height);
    if (held(GLFW_MOUSE_BUTTON_RIGHT) || held(GLFW_MOUSE_BUTTON_MIDDLE) || (left && shift))
        camera_pan(&w->st->eye, right, down, std::max(height, 1));
    else if (left)
        camera_orbit(&w->st->eye, right, down);
}

static void on_button(GLFWwindow *handle, int, int, int) {
    of(handle);
}

static void on_wheel(GLFWwindow *handle, double, double steps) {
    view_window *w = of(handle);
    if (!ImGui::GetIO().WantCaptureMouse) camera_zoom(&w->st->eye, steps);
}

static void on_drop(GLFWwindow *handle, int count, const char **files) {
    view_window *w = of(handle);
    if (count > 0) w->st->dropped = files[count - 1];
}

static void on_size(GLFWwindow *handle, int, int) {
    of(handle);
}

/* ---- opening and closing ------------------------------------------------------------------ */

static void load_functions(btg_gl *gl) {
#define VIEW_LOAD(name, NAME)                                                                      \
    gl->name = reinterpret_cast<PFNGL##NAME##PROC>(glfwGetProcAddress("gl" #name));
    BTG_GL(VIEW_LOAD)
#undef VIEW_LOAD
}

static btg_status refuse(btg_message *message, const std::string &what) {
    std::string reason = glfw_error.empty() ? "" : " (" + glfw_error + ")";
    return say(message, BTG_ERROR_NO_DEVICE,
               "view: " + what + reason + "; start it on a display, or give --screenshot FILE");
}

static btg_status open_window(view_window *w, const window_def &def, btg_message *message) {
    glfw_error.clear();
    glfwSetErrorCallback(take_error);
    if (!glfwInit()) return refuse(message, "no display");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    std::string title = "Bitangent: " + w->st->part->file;
    w->handle = glfwCreateWindow(def.width, def.height, title.c_str(), nullptr, nullptr);
    if (!w->handle) return refuse(message, "no window with OpenGL 3.3");
    glfwMakeContextCurrent(w->handle);
    glfwSwapInterval(1);
    load_functions(&w->gl);
    std::string why;
    if (!canvas_open(&w->c, &w->gl, &why) || !panel_open(&w->p, &w->gl, &why))
        return say(message, BTG_ERROR_NO_DEVICE, "view: " + why);
    w->s.on = &w->c;
    glfwSetWindowUserPointer(w->handle, w);
    glfwSetKeyCallback(w->handle, on_key);
    glfwSetCharCallback(w->handle, on_character);
    glfwSetCursorPosCallback(w->handle, on_move);
    glfwSetMouseButtonCallback(w->handle, on_button);
    glfwSetScrollCallback(w->handle, on_wheel);
    glfwSetDropCallback(w->handle, on_drop);
    glfwSetFramebufferSizeCallback(w->handle, on_size);
    /* Passes everything on to these. */
    w->imgui = ImGui_ImplGlfw_InitForOther(w->handle, true);
    return BTG_OK;
}

/* Drivers leave memory behind when they are unloaded; what they brought stays until the program
 * ends, as it does without a window. */
static int pin(dl_phdr_info *library, std::size_t, void *) {
    if (library->dlpi_name && library->dlpi_name[0])
        dlopen(library->dlpi_name, RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
    return 0;
}

static void close_window(view_window *w) {
    worker_stop(&w->w);
    if (w->handle) dl_iterate_phdr(pin, nullptr);
    if (w->imgui) ImGui_ImplGlfw_Shutdown();
    panel_close(&w->p);
    scene_free(&w->s);
    canvas_close(&w->c);
    if (w->handle) glfwDestroyWindow(w->handle);
    glfwTerminate();
    glfwSetErrorCallback(nullptr);
}

/* ---- the loop ----------------------------------------------------------------------------- */

/* In the folder the program was started in, under a name that is not there yet. */
static void save_here(view_window *w) {
    btg_message message;
    char file[64];
    w->st->save_picture = false;
    int number = 1;
    do
        std::snprintf(file, sizeof file, "bitangent-view-%03d.png", number);
    while (access(file, F_OK) == 0 && ++number < 1000);
    btg_status status = save_picture(canvas_read(&w->c), file, &message);
    w->st->note = status == BTG_OK ? std::string("saved ") + file : message.text;
    w->busy = frames_after_event;
}

static bool draw(view_window *w, frame_facts *facts, std::string *why) {
    int width, height;
    glfwGetFramebufferSize(w->handle, &width, &height);
    if (width < 1 || height < 1) return true; /* minimised */
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    if (!draw_frame(&w->s, &w->p, w->st, width, height, facts, why)) return false;
    if (w->st->save_picture) save_here(w);
    canvas_show(&w->c);
    glfwSwapBuffers(w->handle);
    return true;
}

static void wait(view_window *w, bool keys_left) {
    bool moving = w->st->playing || w->w.doing != task::none || w->busy > 0;
    if (w->busy > 0) w->busy--;
    if (keys_left)
        glfwPollEvents();
    else
        glfwWaitEventsTimeout(moving ? frame_s : idle_s);
}

static btg_status loop(view_window *w, const window_def &def, frame_facts *facts,
                       btg_message *message) {
    std::size_t key = 0;
    std::string why;
    double before = glfwGetTime();
    while (!w->st->quit && !glfwWindowShouldClose(w->handle)) {
        double now = glfwGetTime();
        advance(w->st, now - before);
        before = now;
        if (!w->st->dropped.empty()) open_dropped(w->st, *def.options);
        worker_look(&w->w, w->st, *def.options);
        if (!draw(w, facts, &why)) return say(message, BTG_ERROR_DEVICE, "view: " + why);
        if (key < def.keys.size()) press(w->st, def.keys[key++]);
        wait(w, key < def.keys.size());
    }
    return BTG_OK;
}

btg_status show_window(state *st, const window_def &def, frame_facts *facts, btg_message *message) {
    view_window w;
    w.st = st;
    btg_status status = open_window(&w, def, message);
    if (status == BTG_OK) status = loop(&w, def, facts, message);
    close_window(&w);
    return status;
}

} // namespace view
