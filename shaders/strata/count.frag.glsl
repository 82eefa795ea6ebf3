// SPDX-License-Identifier: MIT
//
// Exact allocation, pass 1: how many fragments each pixel has. Additive blending is the cheapest
// counter; a float counts exactly up to 2^24.
#include "strata/shading.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out float count;

void main() {
    if (!strata_covered())
        discard;
    count = 1.0;
}
