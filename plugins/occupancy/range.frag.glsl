// SPDX-License-Identifier: MIT
//
// occupancy, pass 1: nearest and farthest depth, one sample a tile, by blending that keeps the larger.
// What it misses only makes buckets uneven (buckets.glsl), so it asks neither whether a fragment exists
// nor what hides it.
#include "strata/frame.glsl"

layout(location = 0) out vec4 range;

void main() { range = vec4(gl_FragCoord.z, -gl_FragCoord.z, 0.0, 0.0); }
