// SPDX-License-Identifier: MIT
//
// peel, at the end: joins the walks, ends them at what color/1 holds, and sums what was taken and dropped.
#define PEEL_WALKS readonly
#include "state.glsl"
#include "strata/scan.glsl"
#include "walks.glsl"

layout(rgba32f) uniform image2D color;
layout(std430) buffer PeelTotals { uint peel_taken[2]; uint peel_dropped[2]; uint peel_largest; };

const uint PEEL_SHARE = 16u; // pixels an invocation

// Adds to a number of 64 bits: low word first.
#define PEEL_ADD(number, value)                                                                    \
    {                                                                                              \
        uint low = atomicAdd(number[0], value);                                                    \
        if (low + value < low)                                                                     \
            atomicAdd(number[1], 1u);                                                              \
    }

void peel_finish(uint pixel) {
    ivec2 at = ivec2(strata_position(pixel));
    StrataElement walk = peel_walk[peel_slot(pixel, PEEL_FRONT)];
#if PEEL_SIDES == 2
    strata_fold_step(walk, peel_walk[peel_slot(pixel, PEEL_BACK)]);
#endif
    imageStore(color, at, strata_fold_end(walk, imageLoad(color, at)));
}

void main() {
    uint first = strata_item() * PEEL_SHARE, largest = 0u;
    uint last = min(first + PEEL_SHARE, strata_pixel_count());
    uvec2 sum = uvec2(0u);
    for (uint pixel = first; pixel < last; ++pixel) {
        uvec2 count = peel_count[pixel];
        sum += count;
        largest = max(largest, count.x + count.y);
        if (count.x > 0u)
            peel_finish(pixel);
    }
    if (largest == 0u)
        return;
    atomicMax(peel_largest, largest);
    PEEL_ADD(peel_taken, sum.x)
    PEEL_ADD(peel_dropped, sum.y)
}
