// SPDX-License-Identifier: MIT
//
// Exact allocation: how many records a pixel of `count` fragments gets, at most params.most. With STRATA_NEAREST, at most
// its own number, too.
#include "strata/tiles.glsl"

STRATA_PARAMS { uint most; } params;
#ifdef STRATA_NEAREST
layout(std430) readonly buffer Nearest { uint nearest[]; }; // for each pixel of the frame
#endif

uint count_kept(uint pixel, uint count) {
    uint kept = min(count, params.most);
#ifdef STRATA_NEAREST
    uvec2 at = strata_position(pixel);
    kept = min(kept, nearest[at.y * strata_frame_size.x + at.x]);
#endif
    return kept;
}
