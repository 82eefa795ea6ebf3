// SPDX-License-Identifier: MIT
//
// Ends a pixel's walk at what color/1 holds.
#ifndef STRATA_OUTPUT_GLSL
#define STRATA_OUTPUT_GLSL

#include "strata/fold.glsl"
#include "strata/frame.glsl"

layout(rgba32f) uniform image2D color;

void strata_output(uint pixel, StrataElement walk) {
    ivec2 at = ivec2(strata_position(pixel));
    imageStore(color, at, strata_fold_end(walk, imageLoad(color, at)));
}

#endif
