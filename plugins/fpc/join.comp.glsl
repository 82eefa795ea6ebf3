// SPDX-License-Identifier: MIT
//
// fpc, segmented fold, further levels, one invocation a joint: those that begin a node of
// params.stride * CHUNK joints fold its CHUNK children, params.stride joints apart, in order.
#include "strata/fragments.glsl"
#include "strata/fold.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "ranked.glsl"
#include "joints.glsl"

FPC_TABLE(readonly)
layout(std430) readonly buffer JointRank { uint joint_rank[]; };
STRATA_PARAMS { uint stride; float threshold; } params;

void main() {
    uint joint = strata_item();
    if (joint >= joints)
        return;
    uint rank = joint_rank[joint], at = joint - ranked_chunks[rank].y;
    uint pixel = ranked_elements[rank].x, parts = chunks_of(strata_ranges[pixel].y);
    if (parts <= params.stride || at % (params.stride * CHUNK) != 0u)
        return; // its fold has ended, or another invocation has this node
    StrataElement walk = joint_at(joint);
    for (uint i = 1u; i < CHUNK && at + i * params.stride < parts; ++i) {
        if (strata_ended(walk, params.threshold))
            break;
        strata_fold_step(walk, joint_at(joint + i * params.stride));
    }
    if (parts <= params.stride * CHUNK)
        strata_output(pixel, walk);
    else
        put_joint(joint, walk);
}
