// SPDX-License-Identifier: MIT
//
// ppc, deep pass 1, one invocation a deep pixel: tells each of its blocks whose it is. Sixteen blocks a
// turn keep the loop within drivers' budget of 65,535 turns for 2^24 fragments and more.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "strata/sort.glsl"
#include "deep.glsl"

layout(std430) writeonly buffer BlockOwner { uint block_owner[]; };
#if STRATA_LAYOUT == 1
layout(std430) writeonly buffer DeepCursor { uint deep_cursor[]; };
#endif

void main() {
    uint deep = strata_item();
    if (deep >= classes[CLASS_DEEP].count || deep_fits == 0u)
        return;
    uint count = blocks_of(strata_range_at(lists[classes[CLASS_DEEP].offset + deep]).y);
    uint base = deep_base[deep];
#define OWN(j)                                                                                     \
    if (i + j < count)                                                                             \
        block_owner[base + i + j] = deep;
    for (uint i = 0u; i < count; i += 16u) {
        STRATA_REPEAT_16(OWN, 0u)
    }
#if STRATA_LAYOUT == 1
    deep_cursor[deep] = 0u;
#endif
}
