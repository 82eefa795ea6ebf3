// SPDX-License-Identifier: MIT
//
// ppc, deep pixels, last: folds the sorted slots params.first .. params.first + WALK_CHUNK - 1 of each
// pixel, in order, so that the bits are those of one long fold; the state waits in
// WalkState.
#define STRATA_PAYLOAD_READ
#include "strata/fragments.glsl"
#include "strata/fold.glsl"
#include "strata/scan.glsl"
#include "deep.glsl"
#include "strata/output.glsl"

layout(std430) readonly buffer Slots0 { uint slots0[]; };
layout(std430) readonly buffer Slots1 { uint slots1[]; };
layout(std430) buffer WalkState { vec2 walk_state[]; };
STRATA_PARAMS { uint side; uint first; } params;

StrataElement load_state(uint deep) {
    vec4 parts[STRATA_ELEMENT_PARTS];
    for (uint i = 0u; i < STRATA_ELEMENT_PARTS; ++i) {
        uint at = deep * WALK_STATE + 2u * i;
        parts[i] = vec4(walk_state[at], walk_state[at + 1u]);
    }
    return strata_element_join(parts);
}

void store_state(uint deep, StrataElement walk) {
    vec4 parts[STRATA_ELEMENT_PARTS];
    strata_element_split(walk, parts);
    for (uint i = 0u; i < STRATA_ELEMENT_PARTS; ++i) {
        uint at = deep * WALK_STATE + 2u * i;
        walk_state[at] = parts[i].xy;
        walk_state[at + 1u] = parts[i].zw;
    }
}

void main() {
    uint deep = strata_item();
    if (deep_fits == 0u || deep >= classes[CLASS_DEEP].count)
        return;
    uint pixel = lists[classes[CLASS_DEEP].offset + deep];
    uint count = strata_range_at(pixel).y;
    if (params.first >= count)
        return;
    StrataElement walk = strata_fold_begin();
    if (params.first > 0u)
        walk = load_state(deep);
    uint base = deep_base[deep] * DEEP_BLOCK;
    uint last = min(params.first + WALK_CHUNK, count);
    for (uint i = params.first; i < last; ++i) {
        uint slot = params.side == 0u ? slots0[base + i] : slots1[base + i];
        strata_fold_step(walk, strata_event(strata_payload_load(slot)));
    }
    if (last < count)
        store_state(deep, walk);
    else
        strata_output(pixel, walk);
}
