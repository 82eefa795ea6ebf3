// SPDX-License-Identifier: MIT
//
// Classes, pass 2: writes each pixel into the list of its class; with CLASS_BLOCKS deep pixels also
// take their blocks. The order within a list depends on scheduling, the image does not.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "strata/classes.glsl"

#define PIXELS_PER_INVOCATION 16u

CLASS_TABLE(restrict)
layout(std430) writeonly buffer Lists { uint lists[]; };
#ifdef CLASS_BLOCKS
layout(std430) writeonly buffer DeepBase { uint deep_base[]; };
#if STRATA_LAYOUT == 1
layout(std430) writeonly buffer DeepIndex { uint deep_index[]; };
#endif
#endif
shared uint group_count[CLASS_COUNT], group_offset[CLASS_COUNT];

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint first = strata_item() - lane;
    if (lane < CLASS_COUNT)
        group_count[lane] = 0u;
    barrier();
    for (uint i = 0u; i < PIXELS_PER_INVOCATION; ++i) {
        uint pixel = first * PIXELS_PER_INVOCATION + i * STRATA_GROUP + lane;
        uint count = pixel < strata_pixel_count() ? strata_ranges[pixel].y : 0u;
        if (count > 0u)
            atomicAdd(group_count[class_of(count)], 1u);
    }
    barrier();
    if (lane < CLASS_COUNT) {
        group_offset[lane] = classes[lane].offset +
                             (group_count[lane] > 0u
                                  ? atomicAdd(classes[lane].cursor, group_count[lane])
                                  : 0u);
        group_count[lane] = 0u;
    }
    barrier();
    for (uint i = 0u; i < PIXELS_PER_INVOCATION; ++i) {
        uint pixel = first * PIXELS_PER_INVOCATION + i * STRATA_GROUP + lane;
        uint count = pixel < strata_pixel_count() ? strata_ranges[pixel].y : 0u;
        if (count == 0u)
            continue;
        uint c = class_of(count);
        uint at = group_offset[c] + atomicAdd(group_count[c], 1u);
        lists[at] = pixel;
#ifdef CLASS_BLOCKS
        if (c == CLASS_DEEP) {
            uint deep = at - classes[CLASS_DEEP].offset;
            uint base = atomicAdd(cursor, (count + DEEP_BLOCK - 1u) / DEEP_BLOCK);
            if (deep_fits == 0u)
                continue;
            deep_base[deep] = base;
#if STRATA_LAYOUT == 1
            deep_index[pixel] = deep;
#endif
        }
#endif
    }
}
