// SPDX-License-Identifier: MIT
//
// cullcheck, show=pyramid: the farthest depth of each block of pixels, one invocation a pixel, and
// the range of all depths that are not empty. Depths are positive: they order as their bits.
#include "strata/frame.glsl"
#include "strata/scan.glsl"

uniform sampler2D depth_image;
layout(std430) buffer Blocks { uint lowest, highest, blocks[]; };
STRATA_PARAMS { uint level, width; } params; // blocks in a row

void main() {
    uint item = strata_item();
    if (item >= strata_frame_size.x * strata_frame_size.y)
        return;
    uvec2 p = uvec2(item % strata_frame_size.x, item / strata_frame_size.x);
    uint depth = floatBitsToUint(max(texelFetch(depth_image, ivec2(p), 0).r, 0.0));
    atomicMin(blocks[(p.y >> params.level) * params.width + (p.x >> params.level)], depth);
    if (depth > 0u) {
        atomicMin(lowest, depth);
        atomicMax(highest, depth);
    }
}
