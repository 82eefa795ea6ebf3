// SPDX-License-Identifier: MIT
//
// The lights that shine on the scene, by index.
#ifndef STRATA_LIGHTS_GLSL
#define STRATA_LIGHTS_GLSL

#include "strata/frame.glsl"

struct StrataLight {
    vec4 position;  // world; kind (0 directional, 1 point, 2 spot)
    vec4 direction; // where it shines to, unit; range, 0 = unlimited
    vec4 color;     // rgb times intensity
    vec4 cone;      // cosines: inner, outer
};
// A constant count: the loop over few lights unrolls.
layout(std140) uniform StrataLights { StrataLight strata_lights[STRATA_LIGHT_COUNT]; };

// Few directional lights come flat, too (STRATA_FLAT in frame.glsl).
#if defined(STRATA_FLAT) && !defined(STRATA_HAS_LOCAL_LIGHTS) && STRATA_LIGHT_COUNT <= 4
#define STRATA_FLAT_LIGHTS
layout(location = 15) flat STRATA_VARYING vec3 strata_flat_directions[STRATA_LIGHT_COUNT];
layout(location = 19) flat STRATA_VARYING vec3 strata_flat_colors[STRATA_LIGHT_COUNT];
#endif

#if defined(STRATA_FLAT_LIGHTS) && defined(STRATA_STAGE_FRAGMENT)
StrataLight strata_light_at(int i) {
    return StrataLight(vec4(0.0), vec4(strata_flat_directions[i], 0.0),
                       vec4(strata_flat_colors[i], 0.0), vec4(0.0));
}
#else
StrataLight strata_light_at(int i) { return strata_lights[i]; }
#endif

#endif
