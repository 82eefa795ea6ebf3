// SPDX-License-Identifier: MIT
//
// occupancy, pass 5: how many fragments there were, one invocation for eight pixels. Two words: a
// carry beyond 32 bits.
#include "strata/frame.glsl"
#include "strata/scan.glsl"

uniform sampler2D count_image;
layout(std430) buffer Total { uint total[2]; };

void main() {
    uint first = strata_item() * 8u, sum = 0u, group;
    for (uint i = first; i < min(first + 8u, strata_pixel_count()); ++i)
        sum += uint(texelFetch(count_image, ivec2(strata_position(i)), 0).r);
    strata_scan(sum, group);
    if (gl_LocalInvocationID.x == 0u && group > 0u) {
        uint before = atomicAdd(total[0], group);
        if (before + group < before)
            atomicAdd(total[1], 1u);
    }
}
