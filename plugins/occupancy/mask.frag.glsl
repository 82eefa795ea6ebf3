// SPDX-License-Identifier: MIT
//
// occupancy, pass 3: each fragment in front of the opaque surface sets its bucket's bit and is counted.
// Blending is on: no opaque output may hide storage writes. ORDERED: the device orders a pixel's plain
// accesses, so that none need be atomic.
#include "strata/shading.glsl"
#include "buckets.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out float count;
layout(r32ui) uniform uimage2DArray mask; // a layer a word

void main() {
    if (!strata_covered())
        discard;
    uvec2 position = uvec2(gl_FragCoord.xy);
    uint bucket = bucket_of(division_at(position), strata_key(gl_FragCoord.z));
    ivec3 word = ivec3(position - strata_frame_band().xy, bucket >> 5);
    uint bit = 1u << (bucket & 31u);
#ifdef ORDERED
    imageStore(mask, word, uvec4(imageLoad(mask, word).x | bit));
#else
    imageAtomicOr(mask, word, bit);
#endif
    count = 1.0;
}
