// SPDX-License-Identifier: MIT
//
// peel: what a pixel remembers between the passes of a step. With PEEL_SIDES 2 (dual) each pixel has two
// slots, one for the front and one for the back; else one.
//
// A step takes from each slot's side the next fragment in the total order (key, order). Where several
// share the next depth, the step only learns which of them is first, and the next step takes that one.
#include "strata/frame.glsl"
#include "strata/key.glsl"

#ifndef PEEL_LAST
#define PEEL_LAST readonly
#endif

const uint PEEL_FRONT = 0u, PEEL_BACK = 1u;

struct PeelFound {
    uint rank;   // of the first among the fragments found in this step; 0: none was found
    uint key;    // theirs
    uint tied;   // 1: there are several
    uint wanted; // rank of the one that this step takes of several; 0: not known
};

layout(std430) PEEL_LAST buffer PeelLast { uvec2 peel_last[]; }; // (key, order) taken last, a slot
layout(std430) buffer PeelFounds { PeelFound peel_found[]; };    // a slot

uint peel_slot(uint pixel, uint side) { return pixel * PEEL_SIDES + side; }

// Among fragments of one depth the greatest rank is first: from the front the highest primitive, from the
// back the lowest. Never 0, since a scene has fewer than 2^32 primitives.
uint peel_rank(uint primitive, uint side) {
    return side == PEEL_FRONT ? primitive + 1u : ~primitive;
}

uint peel_primitive(uint rank, uint side) { return side == PEEL_FRONT ? rank - 1u : ~rank; }

// Whether a fragment has not been taken yet.
bool peel_left(uint pixel, uvec2 at) {
    bool left = strata_before(peel_last[peel_slot(pixel, PEEL_FRONT)], at);
#if PEEL_SIDES == 2
    left = left && strata_before(at, peel_last[peel_slot(pixel, PEEL_BACK)]);
#endif
    return left;
}
