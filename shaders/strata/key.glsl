// SPDX-License-Identifier: MIT
//
// The one order of fragments: key, then order; exact integers, so that every technique sorts, counts
// and compares alike.
#ifndef STRATA_KEY_GLSL
#define STRATA_KEY_GLSL

const uint STRATA_FAR_KEY = 0x3f800000u; // of depth 0, the farthest; the nearest, of depth 1, is 0
const uint STRATA_NO_KEY = 0xffffffffu;  // beyond every key

// Ascends from near to far; exact, since depth bits of non-negative floats order as integers.
uint strata_key(float depth) {
    uint bits = floatBitsToUint(clamp(depth, 0.0, 1.0)) & 0x7fffffffu; // -0 becomes +0
    return STRATA_FAR_KEY - bits;
}

// The depth of a key, exactly.
float strata_key_depth(uint key) { return uintBitsToFloat(STRATA_FAR_KEY - key); }

// At equal depth the later primitive lies in front.
uint strata_order(uint primitive) { return 0xffffffffu - primitive; }

bool strata_before(uvec2 a, uvec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

#endif
