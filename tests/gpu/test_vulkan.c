/* SPDX-License-Identifier: MIT
 *
 * What only the Vulkan backend has: the choice of a device, validation that fails a submit, the
 * pipeline cache on disk, sub-allocation, sizes beyond the device, and a lost device.
 */
#define _POSIX_C_SOURCE 200809L
#include "gpu/vk/vk_internal.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static const gpu_backend *const backend = &gpu_backend_vulkan;

static vk *open_device(const char *device, const char *cache_dir) {
    const gpu_open_info info = {.check = 1, .device = device, .cache_dir = cache_dir};
    gpu_backend_caps caps;
    base_error err = {0};
    void *self = NULL;
    if (backend->open(&info, &self, &caps, &err) == STRATA_ERROR_UNSUPPORTED) {
        printf("skipped: %s\n", err.text);
        skip();
    }
    assert_int_equal(err.result, STRATA_OK);
    assert_true(caps.storage_range >= 1u << 27 && caps.image_size >= 4096 && caps.name[0]);
    return self;
}

static vk_buffer *make_buffer(vk *v, uint64_t size) {
    const strata_buffer_desc desc = {.label = "buffer", .size = size};
    base_error err = {0};
    void *native = NULL;
    if (backend->buffer_create(v, &desc, &native, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return native;
}

/* ---- devices ----------------------------------------------------------------------------- */

typedef struct first_device {
    uint32_t count;
    char name[256];
} first_device;

static void on_device(void *user, const gpu_device_info *info, uint32_t index) {
    first_device *first = user;
    assert_int_equal(index, first->count);
    assert_string_equal(info->backend, "vulkan");
    assert_true(info->driver[0]);
    if (!first->count++)
        snprintf(first->name, sizeof first->name, "%s", info->name);
}

static void test_choice(void **state) {
    (void)state;
    first_device first = {0};
    backend->enumerate(on_device, &first);
    backend->close(open_device(NULL, NULL)); /* skips where there is none */
    assert_true(first.count > 0);
    backend->close(open_device("0", NULL));
    first.name[4] = 0; /* a part of the name */
    backend->close(open_device(first.name, NULL));
    static const char *const wrong[] = {"no such device", "99", "99999999999999999999", "-1"};
    for (size_t i = 0; i < BASE_COUNT(wrong); i++) {
        const gpu_open_info info = {.device = wrong[i]};
        gpu_backend_caps caps;
        base_error err = {0};
        void *self = NULL;
        assert_int_equal(backend->open(&info, &self, &caps, &err), STRATA_ERROR_UNSUPPORTED);
        assert_non_null(strstr(err.text, wrong[i]));
        assert_null(self);
    }
}

/* ---- validation -------------------------------------------------------------------------- */

/* A copy reads what a fill wrote, once with the barrier between them and once without. */
static strata_result fill_and_copy(vk *v, vk_buffer *a, vk_buffer *b, uint32_t barriers,
                                   base_error *err) {
    const gpu_barrier barrier = {
        .native = a, .before = GPU_ACCESS_COPY_WRITE, .after = GPU_ACCESS_COPY_READ};
    backend->begin(v);
    backend->fill(v, a, 0, 256, 7, NULL, 0);
    backend->copy(v, b, 0, a, 0, 256, &barrier, barriers);
    return backend->submit(v, NULL, 0, err);
}

static void test_hazard_fails_submit(void **state) {
    (void)state;
    vk *v = open_device(NULL, NULL);
    vk_buffer *a = make_buffer(v, 256), *b = make_buffer(v, 256);
    base_error err = {0};
    assert_int_equal(fill_and_copy(v, a, b, 1, &err), STRATA_OK);
    assert_int_equal(fill_and_copy(v, a, b, 0, &err), STRATA_ERROR_INTERNAL);
    assert_non_null(strstr(err.text, "HAZARD"));
    err = (base_error){0};
    assert_int_equal(fill_and_copy(v, a, b, 1, &err), STRATA_OK); /* reported once */
    backend->buffer_destroy(v, a);
    backend->buffer_destroy(v, b);
    backend->close(v);
}

static void test_bad_shader(void **state) {
    (void)state;
    vk *v = open_device(NULL, NULL);
    const uint32_t words[5] = {0x07230203u, 0x00010300u, 0, 1, 0}; /* a header and nothing else */
    const gpu_program_info info = {
        .label = "bad", .kind = STRATA_PROGRAM_FULLSCREEN, .spirv = {words}, .words = {5}};
    base_error err = {0};
    void *native = NULL;
    assert_true(backend->program_create(v, &info, &native, &err) < 0);
    assert_null(native);
    backend->close(v);
}

/* ---- memory ------------------------------------------------------------------------------ */

static void test_sub_allocation(void **state) {
    (void)state;
    enum { COUNT = 700 };
    vk *v = open_device(NULL, NULL);
    vk_buffer *buffers[COUNT];
    for (uint32_t i = 0; i < COUNT; i++) {
        buffers[i] = make_buffer(v, 4 + 1000 * (uint64_t)i);
        for (uint32_t k = 0; k < i; k++) {
            const vk_memory *a = &buffers[i]->memory, *b = &buffers[k]->memory;
            if (a->memory == b->memory)
                assert_true(a->offset + buffers[i]->size <= b->offset ||
                            b->offset + buffers[k]->size <= a->offset);
        }
    }
    for (uint32_t i = 0; i < COUNT; i += 2) {
        backend->buffer_destroy(v, buffers[i]);
        buffers[i] = make_buffer(v, 5000);
    }
    for (uint32_t i = 0; i < COUNT; i++)
        backend->buffer_destroy(v, buffers[i]);
    assert_null(v->blocks); /* nothing is kept */
    backend->close(v);
}

static void test_too_large(void **state) {
    (void)state;
    vk *v = open_device(NULL, NULL);
    const strata_buffer_desc buffer = {.label = "huge", .size = UINT64_C(1) << 50};
    const strata_image_desc image = {.label = "huge",
                                     .format = STRATA_FORMAT_RGBA32F,
                                     .width = 16384,
                                     .height = 16384,
                                     .layers = 2048};
    const strata_image_desc unknown = {.label = "odd", .format = 77, .width = 1, .height = 1};
    base_error err = {0};
    void *native = NULL;
    assert_int_equal(backend->buffer_create(v, &buffer, &native, &err),
                     STRATA_ERROR_OUT_OF_DEVICE_MEMORY);
    err = (base_error){0};
    assert_int_equal(backend->image_create(v, &image, &native, &err),
                     STRATA_ERROR_OUT_OF_DEVICE_MEMORY);
    err = (base_error){0};
    assert_int_equal(backend->image_create(v, &unknown, &native, &err), STRATA_ERROR_UNSUPPORTED);
    assert_null(native);
    backend->buffer_destroy(v, make_buffer(v, 4)); /* it goes on */
    backend->close(v);
}

/* ---- the pipeline cache ------------------------------------------------------------------ */

static int cache_file(const char *folder, char *path, size_t size) {
    DIR *dir = opendir(folder);
    int count = 0;
    assert_non_null(dir);
    for (struct dirent *entry = readdir(dir); entry; entry = readdir(dir))
        if (entry->d_name[0] != '.') {
            snprintf(path, size, "%s/%s", folder, entry->d_name);
            count++;
        }
    closedir(dir);
    return count;
}

static void test_cache(void **state) {
    (void)state;
    char folder[] = "/tmp/strata-test-XXXXXX", path[512];
    assert_non_null(mkdtemp(folder));
    backend->close(open_device(NULL, folder));
    assert_int_equal(cache_file(folder, path, sizeof path), 1);
    unsigned char *first = NULL, *second = NULL;
    size_t first_size = 0, second_size = 0;
    base_error err = {0};
    assert_int_equal(base_file_read(path, 1u << 20, &first, &first_size, &err), STRATA_OK);
    static const char *const damage[] = {"", "short", "long enough for a hash, and wrong"};
    for (size_t i = 0; i < BASE_COUNT(damage); i++) {
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        fputs(damage[i], file);
        fclose(file);
        backend->close(
            open_device(NULL, folder)); /* validation is silent: the driver saw none of it */
        assert_int_equal(base_file_read(path, 1u << 20, &second, &second_size, &err), STRATA_OK);
        assert_int_equal(second_size, first_size);
        assert_memory_equal(second, first, first_size);
        free(second);
    }
    free(first);
    unlink(path);
    assert_int_equal(cache_file(folder, path, sizeof path), 0);
    rmdir(folder);
    backend->close(open_device(NULL, folder)); /* a folder that is not there */
}

/* ---- a lost device ----------------------------------------------------------------------- */

static void test_lost(void **state) {
    (void)state;
    vk *v = open_device(NULL, NULL);
    const strata_buffer_desc buffer_desc = {.label = "b", .size = 256};
    const strata_image_desc image_desc = {
        .label = "i", .format = STRATA_FORMAT_RGBA8, .width = 2, .height = 2};
    const gpu_program_info program_desc = {.label = "p"};
    const float zero[4] = {0};
    vk_buffer *a = make_buffer(v, 256), *b = make_buffer(v, 256);
    void *image = NULL, *native = NULL;
    unsigned char bytes[256];
    double ms[2] = {5, 5};
    base_error err = {0};
    assert_int_equal(backend->image_create(v, &image_desc, &image, &err), STRATA_OK);
    backend->begin(v);
    backend->fill(v, a, 0, 256, 1, NULL, 0);
    assert_int_equal(vk_fail(v, VK_ERROR_DEVICE_LOST, &err, "test"), STRATA_ERROR_DEVICE_LOST);
    backend->copy(v, b, 0, a, 0, 256, NULL, 0);
    backend->clear_image(v, image, zero, NULL, 0);
    const strata_result results[] = {
        backend->submit(v, ms, 2, &err),
        backend->buffer_create(v, &buffer_desc, &native, &err),
        backend->image_create(v, &image_desc, &native, &err),
        backend->program_create(v, &program_desc, &native, &err),
        backend->buffer_read(v, a, 0, 256, bytes, &err),
        backend->buffer_write(v, a, 0, 256, bytes, &err),
        backend->image_read(v, image, 0, bytes, 16, &err),
        backend->image_write(v, image, 0, 0, 0, 2, 2, bytes, &err),
    };
    for (size_t i = 0; i < BASE_COUNT(results); i++)
        assert_int_equal(results[i], STRATA_ERROR_DEVICE_LOST);
    assert_true(ms[0] < 0 && ms[1] < 0);
    assert_null(native);
    backend->begin(v);
    backend->buffer_destroy(v, a);
    backend->buffer_destroy(v, b);
    backend->image_destroy(v, image);
    backend->close(v);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_choice),     cmocka_unit_test(test_hazard_fails_submit),
        cmocka_unit_test(test_bad_shader), cmocka_unit_test(test_sub_allocation),
        cmocka_unit_test(test_too_large),  cmocka_unit_test(test_cache),
        cmocka_unit_test(test_lost),
    };
    return cmocka_run_group_tests_name("vulkan", tests, NULL, NULL);
}
