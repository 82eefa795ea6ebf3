// SPDX-License-Identifier: MIT
//
// occupancy, pass 5: how many fragments there were, one invocation for four pixels of the band.
#include "strata/frame.glsl"
#include "strata/scan.glsl"
#include "strata/totals.glsl"

uniform sampler2D count_image;

void main() {
    uint first = strata_item() * 4u, sum = 0u, group;
    for (uint i = first; i < min(first + 4u, strata_pixel_count()); ++i)
        sum += uint(texelFetch(count_image, ivec2(strata_position(i)), 0).r);
    strata_scan(sum, group);
    if (gl_LocalInvocationID.x == 0u)
        strata_totals_add(group, 0u);
}
