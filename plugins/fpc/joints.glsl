// SPDX-License-Identifier: MIT
//
// fpc: nodes of the tree of folds, stored as (C, T).
#include "strata/ended.glsl"
#include "strata/output.glsl"

layout(std430) buffer Joint0 { vec2 joint0[]; };
layout(std430) buffer Joint1 { vec2 joint1[]; };
layout(std430) buffer Joint2 { vec2 joint2[]; };
#if STRATA_CHANNELS == 3
layout(std430) buffer Joint3 { vec2 joint3[]; };
#endif

StrataElement joint_at(uint joint) {
    vec4 color = vec4(joint0[joint], joint1[joint]);
#if STRATA_CHANNELS == 3
    return StrataElement(color, vec3(joint2[joint], joint3[joint].x));
#else
    return StrataElement(color, joint2[joint].x);
#endif
}

void put_joint(uint joint, StrataElement walk) {
    joint0[joint] = walk.color.xy;
    joint1[joint] = walk.color.zw;
#if STRATA_CHANNELS == 3
    joint2[joint] = walk.transmittance.xy;
    joint3[joint] = vec2(walk.transmittance.z, 0.0);
#else
    joint2[joint] = vec2(walk.transmittance, 0.0);
#endif
}
