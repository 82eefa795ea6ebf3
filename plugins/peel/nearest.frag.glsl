// SPDX-License-Identifier: MIT
//
// peel, front to back, pass 1 of a step: the nearest depth among the fragments that are left, by the depth
// test GREATER over what fold.frag.glsl wrote.
#include "strata/shading.glsl"
#include "state.glsl"

void main() {
    uvec2 at = uvec2(strata_key(gl_FragCoord.z), strata_order(strata_primitive()));
    if (!strata_covered() || !peel_left(strata_pixel(uvec2(gl_FragCoord.xy)), at))
        discard;
}
