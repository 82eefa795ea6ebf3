// SPDX-License-Identifier: MIT
//
// Classes, pass 1: pixels of each class, the largest count, blocks that the deep pixels will need.
#include "strata/class_pixels.glsl"
#include "strata/classes.glsl"

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
    uvec2 block = class_block();
    uint pixels[CLASS_COUNT] = uint[](0u, 0u, 0u, 0u, 0u, 0u), most = 0u, deep_blocks = 0u;
    for (uint i = 0u; i < CLASS_PIXELS; ++i) {
        uint count = class_count(block, i);
        most = max(most, count);
        for (uint c = 0u; c < CLASS_COUNT; ++c)
            pixels[c] += uint(count > 0u && class_of(count) == c);
        if (class_of(count) == CLASS_DEEP)
            deep_blocks += (count + DEEP_BLOCK - 1u) / DEEP_BLOCK;
    }
    for (uint c = 0u; c < CLASS_COUNT; ++c)
        if (pixels[c] > 0u)
            atomicAdd(group_count[c], pixels[c]);
    if (most > 0u)
        atomicMax(group_largest, most);
    if (deep_blocks > 0u)
        atomicAdd(group_blocks, deep_blocks);
    barrier();
    if (lane < CLASS_COUNT && group_count[lane] > 0u)
        atomicAdd(classes[lane].count, group_count[lane]);
    if (lane == 0u && group_largest > 0u) {
        atomicMax(largest, group_largest);
        if (group_blocks > 0u)
            atomicAdd(blocks, group_blocks);
    }
}
