/* SPDX-License-Identifier: MIT
 *
 * Builds small GLB files in memory, for tests of the loader: buffer views and accessors from
 * arrays, everything else as JSON text. Allocation failures end the program.
 */
#ifndef STRATA_TESTS_GLB_H
#define STRATA_TESTS_GLB_H

#include "base/base.h"

typedef struct test_glb { /* zero-initialised = empty */
    base_text binary, views, accessors, rest;
    uint32_t view_count, accessor_count;
} test_glb;

enum {
    TEST_GLB_I8 = 5120,
    TEST_GLB_U8,
    TEST_GLB_I16,
    TEST_GLB_U16,
    TEST_GLB_U32 = 5125,
    TEST_GLB_F32
};

/* Both return the new index. stride 0: packed. */
uint32_t test_glb_view(test_glb *g, const void *data, size_t size, uint32_t stride);
/* view UINT32_MAX: none. more: further members with a leading comma, or "". */
uint32_t test_glb_accessor(test_glb *g, uint32_t view, int component, const char *type,
                           uint64_t count, const char *more);
/* A packed array of floats and its accessor in one. */
uint32_t test_glb_floats(test_glb *g, const char *type, uint32_t width, uint32_t count,
                         const float *values);

/* Further top-level members of the JSON, without a leading comma: "\"meshes\":[...]". */
void test_glb_json(test_glb *g, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The whole file, to be freed; g is emptied. */
unsigned char *test_glb_finish(test_glb *g, size_t *size);

/* A GLB of any JSON text and binary chunk. */
unsigned char *test_glb_pack(const char *json, const void *binary, size_t binary_size,
                             size_t *size);

/* A PNG of width x height, all of one colour r, g, b, a, appended to `png`; stored, not compressed.
 */
void test_glb_png(base_text *png, uint32_t width, uint32_t height, const unsigned char color[4]);

#endif
