// SPDX-License-Identifier: MIT
//
// ppc: ends a pixel's walk at what color/1 holds.
layout(rgba32f) uniform image2D color;

void output_fold(uint pixel, StrataElement walk) {
    ivec2 at = ivec2(strata_position(pixel));
    imageStore(color, at, strata_fold_end(walk, imageLoad(color, at)));
}
