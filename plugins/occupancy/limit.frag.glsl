// SPDX-License-Identifier: MIT
//
// occupancy, pass 4, full screen: the far edge of the bucket with the k-th set bit, where it is nearer
// than the opaque surface. k set bits are at least k fragments, all up to that edge.
#include "strata/frame.glsl"
#include "buckets.glsl"

uniform sampler2D depth_image;
uniform usampler2DArray mask;

// The bucket of the k-th set bit; false when fewer are set.
bool find_bucket(uvec2 position, out uint bucket) {
    ivec2 texel = ivec2(position - strata_frame_band().xy);
    uint left = OCCUPANCY_NEAREST;
    for (uint i = 0u; i < OCCUPANCY_WORDS; ++i) {
        uint word = texelFetch(mask, ivec3(texel, i), 0).x, count = uint(bitCount(word));
        if (count >= left) {
            for (; left > 1u; --left)
                word &= word - 1u; // Kernighan: drops the lowest set bit
            bucket = i * 32u + uint(findLSB(word));
            return true;
        }
        left -= count;
    }
    bucket = 0u;
    return false;
}

void main() {
    uvec2 position = uvec2(gl_FragCoord.xy);
    float depth = texelFetch(depth_image, ivec2(position), 0).r;
    uint bucket;
    if (find_bucket(position, bucket))
        depth = max(depth, strata_key_depth(far_edge(division_at(position), bucket)));
    gl_FragDepth = depth;
}
