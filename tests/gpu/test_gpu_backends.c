/* SPDX-License-Identifier: MIT
 *
 * The same passes on every backend, against values worked out by hand and against each other, bit
 * for bit. Backends are named on the command line, all real ones by default; one that cannot be
 * opened is skipped with its reason. Driver validation is on and fails what it complains about.
 */
#include "gpu/backend_tests.h"

static const char *current;

static int open_backend(void **state) {
    *state = rig_open(current);
    return 0;
}

static int close_backend(void **state) {
    if (*state)
        rig_close(*state);
    return 0;
}

static int run_on(const char *backend) {
    char storage[64], targets[64], drawing[64];
    current = backend;
    snprintf(storage, sizeof storage, "%s: storage", backend);
    snprintf(targets, sizeof targets, "%s: targets", backend);
    snprintf(drawing, sizeof drawing, "%s: drawing", backend);
    return _cmocka_run_group_tests(storage, storage_tests, storage_test_count, open_backend,
                                   close_backend) +
           _cmocka_run_group_tests(targets, target_tests, target_test_count, open_backend,
                                   close_backend) +
           _cmocka_run_group_tests(drawing, drawing_tests, drawing_test_count, open_backend,
                                   close_backend);
}

int main(int argc, char **argv) {
    int failed = 0;
    if (argc > 1) {
        for (int i = 1; i < argc; i++)
            failed += run_on(argv[i]);
        return failed;
    }
    return run_on("vulkan") + run_on("gl");
}
