// SPDX-License-Identifier: MIT
//
// hiz: the farthest depth (reversed: the smallest) of blocks of pixels. Level 0 is the depth image; a
// level's size is half of that before it, rounded up, so that texel p of level n covers exactly the
// pixels q with q >> n == p. Levels from 1 on lie one after another in a buffer.
#ifndef HIZ_PYRAMID_GLSL
#define HIZ_PYRAMID_GLSL

#include "strata/frame.glsl"

uniform sampler2D depth_image;
#ifdef HIZ_BUILD
layout(std430) buffer Pyramid { float pyramid[]; };
#else
layout(std430) readonly buffer Pyramid { float pyramid[]; };
#endif

ivec2 level_size(int level) {
    return ivec2((strata_frame_size.xy + ((1u << level) - 1u)) >> level);
}

// `offset`: where the level begins in the buffer; any for level 0. Beyond the edge: the edge's.
float depth_at(int level, uint offset, ivec2 p) {
    ivec2 size = level_size(level);
    p = min(p, size - 1);
    return level == 0 ? texelFetch(depth_image, p, 0).r : pyramid[offset + uint(p.y * size.x + p.x)];
}

#endif
