/* The gl back end in contexts of both providers, with the driver's own messages heard: none; four
 * threads with a context each; and what single precision alone is worth.
 *
 *     test-app-gl                  as the driver is
 *     test-app-gl VERSION          as if it had no more than that OpenGL (Mesa's drivers alone)
 *     test-app-gl VERSION source   nor took SPIR-V
 *
 * Exit code 77: no device, or not one of Mesa's. */
#define _POSIX_C_SOURCE 200809L /* setenv */
/* All that is called is in OpenGL 4.3: what came later is not declared here. */
#define GL_VERSION_4_4 1
#define GL_VERSION_4_5 1
#define GL_VERSION_4_6 1
#include "backend/gl/gl.h"
#include "check.h"
#include "device_checks.h"

#include <stdlib.h>
#include <string.h>

static void report(const char *text, void *user) {
    int *said = user;
    if ((*said)++ < 5) fprintf(stderr, "driver: %s\n", text);
}

/* Returns whether the provider is there. */
static bool test_provider(const btg_backend_setup *setup, const char *provider) {
    int said = 0;
    btg_gl_debug debug = {report, &said};
    btg_gl_def def = {.context = {.provider = provider}, .debug = &debug};
    btg_message message = {""};
    void *state = NULL;
    btg_status status = btg_gl_open_with(&def, DEVICE_DISPATCH, setup, &state, &message);
    if (status == BTG_ERROR_NO_DEVICE) {
        printf("without %s: %s\n", provider, message.text);
        return false;
    }
    CHECK(status == BTG_OK);
    if (!state) return true;
    device_check_batches(state);
    btg_backend_gl.close(state);
    CHECK(said == 0);
    return true;
}

/* No library: says which, and what to do. */
static void test_missing(const btg_backend_setup *setup) {
    btg_gl_def def = {.context = {.provider = "osmesa", .osmesa_library = "libnosuch.so"}};
    btg_message message = {""};
    void *state = NULL;
    CHECK(btg_gl_open_with(&def, 0, setup, &state, &message) == BTG_ERROR_NO_DEVICE);
    CHECK(strstr(message.text, "libnosuch.so") && strstr(message.text, "install"));
    CHECK(!state);
}

/* ---- older drivers ------------------------------------------------------------------------ */

/* Is the context of that version, and does it take SPIR-V as said? What `info` says is so too. */
static bool is_old(const char *provider, const char *version, bool spirv) {
    btg_context_def def = {.provider = provider};
    btg_allocator heap = {0};
    btg_context *context = NULL;
    btg_message message = {""};
    char words[32], device[256];
    if (btg_context_open(&def, &heap, &context, &message) != BTG_OK) {
        CHECK(!strstr(message.text, "core context"));
        return false;
    }
    snprintf(words, sizeof words, "OpenGL %s ", version);
    bool old = strstr(btg_context_name(context), words) != NULL;
    if (old) {
        CHECK(btg_context_spirv(context) == spirv);
        CHECK(btg_backend_gl.probe(device, sizeof device) == BTG_BACKEND_READY);
        CHECK(strstr(device, words) && strstr(device, spirv ? "as SPIR-V" : "as GLSL"));
    }
    btg_context_close(context);
    return old;
}

/* Says which is needed. */
static bool is_refused(const char *provider) {
    btg_context_def def = {.provider = provider};
    btg_allocator heap = {0};
    btg_context *context = NULL;
    btg_message message = {""};
    btg_status status = btg_context_open(&def, &heap, &context, &message);
    bool refused = status == BTG_ERROR_NO_DEVICE && strstr(message.text, "OpenGL 4.3");
    if (!refused) printf("%s: %s\n", provider, message.text);
    btg_context_close(context);
    return refused;
}

/* Drivers read their environment when they start: one version a process. */
static int test_old(const char *version, bool spirv) {
    static const char *const providers[2] = {"osmesa", "egl"};
    int result = 77;
    bool enough = strcmp(version, "4.3") >= 0;
    setenv("MESA_GL_VERSION_OVERRIDE", version, 1);
    setenv("MESA_GLSL_VERSION_OVERRIDE", enough ? "430" : "420", 1);
    if (!spirv) setenv("MESA_EXTENSION_OVERRIDE", "-GL_ARB_gl_spirv", 1);
    btg_backend_setup setup = device_checks_begin("gl");
    for (int i = 0; i < 2; i++) {
        if (enough ? !is_old(providers[i], version, spirv) : !is_refused(providers[i])) continue;
        CHECK(test_provider(&setup, providers[i]) == enough);
        result = 0;
    }
    if (result == 0 && !spirv) device_check_threads_raw_times(DEVICE_FOLLOWED_MM);
    return device_checks_end(check_failures > 0 ? 1 : result);
}

int main(int count, char **words) {
    if (count > 1) return test_old(words[1], count < 3);
    btg_backend_setup setup = device_checks_begin("gl");
    test_missing(&setup);
    bool osmesa = test_provider(&setup, "osmesa"), egl = test_provider(&setup, "egl");
    if (osmesa || egl) device_check_threads_raw_times(DEVICE_FOLLOWED_MM);
    int result = osmesa || egl ? 0 : 77;
    return device_checks_end(check_failures > 0 ? 1 : result);
}
