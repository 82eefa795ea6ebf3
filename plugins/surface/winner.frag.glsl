// SPDX-License-Identifier: MIT
//
// surface, ties=exact, pass 2, depth test EQUAL and no depth writes: of the fragments at the nearest
// depth the highest primitive number wins, in whatever order they arrive.
#include "strata/shading.glsl"

layout(early_fragment_tests) in;
layout(r32ui) uniform uimage2D winners;

void main() {
    if (!strata_covered())
        discard;
    imageAtomicMax(winners, ivec2(gl_FragCoord.xy), strata_primitive() + 1u);
}
