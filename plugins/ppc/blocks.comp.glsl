// SPDX-License-Identifier: MIT
//
// ppc, deep pass 3, one invocation a block: sorts its DEEP_BLOCK slots by (key, order) in registers.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "deep.glsl"

layout(std430) readonly buffer BlockOwner { uint block_owner[]; };
layout(std430) writeonly buffer Slots0 { uint slots0[]; };
#if STRATA_LAYOUT == 1
layout(std430) readonly buffer Slots1 { uint slots1[]; };
#define STRATA_SORT_FROM(at) slots1[at]
#else
#define STRATA_SORT_FROM(at) (at)
#endif
#define STRATA_SORT_TO(at, slot) slots0[at] = slot
#include "strata/sort_block.glsl"

void main() {
    uint block = strata_item();
    if (deep_fits == 0u || block >= blocks)
        return;
    uint deep = block_owner[block];
    uvec2 range = strata_range_at(lists[classes[CLASS_DEEP].offset + deep]);
    uint first = (block - deep_base[deep]) * DEEP_BLOCK;
#if STRATA_LAYOUT == 1
    uint from = block * DEEP_BLOCK;
#else
    uint from = range.x + first;
#endif
    strata_sort_block(from, block * DEEP_BLOCK, min(range.y - first, DEEP_BLOCK));
}
