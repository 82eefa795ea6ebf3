// SPDX-License-Identifier: MIT
//
// ppc, deep pass 4 and on, one invocation a block of output: merges neighbouring sorted runs of
// params.run slots into runs twice as long. Where a block's output begins in its two runs is found by
// bisection along the merge path (Green, McColl, Bader 2012).
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

void main() {
    uint block = strata_item();
    if (deep_fits == 0u || block >= blocks)
        return;
    uint deep = block_owner[block];
    uint count = strata_ranges[lists[classes[CLASS_DEEP].offset + deep]].y;
    uint base = deep_base[deep] * DEEP_BLOCK;
    uint begin = block * DEEP_BLOCK - base; // of the output, within the pixel
    uint left = begin / (2u * params.run) * (2u * params.run);
    uint middle = min(left + params.run, count), right = min(left + 2u * params.run, count);
    uint skip = begin - left; // elements of the two runs that earlier blocks put out

    uint low = skip > right - middle ? skip - (right - middle) : 0u;
    uint high = min(skip, middle - left);
    while (low < high) {
        uint a = (low + high) / 2u;
        uvec2 key_a = strata_keys[slot_at(base + left + a)];
        uvec2 key_b = strata_keys[slot_at(base + middle + skip - 1u - a)];
        if (strata_before(key_a, key_b))
            low = a + 1u;
        else
            high = a;
    }
    uint a = left + low, b = middle + skip - low;
    uint slot_a = a < middle ? slot_at(base + a) : 0u, slot_b = b < right ? slot_at(base + b) : 0u;
    uvec2 key_a = a < middle ? strata_keys[slot_a] : uvec2(STRATA_NO_KEY);
    uvec2 key_b = b < right ? strata_keys[slot_b] : uvec2(STRATA_NO_KEY);
    for (uint i = begin; i < min(begin + DEEP_BLOCK, right); ++i) {
        if (b >= right || (a < middle && strata_before(key_a, key_b))) {
            put(base + i, slot_a);
            if (++a < middle) {
                slot_a = slot_at(base + a);
                key_a = strata_keys[slot_a];
            }
        } else {
            put(base + i, slot_b);
            if (++b < right) {
                slot_b = slot_at(base + b);
                key_b = strata_keys[slot_b];
            }
        }
    }
}
