// SPDX-License-Identifier: MIT
//
// kplus, ordered attachments: K records a pixel as pairs in RGBA32U texels, two a texel, in complement, so
// that a cleared texel holds records nearer than none and the farthest is the smallest pair. Where there
// is room, the pair after them counts what arrived; with K = 16, `dropped` counts instead.
#if K < 16
#define COUNTED
#define PAIRS (K + 1)
#else
#define PAIRS 16
#endif

#define STRATA_EACH_COUNT ((PAIRS + 1) / 2)
#include "strata/each.glsl"
