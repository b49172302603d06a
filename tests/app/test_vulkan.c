/* The vulkan back end under the Khronos validation layer: not a word from it, whatever is asked;
 * four threads with one each; and what single precision alone is worth. Exit code 77: no device,
 * or no validation layer. */
#include "backend/vulkan/vulkan.h"
#include "check.h"
#include "device_checks.h"

#include <stdatomic.h>

static void report(const char *text, void *user) {
    atomic_int *said = user;
    if (atomic_fetch_add(said, 1) < 5) fprintf(stderr, "validation: %s\n", text);
}

static int test_validation(const btg_backend_setup *setup) {
    atomic_int said = 0;
    btg_vulkan_debug debug = {report, &said};
    btg_message message = {""};
    void *state = NULL;
    btg_status status = btg_vulkan_open_debug(&debug, DEVICE_DISPATCH, setup, &state, &message);
    if (status == BTG_ERROR_NO_DEVICE) {
        printf("skipped: %s\n", message.text);
        return 77;
    }
    CHECK(status == BTG_OK);
    if (!state) return 1;
    device_check_batches(state);
    btg_backend_vulkan.close(state);
    CHECK(atomic_load(&said) == 0);
    return check_failures > 0;
}

int main(void) {
    char device[256];
    if (btg_backend_vulkan.probe(device, sizeof device) != BTG_BACKEND_READY) {
        printf("skipped: %s\n", device);
        return 77;
    }
    btg_backend_setup setup = device_checks_begin("vulkan");
    int result = test_validation(&setup);
    device_check_threads_raw_times(DEVICE_FOLLOWED_MM);
    return device_checks_end(result);
}
