/* The gl back end in contexts of both providers, with the driver's own messages heard: none; four
 * threads with a context each; and what single precision alone is worth. Exit code 77: no device.
 */
#include "backend/gl/gl.h"
#include "check.h"
#include "device_checks.h"

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

int main(void) {
    btg_backend_setup setup = device_checks_begin("gl");
    test_missing(&setup);
    bool osmesa = test_provider(&setup, "osmesa"), egl = test_provider(&setup, "egl");
    if (osmesa || egl) device_check_threads_raw_times(DEVICE_FOLLOWED_MM);
    int result = osmesa || egl ? 0 : 77;
    return device_checks_end(check_failures > 0 ? 1 : result);
}
