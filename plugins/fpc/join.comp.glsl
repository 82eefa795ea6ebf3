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
STRATA_PARAMS { uint stride; float threshold; } params;

void main() {
    uint joint = strata_item();
    if (joint >= joints)
        return;
    uint rank = joint_rank(joint), at = joint - ranked_chunks[rank].y;
    uint pixel = ranked_elements[rank].x, parts = chunks_of(strata_range_at(pixel).y);
    if (parts <= params.stride || at % (params.stride * CHUNK) != 0u)
        return; // its fold has ended, or another invocation has this node
    StrataElement walk = joint_at(joint);
    uint i = 1u;
    for (; i < CHUNK && at + i * params.stride < parts && !strata_ended(walk, params.threshold); ++i)
        strata_fold_step(walk, joint_at(joint + i * params.stride));
#ifdef STRATA_BOUND
    for (; i < CHUNK && at + i * params.stride < parts; ++i)
        strata_lose_element(pixel, joint_at(joint + i * params.stride));
#endif
    if (parts <= params.stride * CHUNK)
        strata_output(pixel, walk);
    else
        put_joint(joint, rank, walk);
}
