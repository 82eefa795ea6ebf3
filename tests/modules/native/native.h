/* SPDX-License-Identifier: MIT
 *
 * What the parts of the test module share: the buffers of one instance, and the pass of each API
 * that copies the first half of `source` to `target`, fills the rest with 0.25 and the pool's plane
 * with 3.
 */
#ifndef STRATA_TESTS_NATIVE_H
#define STRATA_TESTS_NATIVE_H

#include "strata/strata.h"

#define NATIVE_QUARTER 0x3e800000u /* the bits of 0.25f */
#define NATIVE_POOL    3u

typedef struct native {
    const strata_gpu *gpu;
    const strata_ext_gl *gl;         /* NULL on other backends, or when the knob says portable */
    const strata_ext_vulkan *vulkan; /* as above */
    uint32_t portable, fault;
    uint32_t mistake; /* the callback makes a call that the driver's validation refuses */
    uint32_t width;
    uint64_t bytes; /* of source and target; half of it a multiple of 4 */
    strata_buffer source, target;
    strata_pool pool;
    strata_image color;
    strata_program produce, consume;
} native;

void native_pass_gl(native *n, void *frame_self, const strata_pass *pass);
void native_pass_vulkan(native *n, void *frame_self, const strata_pass *pass);

#endif
