// SPDX-License-Identifier: MIT
//
// ppc, deep pass 4 and on, one invocation a block of output: merges neighbouring sorted runs of
// params.run slots into runs twice as long.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "deep.glsl"

layout(std430) readonly buffer BlockOwner { uint block_owner[]; };
layout(std430) buffer Slots0 { uint slots0[]; };
layout(std430) buffer Slots1 { uint slots1[]; };
STRATA_PARAMS { uint run; uint from; } params;

uint slot_at(uint at) { return params.from == 0u ? slots0[at] : slots1[at]; }

void put(uint at, uint slot) {
    if (params.from == 0u)
        slots1[at] = slot;
    else
        slots0[at] = slot;
}

#define STRATA_MERGE_FROM(at) slot_at(at)
#define STRATA_MERGE_TO(at, slot) put(at, slot)
#include "strata/merge.glsl"

void main() {
    uint block = strata_item();
    if (deep_fits == 0u || block >= blocks)
        return;
    uint deep = block_owner[block];
    uint count = strata_range_at(lists[classes[CLASS_DEEP].offset + deep]).y;
    uint base = deep_base[deep] * DEEP_BLOCK;
    uint begin = block * DEEP_BLOCK - base; // of the output, within the pixel
    strata_merge(base, count, params.run, begin, begin + DEEP_BLOCK);
}
