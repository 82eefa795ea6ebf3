// SPDX-License-Identifier: MIT
//
// The floor: each transparent fragment blended once, in the order in which it comes.
#include "strata/shading.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out vec4 color;

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    color = vec4(surface.color * surface.alpha, surface.alpha);
}
