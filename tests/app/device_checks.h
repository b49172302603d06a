/* What every device back end is held to, beside the conformance harness. */
#ifndef BTG_TESTS_DEVICE_CHECKS_H
#define BTG_TESTS_DEVICE_CHECKS_H

#include "backend/device/batch.h"

/* Queries at once where a test opens the device by itself: several dispatches a batch. */
#define DEVICE_DISPATCH 64

/* A part of every kind of surface and a tool with a shank; the back end's name. */
btg_backend_setup device_checks_begin(const char *backend);
/* Frees them. The exit code of the test: `result`, or 1 when a check failed. */
int device_checks_end(int result);

/* Batches of many sizes to an opened state: the cpu's answers. */
void device_check_batches(void *state);
/* Heights in single precision, of what is followed to its top. */
#define DEVICE_FOLLOWED_MM 1e-5
/* By the back end's name: four threads with a device each; raw heights, of which all but a few are
 * that near; where the time goes. */
void device_check_threads_raw_times(double near_mm);

#endif
