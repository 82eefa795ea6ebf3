// SPDX-License-Identifier: MIT
//
// ppc, linked records only, deep pass 2, one invocation a record: a record of a deep pixel takes a
// place among that pixel's slots. Lists are not walked, so their length does not matter.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "deep.glsl"
#include "strata/pool.glsl"

layout(std430) readonly buffer DeepIndex { uint deep_index[]; };
layout(std430) buffer DeepCursor { uint deep_cursor[]; };
layout(std430) writeonly buffer Slots1 { uint slots1[]; };

void main() {
    uint slot = strata_item();
    if (slot >= strata_pool_needed() || deep_fits == 0u)
        return;
    uint pixel = strata_link_at(slot).y;
    if (class_of(strata_range_at(pixel).y) != CLASS_DEEP)
        return;
    uint deep = deep_index[pixel];
    slots1[deep_base[deep] * DEEP_BLOCK + atomicAdd(deep_cursor[deep], 1u)] = slot;
}
