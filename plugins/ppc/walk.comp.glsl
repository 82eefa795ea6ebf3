// SPDX-License-Identifier: MIT
//
// ppc, deep pixels, last: folds the sorted slots params.first .. params.first + WALK_CHUNK - 1 of each
// pixel, in order, so that the bits are those of one long fold; the state waits in WalkState.
#define STRATA_PAYLOAD_READ
#include "strata/fragments.glsl"
#include "strata/fold.glsl"
#include "strata/scan.glsl"
#include "deep.glsl"
#include "strata/output.glsl"

layout(std430) readonly buffer Slots0 { uint slots0[]; };
layout(std430) readonly buffer Slots1 { uint slots1[]; };
layout(std430) buffer WalkState0 { vec2 walk_state0[]; };
layout(std430) buffer WalkState1 { vec2 walk_state1[]; };
layout(std430) buffer WalkState2 { vec2 walk_state2[]; };
layout(std430) buffer WalkState3 { vec2 walk_state3[]; };
STRATA_PARAMS { uint side; uint first; } params;

StrataElement load_state(uint deep) {
    vec4 t = vec4(walk_state2[deep], walk_state3[deep]);
#if STRATA_CHANNELS == 3
    return StrataElement(vec4(walk_state0[deep], walk_state1[deep]), t.rgb);
#else
    return StrataElement(vec4(walk_state0[deep], walk_state1[deep]), t.r);
#endif
}

void store_state(uint deep, StrataElement walk) {
    vec4 t = strata_transmittance4(walk);
    walk_state0[deep] = walk.color.xy;
    walk_state1[deep] = walk.color.zw;
    walk_state2[deep] = t.xy;
    walk_state3[deep] = t.zw;
}

void main() {
    uint deep = strata_item();
    if (deep_fits == 0u || deep >= classes[CLASS_DEEP].count)
        return;
    uint pixel = lists[classes[CLASS_DEEP].offset + deep];
    uint count = strata_ranges[pixel].y;
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
