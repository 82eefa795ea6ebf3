/* SPDX-License-Identifier: MIT
 *
 * What the GPU tests stand on: a device of a named backend, one-line makers of objects that fail
 * the test in their own words, and a memory of results, so that the second backend is held to
 * the bits of the first.
 */
#ifndef STRATA_TESTS_GPU_RIG_H
#define STRATA_TESTS_GPU_RIG_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/gpu.h"

typedef struct rig {
    gpu *g;
    gpu_scope *scope;
    const char *backend;
} rig;

/* NULL when the backend cannot be opened: prints why. Validation is on; passes are not timed, since
 * the barriers around timestamps would hide those that are missing. */
rig *rig_open(const char *backend);
void rig_close(rig *r);
/* Ends all objects of the scope and starts a new one. */
void rig_clear(rig *r);

strata_buffer rig_buffer(rig *r, const char *label, uint64_t size, const void *data);
strata_image rig_image(rig *r, const char *label, uint32_t format, uint32_t width, uint32_t height,
                       uint32_t layers);
strata_image rig_multisampled(rig *r, const char *label, uint32_t format, uint32_t width,
                              uint32_t height, uint32_t samples);
/* `text` must be a literal: programs keep it. */
strata_program rig_program(rig *r, uint32_t kind, const char *text);
strata_draws rig_draws(rig *r, strata_buffer commands, strata_buffer count, strata_buffer indices,
                       uint32_t capacity);

strata_bind rig_bind_buffer(const char *name, strata_buffer buffer);
strata_bind rig_bind_image(const char *name, strata_image image);
strata_bind rig_bind_pool(strata_pool pool);

void rig_pass(rig *r, strata_pass pass); /* struct_size and a missing label are filled in */
void rig_submit(rig *r);
void rig_read(rig *r, strata_buffer buffer, void *data, uint64_t size);
void rig_texels(rig *r, strata_image image, uint32_t layer, void *texels, size_t size);

/* The same bits as under this name before, on whatever backend that was. */
void rig_same(rig *r, const char *name, const void *data, size_t size);

/* A scene of the test's own for scene programs: strata/vertex.glsl with an identity camera, one
 * record each of `instances`, positions in clip space. Bound as globals, until the next scene. */
typedef struct rig_placement { /* of one record */
    float scale, x, y, z;
    uint32_t primitive_base;
} rig_placement;
void rig_scene(rig *r, uint32_t width, uint32_t height, strata_buffer positions,
               const rig_placement *placements, uint32_t instances);

#endif
