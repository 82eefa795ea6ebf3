// SPDX-License-Identifier: MIT
//
// peel: the walks of a pixel, from the eye and (dual) from the far end, and how many fragments they hold.
#include "strata/fold.glsl"

#ifndef PEEL_COUNTS
#define PEEL_COUNTS readonly
#endif

layout(std430) PEEL_WALKS buffer PeelWalks { StrataElement peel_walk[]; };     // a slot
layout(std430) PEEL_COUNTS buffer PeelCounts { uvec2 peel_count[]; };          // taken, dropped; a pixel
