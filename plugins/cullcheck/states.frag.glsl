// SPDX-License-Identifier: MIT
//
// cullcheck, show=states: objects in the colour of their state; those that are drawn at their depth,
// those that are culled (CULLCHECK_CULLED) translucent over everything.
#include "object.glsl"

layout(location = 0) out vec4 color;

const vec3 COLORS[7] = vec3[7](vec3(0.30, 0.30, 0.30),  // untested: grey
                               vec3(0.04, 0.50, 0.10),  // kept: green
                               vec3(0.90, 0.65, 0.02),  // appeared: yellow
                               vec3(0.05, 0.20, 0.90),  // too near: blue
                               vec3(0.80, 0.05, 0.80),  // outside: magenta
                               vec3(0.02, 0.70, 0.80),  // slipped: cyan
                               vec3(0.85, 0.04, 0.03)); // occluded: red

void main() {
    vec3 across = cross(dFdx(strata_in_position), dFdy(strata_in_position));
    vec3 eye = strata_eye.xyz - strata_eye.w * strata_in_position;
    float facing = abs(dot(across, eye)) * inversesqrt(max(dot(across, across) * dot(eye, eye), 1e-37));
    if (!strata_covered())
        discard;
    uint state = min(strata_object_states[fragment_object()], STRATA_OCCLUDED);
    bool culled = state >= STRATA_OUTSIDE;
#ifdef CULLCHECK_CULLED
    float alpha = 0.3;
    if (!culled)
        discard;
#else
    float alpha = 1.0;
    if (culled)
        discard;
#endif
    color = vec4(COLORS[state] * (0.4 + 0.6 * facing), 1.0) * alpha;
}
