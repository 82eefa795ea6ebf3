// SPDX-License-Identifier: MIT
//
// occupancy, where a certificate is asked for: what the limit hides of what the opaque surface shows is
// shaded and accounted for, as a capture does with what it drops by itself.
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/loss.glsl"

layout(early_fragment_tests) in;
uniform sampler2D limit_image;

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    uvec2 position = uvec2(gl_FragCoord.xy);
    if (gl_FragCoord.z < texelFetch(limit_image, ivec2(position), 0).r)
        strata_lose(strata_pixel(position), strata_emit(surface));
}
