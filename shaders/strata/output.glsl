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
    vec4 behind = imageLoad(color, at);
    imageStore(color, at, strata_fold_end(walk, behind));
    strata_certify(pixel, walk, behind);
}

#endif
