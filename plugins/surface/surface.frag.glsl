// SPDX-License-Identifier: MIT
//
// surface: opaque and masked geometry, shaded. With SURFACE_EXACT the depth test is EQUAL and of the
// fragments at that depth the winner alone is shown.
#include "strata/shading.glsl"

#ifdef SURFACE_EXACT
layout(r32ui) uniform readonly uimage2D winners;
#endif
layout(location = 0) out vec4 color;

void main() {
    StrataSurface surface;
    bool exists = strata_surface(surface);
#ifdef SURFACE_EXACT
    exists = exists && imageLoad(winners, ivec2(gl_FragCoord.xy)).r == surface.primitive + 1u;
#endif
    if (!exists)
        discard;
    color = vec4(surface.color, 1.0);
}
