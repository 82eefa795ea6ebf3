// SPDX-License-Identifier: MIT
//
// peel with a limit of layers, after the last step: every fragment that is left is dropped, and counted.
#define PEEL_WALKS readonly
#define PEEL_COUNTS
#include "strata/shading.glsl"
#include "state.glsl"
#include "walks.glsl"

layout(early_fragment_tests) in;

void main() {
    uvec2 at = uvec2(strata_key(gl_FragCoord.z), strata_order(strata_primitive()));
    uint pixel = strata_pixel(uvec2(gl_FragCoord.xy));
    if (strata_covered() && peel_left(pixel, at))
        atomicAdd(peel_count[pixel].y, 1u);
}
