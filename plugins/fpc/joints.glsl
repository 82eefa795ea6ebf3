// SPDX-License-Identifier: MIT
//
// fpc: nodes of the tree of folds. A node is JOINT_PAIRS (table.glsl) pairs of words: its pixel's rank and T,
// C, and with a certificate their errors.
#include "strata/ended.glsl"
#include "strata/loss.glsl"
#include "strata/output.glsl"

layout(std430) buffer Joints { uvec2 joint_pairs[]; };

vec2 joint_pair(uint at) { return uintBitsToFloat(joint_pairs[at]); }
vec4 joint_four(uint at) { return vec4(joint_pair(at), joint_pair(at + 1u)); }

void put_four(uint at, vec4 value) {
    joint_pairs[at] = floatBitsToUint(value.xy);
    joint_pairs[at + 1u] = floatBitsToUint(value.zw);
}

uint joint_rank(uint joint) { return joint_pairs[joint * JOINT_PAIRS].x; }

StrataElement joint_at(uint joint) {
    uint at = joint * JOINT_PAIRS;
#if STRATA_CHANNELS == 3
    vec3 transmittance = vec3(joint_pair(at).y, joint_pair(at + 3u));
#else
    float transmittance = joint_pair(at).y;
#endif
#ifndef STRATA_BOUND
    return StrataElement(joint_four(at + 1u), transmittance);
#elif STRATA_CHANNELS == 3
    return StrataElement(joint_four(at + 1u), transmittance, joint_four(at + 4u),
                         joint_four(at + 6u).xyz);
#else
    return StrataElement(joint_four(at + 1u), transmittance, joint_four(at + 3u),
                         joint_pair(at + 5u).x);
#endif
}

void put_joint(uint joint, uint rank, StrataElement walk) {
    uint at = joint * JOINT_PAIRS;
    put_four(at + 1u, walk.color);
#if STRATA_CHANNELS == 3
    joint_pairs[at] = uvec2(rank, floatBitsToUint(walk.transmittance.x));
    joint_pairs[at + 3u] = floatBitsToUint(walk.transmittance.yz);
#ifdef STRATA_BOUND
    put_four(at + 4u, walk.color_error);
    put_four(at + 6u, vec4(walk.transmittance_error, 0.0));
#endif
#else
    joint_pairs[at] = uvec2(rank, floatBitsToUint(walk.transmittance));
#ifdef STRATA_BOUND
    put_four(at + 3u, walk.color_error);
    joint_pairs[at + 5u] = uvec2(floatBitsToUint(walk.transmittance_error), 0u);
#endif
#endif
}
