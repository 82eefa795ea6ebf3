// SPDX-License-Identifier: MIT
//
// occupancy, pass 3: each fragment in front of the opaque surface sets its bucket's bit and is counted.
// Blending is on: no opaque output may hide storage writes.
#include "strata/shading.glsl"
#include "buckets.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out float count;
layout(std430) buffer Mask { uint mask[]; };

void main() {
    if (!strata_covered())
        discard;
    uvec2 position = uvec2(gl_FragCoord.xy);
    uint bucket = bucket_of(division_at(position), strata_key(gl_FragCoord.z));
    uint word = strata_pixel(position) * OCCUPANCY_WORDS + (bucket >> 5);
    uint bit = 1u << (bucket & 31u);
    atomicOr(mask[word], bit);
    count = 1.0;
}
