// SPDX-License-Identifier: MIT
//
// Capture of every fragment, last geometry pass: shades it and stores its record, in its pixel's range
// (contiguous) or at the head of its pixel's list (linked). No opaque colour output: a later triangle's
// may make a driver drop a tile's storage writes. STRATA_CURSORS: the next slot of each pixel's range is
// in attachment 0, which costs no atomic operation.
#define STRATA_RANGES coherent
#define STRATA_RECORDS writeonly
#define STRATA_KEYS STRATA_PAIR
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/fragments.glsl"
#include "strata/effects.glsl"

layout(early_fragment_tests) in;
#ifdef STRATA_CURSORS
#include "strata/cursor.glsl"
#include "strata/ordered.glsl"
STRATA_ORDERED_FLOAT(0)
#endif
layout(std430) buffer StrataFragmentPool { uint strata_needed; uint strata_capacity; };

uint take_slot(uint pixel) {
#if defined(STRATA_CURSORS)
    uint slot = strata_cursor_slot(STRATA_ORDERED_LOAD(0).r);
    STRATA_ORDERED_STORE(0, vec4(strata_cursor(slot + 1u)));
    return slot;
#elif STRATA_LAYOUT == 1
    uint slot = atomicAdd(strata_needed, 1u);
    if (slot >= 0x80000000u) // beyond every capacity: the count stays there and never wraps
        atomicAdd(strata_needed, 0xffffffffu);
    atomicAdd(strata_ranges[pixel].y, 1u);
    if (slot < strata_capacity)
        strata_links[slot] = uvec2(atomicExchange(strata_ranges[pixel].x, slot), pixel);
    return slot;
#else
    return atomicAdd(strata_ranges[pixel].x, 0xffffffffu) - 1u;
#endif
}

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    uint slot = take_slot(strata_pixel(uvec2(gl_FragCoord.xy)));
    if (slot >= strata_capacity)
        return;
    strata_keys[slot] =
        STRATA_TO_PAIR(uvec2(strata_key(gl_FragCoord.z), strata_order(surface.primitive)));
    StrataPayload payload = strata_emit(surface);
    strata_payload_store(slot, payload);
}
