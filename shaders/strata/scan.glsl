// SPDX-License-Identifier: MIT
//
// Work groups of STRATA_GROUP invocations: which item an invocation has, and prefix sums within a
// group, saturating at 2^32 - 1 so that a total beyond 32 bits asks for bands instead of wrapping.
#ifndef STRATA_SCAN_GLSL
#define STRATA_SCAN_GLSL

#define STRATA_GROUP 64
layout(local_size_x = STRATA_GROUP) in;

// Dispatches of many items have rows of STRATA_GROUP_ROW groups (strata_groups in strata/gpu.h).
#define STRATA_GROUP_ROW 32768u

uint strata_item() {
    return (gl_WorkGroupID.y * STRATA_GROUP_ROW + gl_WorkGroupID.x) * STRATA_GROUP +
           gl_LocalInvocationID.x;
}

// The same on the GPU, for indirect dispatches.
uvec3 strata_groups(uint items) {
    uint count = items / STRATA_GROUP + uint(items % STRATA_GROUP != 0u);
    return uvec3(min(count, STRATA_GROUP_ROW), (count + STRATA_GROUP_ROW - 1u) / STRATA_GROUP_ROW,
                 1u);
}

shared uint strata_scan_shared[STRATA_GROUP];

uint strata_add(uint a, uint b) {
    uint sum = a + b;
    return sum < a ? 0xffffffffu : sum;
}

// Sum over the invocations before this one, and over all. Called in uniform control flow.
uint strata_scan(uint value, out uint total) {
    uint lane = gl_LocalInvocationID.x;
    strata_scan_shared[lane] = value;
    barrier();
    for (uint step = 1u; step < STRATA_GROUP; step *= 2u) {
        uint before = lane >= step ? strata_scan_shared[lane - step] : 0u;
        barrier();
        strata_scan_shared[lane] = strata_add(strata_scan_shared[lane], before);
        barrier();
    }
    total = strata_scan_shared[STRATA_GROUP - 1];
    uint exclusive = lane > 0u ? strata_scan_shared[lane - 1u] : 0u;
    barrier();
    return exclusive;
}

#endif
