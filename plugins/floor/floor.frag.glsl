// SPDX-License-Identifier: MIT
//
// The floor: each transparent fragment blended once, in the order in which it comes. LIT: with the
// scene's shading; else with its base colour alone, so that slow shading flatters no ratio.
#include "strata/shading.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out vec4 color;

#ifdef LIT
bool floor_surface(out vec4 shown) {
    StrataSurface surface;
    bool exists = strata_surface(surface);
    shown = vec4(surface.color, surface.alpha);
    return exists;
}
#else
bool floor_surface(out vec4 shown) {
    vec4 base = strata_base_color(strata_uv());
    shown = vec4(strata_finite(base.rgb), 1.0);
#ifdef STRATA_HAS_BLEND
    if (strata_is(STRATA_RECORD_BLEND))
        shown.a = clamp(strata_finite(base.a), 0.0, 1.0);
#endif
    return strata_exists(base.a);
}
#endif

void main() {
    vec4 shown;
    if (!floor_surface(shown))
        discard;
    color = vec4(shown.rgb * shown.a, shown.a);
}
