// SPDX-License-Identifier: MIT
//
// ppc, linked records only, deep pass 2, one invocation a record: a record of a deep pixel takes a
// place among that pixel's slots. Lists are not walked, so their length does not matter.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
layout(std430) readonly buffer StrataFragmentPool { uint strata_needed; uint strata_capacity; };
#include "deep.glsl"

layout(std430) readonly buffer DeepIndex { uint deep_index[]; };
layout(std430) buffer DeepCursor { uint deep_cursor[]; };
layout(std430) writeonly buffer Slots1 { uint slots1[]; };

void main() {
    uint slot = strata_item();
    if (slot >= strata_needed || deep_fits == 0u)
        return;
    uint pixel = strata_links[slot].y;
    if (class_of(strata_ranges[pixel].y) != CLASS_DEEP)
        return;
    uint deep = deep_index[pixel];
    slots1[deep_base[deep] * DEEP_BLOCK + atomicAdd(deep_cursor[deep], 1u)] = slot;
}
