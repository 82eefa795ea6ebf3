// SPDX-License-Identifier: MIT
//
// peel, dual, pass 1 of a step: the nearest and the farthest depth among the fragments that are left, by
// MAX blending (Bavoil and Myers 2008).
#include "strata/shading.glsl"
#include "state.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out float nearest;
layout(location = 1) out float farthest; // negative

void main() {
    uvec2 at = uvec2(strata_key(gl_FragCoord.z), strata_order(strata_primitive()));
    if (!strata_covered() || !peel_left(strata_pixel(uvec2(gl_FragCoord.xy)), at))
        discard;
    nearest = gl_FragCoord.z;
    farthest = -gl_FragCoord.z;
}
