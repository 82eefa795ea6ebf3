// SPDX-License-Identifier: MIT
//
// peel with a limit of layers, after the last step: every fragment that is left is dropped, and
// accounted for.
#define PEEL_WALKS readonly
#define PEEL_COUNTS
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/loss.glsl"
#include "state.glsl"
#include "walks.glsl"

layout(early_fragment_tests) in;

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    uvec2 at = uvec2(strata_key(gl_FragCoord.z), strata_order(surface.primitive));
    uint pixel = strata_pixel(uvec2(gl_FragCoord.xy));
    if (!peel_left(pixel, at))
        return;
    atomicAdd(peel_count[pixel].y, 1u);
    strata_lose(pixel, strata_emit(surface));
}
