// SPDX-License-Identifier: MIT
//
// peel, pass 2 of a step: shades the fragments at the depth that pass 1 found and stores what they are, in
// the payload's own form. Front to back, the depth test EQUAL rejects all others before they are shaded.
// Of several at that depth the first by rank is noted; what they store counts only when one was wanted.
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/effects.glsl"
#include "state.glsl"

layout(early_fragment_tests) in;

#if PEEL_SIDES == 2
uniform sampler2D nearest_image;
uniform sampler2D farthest_image;

// The side on which the fragment's depth is next; false on neither. A depth that is both is the front's.
bool peel_side(out uint side) {
    ivec2 at = ivec2(gl_FragCoord.xy);
    side = gl_FragCoord.z == texelFetch(nearest_image, at, 0).r ? PEEL_FRONT : PEEL_BACK;
    return side == PEEL_FRONT || gl_FragCoord.z == -texelFetch(farthest_image, at, 0).r;
}
#else
bool peel_side(out uint side) {
    side = PEEL_FRONT;
    return true;
}
#endif

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    uint side, pixel = strata_pixel(uvec2(gl_FragCoord.xy));
    uvec2 at = uvec2(strata_key(gl_FragCoord.z), strata_order(surface.primitive));
    if (!peel_side(side) || !peel_left(pixel, at))
        return;
    uint slot = peel_slot(pixel, side), rank = peel_rank(surface.primitive, side);
    uint wanted = peel_found[slot].wanted;
    if (wanted != 0u && wanted != rank)
        return;
    if (atomicMax(peel_found[slot].rank, rank) != 0u)
        peel_found[slot].tied = 1u;
    peel_found[slot].key = at.x;
    strata_payload_store(slot, strata_emit(surface));
}
