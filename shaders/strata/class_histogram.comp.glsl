// SPDX-License-Identifier: MIT
//
// Classes, pass 1: pixels of each class, the largest count, blocks that the deep pixels will need.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "strata/classes.glsl"

#define PIXELS_PER_INVOCATION 16u

CLASS_TABLE(restrict)
shared uint group_count[CLASS_COUNT];
shared uint group_largest, group_blocks;

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane < CLASS_COUNT)
        group_count[lane] = 0u;
    if (lane == 0u) {
        group_largest = 0u;
        group_blocks = 0u;
    }
    barrier();
    uint first = strata_item() - lane; // of the group
    for (uint i = 0u; i < PIXELS_PER_INVOCATION; ++i) {
        uint pixel = first * PIXELS_PER_INVOCATION + i * STRATA_GROUP + lane;
        uint count = pixel < strata_pixel_count() ? strata_ranges[pixel].y : 0u;
        if (count == 0u)
            continue;
        uint c = class_of(count);
        atomicAdd(group_count[c], 1u);
        atomicMax(group_largest, count);
        if (c == CLASS_DEEP)
            atomicAdd(group_blocks, (count + DEEP_BLOCK - 1u) / DEEP_BLOCK);
    }
    barrier();
    if (lane < CLASS_COUNT && group_count[lane] > 0u)
        atomicAdd(classes[lane].count, group_count[lane]);
    if (lane == 0u && group_largest > 0u) {
        atomicMax(largest, group_largest);
        if (group_blocks > 0u)
            atomicAdd(blocks, group_blocks);
    }
}
