/* SPDX-License-Identifier: MIT
 *
 * Self-tests of driver behaviour on every backend: they run once, are kept on disk, and a kept
 * result is believed only when it is whole. With times that are not sound, passes are timed by the
 * clock and come out the same.
 */
#define _POSIX_C_SOURCE 200809L
#include "gpu/gpu_internal.h"
#include "unit/gpu_fixture.h"

#include <dirent.h>
#include <unistd.h>

static const char *current;
static char folder[64], kept[512];

static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/strata-selftest-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

/* 0 when the backend cannot be opened here. */
static int open_current(fixture *f, int profile) {
    *f = (fixture){0};
    const gpu_open_info info = {.backend = current, .cache_dir = folder, .profile = profile};
    if (gpu_open(&info, &f->g, &f->err) != STRATA_OK) {
        print_message("%s: skipped: %s\n", current, f->err.text);
        return 0;
    }
    f->scope = gpu_scope_create(f->g, "test");
    assert_non_null(f->scope);
    return 1;
}

/* The file that keeps the result of a test; 0 when there is none. */
static int find_kept(const char *id) {
    char path[128];
    int found = 0;
    snprintf(path, sizeof path, "%s/selftest", folder);
    DIR *directory = opendir(path);
    if (!directory)
        return 0;
    for (struct dirent *item = readdir(directory); item; item = readdir(directory)) {
        if (!strstr(item->d_name, id))
            continue;
        snprintf(kept, sizeof kept, "%s/%s", path, item->d_name);
        found = 1;
    }
    closedir(directory);
    return found;
}

/* Replaces the last digit of the kept result; the rest of the file stays. */
static void keep_digit(char digit) {
    unsigned char *data = NULL;
    size_t size = 0;
    base_error err = {0};
    assert_int_equal(base_file_read(kept, 4096, &data, &size, &err), STRATA_OK);
    assert_true(size > 2 && (data[size - 2] == '0' || data[size - 2] == '1'));
    data[size - 2] = (unsigned char)digit;
    FILE *file = fopen(kept, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    free(data);
}

static void check_kept(const char *id, const char *name) {
    fixture f;
    if (!open_current(&f, 0))
        return;
    uint64_t value = gpu_fact(f.g, id);
    assert_true(value <= 1);
    assert_int_equal(gpu_fact(f.g, id), value);
    gpu_close(f.g);
    assert_true(find_kept(name));
    keep_digit(value ? '0' : '1'); /* believed: it is not run again */
    assert_true(open_current(&f, 0));
    assert_int_equal(gpu_fact(f.g, id), !value);
    gpu_close(f.g);
    keep_digit('7'); /* not a result: run again */
    assert_true(open_current(&f, 0));
    assert_int_equal(gpu_fact(f.g, id), value);
    assert_int_equal(gpu_bytes_peak(f.g, NULL), 0); /* nothing of it is on this device's account */
    gpu_close(f.g);
}

static void test_ordered_rmw(void **state) {
    (void)state;
    check_kept("selftest.ordered_rmw", "ordered_rmw");
}

/* Never without the feature. */
static void test_interlock(void **state) {
    fixture f;
    (void)state;
    if (!open_current(&f, 0))
        return;
    assert_true(gpu_fact(f.g, "selftest.interlock") <= gpu_fact(f.g, "feature.fragment_interlock"));
    gpu_close(f.g);
    check_kept("selftest.interlock", "interlock");
}

static void test_ordered_attachments(void **state) {
    (void)state;
    check_kept("selftest.ordered_attachments", "ordered_attachments");
}

static void test_sample_routing(void **state) {
    (void)state;
    check_kept("selftest.sample_routing", "sample_routing");
}

/* Mesa's software drivers, as far as they were looked at. */
static void test_sample_routing_fails(void **state) {
    fixture f;
    gpu_device_info info;
    (void)state;
    if (!open_current(&f, 0))
        return;
    gpu_describe(f.g, &info);
    if (strstr(info.name, "llvmpipe") &&
        (strstr(info.driver, "22.3.6") || strstr(info.driver, "25.0.7")))
        assert_int_equal(gpu_fact(f.g, "selftest.sample_routing"), 0);
    gpu_close(f.g);
}

/* Vulkan's samples, wherever they lie, are routed right where triangles cover pixels whole: these
 * have two edges between pixels and the third far outside. So the self-test can be passed. OpenGL's
 * samples need not do even that. */
static void test_sample_routing_passes(void **state) {
    static const char corner[] =
        "STRATA_CORNER(v)=vec2((v / 3u + 1u) * 11u & 63u, (v / 3u + 1u) * 23u & 63u) / 32.0 - 1.0 +"
        " vec2(v % 3u == 1u ? 8.0 : 0.0, v % 3u == 2u ? 8.0 : 0.0)";
    fixture f;
    (void)state;
    if (!open_current(&f, 0))
        return;
    f.g->selftest_running = 1;
    if (strcmp(current, "vulkan") == 0 && gpu_fact(f.g, "limit.samples") > 1)
        assert_int_equal(gpu_selftest_routing(f.g, f.scope, corner), 1);
    gpu_close(f.g);
}

static void test_timestamps(void **state) {
    (void)state;
    check_kept("selftest.timestamps", "timestamps");
}

static const strata_glsl step = {"layout(local_size_x = 1) in;\n"
                                 "layout(std430) buffer Value { uint value; };\n"
                                 "void main() { value = value * 10u + 3u; }\n",
                                 "step.glsl"};

static void check_passes(void) {
    fixture f;
    uint32_t value = 1, count = 0;
    assert_true(open_current(&f, 1));
    strata_buffer buffer = make_buffer(&f, "value", 4);
    const strata_bind bind = bind_buffer("Value", buffer);
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "step",
                              .groups = {1},
                              .program = make_program(&f, STRATA_PROGRAM_COMPUTE, &step),
                              .binds = &bind,
                              .bind_count = 1};
    gpu_begin(f.g, 1, 1);
    gpu_fill(f.g, "test", buffer, 0, 4, 1);
    gpu_pass(f.g, "test", &pass);
    gpu_pass(f.g, "test", &pass);
    gpu_fill(f.g, "test", buffer, 0, 4, 2);
    gpu_pass(f.g, "test", &pass);
    if (gpu_submit(f.g, &f.err) != STRATA_OK)
        fail_msg("%s", f.err.text);
    assert_int_equal(gpu_buffer_read(f.g, buffer, 0, 4, &value, &f.err), STRATA_OK);
    assert_int_equal(value, 23);
    const gpu_timing *timings = gpu_timings(f.g, &count);
    assert_int_equal(count, 3);
    for (uint32_t i = 0; i < count; i++)
        assert_true(timings[i].gpu_ms >= 0.0 && timings[i].gpu_ms < 60000.0);
    gpu_close(f.g);
}

static void test_clock(void **state) {
    fixture f;
    (void)state;
    if (!open_current(&f, 0))
        return;
    gpu_fact(f.g, "selftest.timestamps");
    gpu_close(f.g);
    assert_true(find_kept("timestamps"));
    keep_digit('1');
    check_passes();
    keep_digit('0');
    check_passes();
}

#define IN_FOLDER(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)

int main(void) {
    const struct CMUnitTest selftests[] = {
        IN_FOLDER(test_ordered_rmw),
        IN_FOLDER(test_interlock),
        IN_FOLDER(test_ordered_attachments),
        IN_FOLDER(test_sample_routing),
        IN_FOLDER(test_sample_routing_fails),
        IN_FOLDER(test_sample_routing_passes),
        IN_FOLDER(test_timestamps),
        IN_FOLDER(test_clock),
    };
    current = "vulkan";
    int failed = cmocka_run_group_tests_name("vulkan", selftests, NULL, NULL);
    current = "gl";
    return failed + cmocka_run_group_tests_name("gl", selftests, NULL, NULL);
}
