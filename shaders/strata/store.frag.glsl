// SPDX-License-Identifier: MIT
//
// Capture of every fragment, last geometry pass: shades it and stores its record, in its pixel's range
// (contiguous) or at the head of its pixel's list (linked). No opaque colour output: a later triangle's
// may make a driver drop a tile's storage writes. STRATA_CURSORS, contiguous: the next slot of each pixel's
// range is in attachment 0, which costs no atomic operation. STRATA_SUBGROUPS, linked: a subgroup adds to
// the common counter once.
#if defined(STRATA_SUBGROUPS) && defined(VULKAN)
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_EXT_demote_to_helper_invocation : require
#define SUBGROUPS
#endif
#define STRATA_RANGES coherent
#define STRATA_RECORDS writeonly
#define STRATA_KEYS STRATA_PAIR
#define STRATA_LINKS STRATA_PAIR
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
#if STRATA_LAYOUT == 1
layout(std430) buffer StrataFragmentPool { uint strata_needed; uint strata_capacity; };
uint strata_pool_capacity() { return strata_capacity; }

// The first of `count` slots. Beyond every capacity the counter stays there and never wraps.
uint take_slots(uint count) {
    uint slot = atomicAdd(strata_needed, count);
    if (slot >= 0x80000000u)
        atomicAdd(strata_needed, 0u - count);
    return slot;
}

uint next_slot() {
#ifdef SUBGROUPS
    uint slot = 0xffffffffu;
    if (!helperInvocationEXT()) { // helpers may take part in what subgroups do, but store nothing
        uvec4 those = subgroupBallot(true);
        uint first = 0u;
        if (subgroupElect())
            first = take_slots(subgroupBallotBitCount(those));
        slot = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(those);
    }
    return slot;
#else
    return take_slots(1u);
#endif
}

uint take_slot(uint pixel) {
    uint slot = next_slot();
    atomicAdd(strata_ranges[pixel].y, 1u);
    if (slot < strata_pool_capacity())
        strata_links[slot] =
            STRATA_TO_PAIR(uvec2(atomicExchange(strata_ranges[pixel].x, slot), pixel));
    return slot;
}
#else
#include "strata/pool.glsl"

uint take_slot(uint pixel) {
#ifdef STRATA_CURSORS
    uint slot = strata_cursor_slot(STRATA_ORDERED_LOAD(0).r);
    STRATA_ORDERED_STORE(0, vec4(strata_cursor(slot + 1u)));
    return slot;
#else
    return atomicAdd(strata_ranges[pixel].x, 0xffffffffu) - 1u;
#endif
}
#endif

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    uint slot = take_slot(strata_pixel(uvec2(gl_FragCoord.xy)));
    if (slot >= strata_pool_capacity())
        return;
    strata_keys[slot] =
        STRATA_TO_PAIR(uvec2(strata_key(gl_FragCoord.z), strata_order(surface.primitive)));
    StrataPayload payload = strata_emit(surface);
    strata_payload_store(slot, payload);
}
