// SPDX-License-Identifier: MIT
//
// Classes, pass 2: writes each pixel into the list of its class; with CLASS_BLOCKS deep pixels also
// take their blocks. The order within a list depends on scheduling, the image does not.
#include "strata/class_pixels.glsl"
#include "strata/classes.glsl"

CLASS_TABLE(restrict)
layout(std430) writeonly buffer Lists { uint lists[]; };
#ifdef CLASS_BLOCKS
layout(std430) writeonly buffer DeepBase { uint deep_base[]; };
#if STRATA_LAYOUT == 1
layout(std430) writeonly buffer DeepIndex { uint deep_index[]; };
#endif

void take_blocks(uint pixel, uint count, uint deep) {
    uint base = atomicAdd(cursor, (count + DEEP_BLOCK - 1u) / DEEP_BLOCK);
    if (deep_fits == 0u)
        return;
    deep_base[deep] = base;
#if STRATA_LAYOUT == 1
    deep_index[pixel] = deep;
#endif
}
#endif
shared uint group_count[CLASS_COUNT], group_offset[CLASS_COUNT];

void main() {
    uint lane = gl_LocalInvocationID.x;
    if (lane < CLASS_COUNT)
        group_count[lane] = 0u;
    barrier();
    uvec2 block = class_block();
    uint counts[CLASS_PIXELS], next[CLASS_COUNT] = uint[](0u, 0u, 0u, 0u, 0u, 0u);
    for (uint i = 0u; i < CLASS_PIXELS; ++i) {
        counts[i] = class_count(block, i);
        for (uint c = 0u; c < CLASS_COUNT; ++c)
            next[c] += uint(counts[i] > 0u && class_of(counts[i]) == c);
    }
    for (uint c = 0u; c < CLASS_COUNT; ++c)
        if (next[c] > 0u)
            next[c] = atomicAdd(group_count[c], next[c]);
    barrier();
    if (lane < CLASS_COUNT)
        group_offset[lane] = classes[lane].offset +
                             (group_count[lane] > 0u
                                  ? atomicAdd(classes[lane].cursor, group_count[lane])
                                  : 0u);
    barrier();
    for (uint c = 0u; c < CLASS_COUNT; ++c)
        next[c] += group_offset[c];
    for (uint i = 0u; i < CLASS_PIXELS; ++i) {
        uint at = 0u;
        for (uint c = 0u; c < CLASS_COUNT; ++c) {
            bool mine = class_of(counts[i]) == c;
            at = mine ? next[c] : at;
            next[c] += uint(mine && counts[i] > 0u);
        }
        if (counts[i] == 0u)
            continue;
        uint pixel = class_pixel(block, i);
        lists[at] = pixel;
#ifdef CLASS_BLOCKS
        if (class_of(counts[i]) == CLASS_DEEP)
            take_blocks(pixel, counts[i], at - classes[CLASS_DEEP].offset);
#endif
    }
}
