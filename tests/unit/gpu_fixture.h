/* SPDX-License-Identifier: MIT
 *
 * What the tests of the GPU core share: a device with one scope, and short ways to make objects
 * that must come out. Included by test programs only.
 */
#ifndef STRATA_TESTS_GPU_FIXTURE_H
#define STRATA_TESTS_GPU_FIXTURE_H

#include "gpu/gpu.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct fixture {
    gpu *g;
    gpu_scope *scope;
    base_error err;
} fixture;

static inline void open_device(fixture *f, const gpu_open_info *info) {
    *f = (fixture){0};
    if (gpu_open(info, &f->g, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
    f->scope = gpu_scope_create(f->g, "test");
    assert_non_null(f->scope);
}

static inline int open_null(void **state) {
    fixture *f = malloc(sizeof *f);
    assert_non_null(f);
    open_device(f, &(gpu_open_info){.backend = "null"});
    *state = f;
    return 0;
}

static inline int close_fixture(void **state) {
    fixture *f = *state;
    gpu_close(f->g);
    free(f);
    return 0;
}

static inline strata_buffer make_buffer(fixture *f, const char *label, uint64_t size) {
    strata_buffer buffer;
    const strata_buffer_desc desc = {.struct_size = sizeof desc, .label = label, .size = size};
    if (gpu_buffer_create(f->scope, &desc, &buffer, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
    return buffer;
}

static inline strata_image make_image(fixture *f, const char *label, uint32_t format,
                                      uint32_t width, uint32_t height, uint32_t layers) {
    strata_image image;
    const strata_image_desc desc = {.struct_size = sizeof desc,
                                    .label = label,
                                    .format = format,
                                    .width = width,
                                    .height = height,
                                    .layers = layers};
    if (gpu_image_create(f->scope, &desc, &image, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
    return image;
}

/* 16x16, of RGBA32F. */
static inline strata_image make_multisampled(fixture *f, const char *label, uint32_t samples) {
    strata_image image;
    const strata_image_desc desc = {.struct_size = sizeof desc,
                                    .label = label,
                                    .format = STRATA_FORMAT_RGBA32F,
                                    .width = 16,
                                    .height = 16,
                                    .samples = samples};
    if (gpu_image_create(f->scope, &desc, &image, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
    return image;
}

static inline strata_program make_program(fixture *f, uint32_t kind, const strata_glsl *source) {
    strata_program program;
    const strata_program_desc desc = {
        .struct_size = sizeof desc, .kind = kind, .label = "program", .source = source};
    if (gpu_program_create(f->scope, &desc, &program, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
    return program;
}

static inline strata_bind bind_buffer(const char *name, strata_buffer buffer) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .name = name, .buffer = buffer};
}

static inline strata_bind bind_image(const char *name, strata_image image) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .name = name, .image = image};
}

static inline strata_bind bind_pool(strata_pool pool) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .pool = pool};
}

static inline void assert_logged(const fixture *f, const char *text) {
    if (!strstr(gpu_null_log(f->g), text))
        fail_msg("'%s' is not in the log:\n%s", text, gpu_null_log(f->g));
}

static inline void assert_not_logged(const fixture *f, const char *text) {
    if (strstr(gpu_null_log(f->g), text))
        fail_msg("'%s' is in the log:\n%s", text, gpu_null_log(f->g));
}

#endif
