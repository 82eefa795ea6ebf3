/* SPDX-License-Identifier: MIT
 *
 * What the GPU core says of a device, over the null backend, and what faults make of it.
 */
#include "unit/gpu_fixture.h"

static void test_facts(void **state) {
    fixture *f = *state;
    gpu_device_info info;
    gpu_describe(f->g, &info);
    assert_string_equal(info.backend, "null");
    assert_int_equal(gpu_fact(f->g, "limit.storage_range"), 128 << 20);
    assert_int_equal(gpu_fact(f->g, "limit.groups"), 65535);
    assert_int_equal(gpu_fact(f->g, "feature.int64_atomics"), 0);
    assert_int_equal(gpu_fact(f->g, "selftest.ordered_rmw"), 0);
    assert_int_equal(gpu_fact(f->g, "selftest.sample_routing"), 0);
    assert_int_equal(gpu_fact(f->g, ""), 0);
    assert_int_equal(gpu_fact(f->g, "no.such.fact"), 0);
    assert_int_equal(gpu_fact(f->g, NULL), 0);
    gpu *g;
    base_error err = {0};
    assert_int_equal(gpu_open(&(gpu_open_info){.backend = "direct3d"}, &g, &err),
                     STRATA_ERROR_NOT_FOUND);
    assert_non_null(strstr(err.text, "direct3d"));
}

/* Injected facts stand above the device's; those that rest on others see what was injected. */
static void test_injected_facts(void **state) {
    fixture f;
    (void)state;
    open_device(&f, &(gpu_open_info){.backend = "null",
                                     .inject = "lacks:ordered_attachments,claims:limit.groups,"
                                               "claims:selftest.interlock"});
    assert_int_equal(gpu_fact(f.g, "ordered_attachments"), 0);
    assert_int_equal(gpu_fact(f.g, "limit.groups"), 1);
    assert_int_equal(gpu_fact(f.g, "selftest.interlock"), 1);
    assert_int_equal(gpu_fact(f.g, "selftest.inter"), 0);
    assert_int_equal(gpu_fact(f.g, "feature.fragment_interlock"), 0);
    assert_int_equal(gpu_fact(f.g, "ordered_access"), 1);
    gpu_close(f.g);
    open_device(&f, &(gpu_open_info){.backend = "null", .inject = "lacks:ordered_attachments"});
    assert_int_equal(gpu_fact(f.g, "ordered_access"), 0);
    gpu_close(f.g);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_facts, open_null, close_fixture),
        cmocka_unit_test(test_injected_facts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
