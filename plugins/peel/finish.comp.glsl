// SPDX-License-Identifier: MIT
//
// peel, at the end: joins the walks, ends them at what color/1 holds, and sums what was taken and dropped.
#define PEEL_WALKS readonly
#include "state.glsl"
#include "strata/scan.glsl"
#include "walks.glsl"

layout(rgba32f) uniform image2D color;
layout(std430) buffer PeelTotals { uint peel_taken[2]; uint peel_dropped[2]; uint peel_largest; };

// Adds to a number of 64 bits: low word first.
#define PEEL_ADD(number, value)                                                                    \
    {                                                                                              \
        uint low = atomicAdd(number[0], value);                                                    \
        if (low + value < low)                                                                     \
            atomicAdd(number[1], 1u);                                                              \
    }

void main() {
    uint pixel = strata_item();
    uvec2 count = uvec2(0u), total;
    if (pixel < strata_pixel_count())
        count = peel_count[pixel];
    if (count.x > 0u) {
        ivec2 at = ivec2(strata_position(pixel));
        StrataElement walk = peel_walk[peel_slot(pixel, PEEL_FRONT)];
#if PEEL_SIDES == 2
        strata_fold_step(walk, peel_walk[peel_slot(pixel, PEEL_BACK)]);
#endif
        imageStore(color, at, strata_fold_end(walk, imageLoad(color, at)));
    }
    strata_scan(count.x, total.x);
    strata_scan(count.y, total.y);
    atomicMax(peel_largest, count.x + count.y);
    if (gl_LocalInvocationID.x == 0u) {
        PEEL_ADD(peel_taken, total.x)
        PEEL_ADD(peel_dropped, total.y)
    }
}
