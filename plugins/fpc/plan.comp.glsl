// SPDX-License-Identifier: MIT
//
// fpc, pass 2, one work group: sums become offsets; totals become what the pools need and the indirect
// dispatches, which are empty when a pool is too small: the frame is recorded again then.
#include "strata/fragments.glsl"
#include "strata/pool.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "pixels.glsl"

FPC_TABLE(restrict)
layout(std430) buffer Sums { uvec4 sums[]; };
layout(std430) buffer RankedPool { uint ranked_needed; uint ranked_capacity; };
layout(std430) buffer ElementPool { uint element_needed; uint element_capacity; };
layout(std430) buffer CounterPool { uint counter_needed; uint counter_capacity; };
layout(std430) buffer BlockPool { uint block_needed; uint block_capacity; };
layout(std430) buffer JointPool { uint joint_needed; uint joint_capacity; };
#if STRATA_LAYOUT == 1
layout(std430) buffer RankPool { uint rank_needed; uint rank_capacity; };
#endif

#ifdef HYBRID
#include "strata/classes.glsl"

CLASS_TABLE(restrict)
#include "strata/class_offsets.glsl"
#endif

uvec4 groups_for(uint items) { return uvec4(strata_groups(items), 0u); }

uint parts_of(uint count, uint part) { return count / part + uint(count % part != 0u); }

void set_table(uvec4 total) {
    pixels = ranked_needed = total.x;
    elements = element_needed = total.y;
    chunks = total.z;
    joints = total.w;
    joint_needed = joints > 0xffffffffu / JOINT_PAIRS ? 0xffffffffu : joints * JOINT_PAIRS;
    // As many streams as keep the device busy; 8 times an odd number, for at a power of two streams side
    // by side would share cache sets.
    stream = clamp(elements / 512u, 248u, STREAM_LONGEST) & ~15u | 8u;
    streams = parts_of(elements, stream);
    counter_needed = streams > 0xffffffffu / DIGITS ? 0xffffffffu : streams * DIGITS;
    block_needed = parts_of(counter_needed, COUNTERS_PER_INVOCATION * STRATA_GROUP);
    bool fit = !strata_pool_short() && ranked_needed <= ranked_capacity &&
               element_needed <= element_capacity && counter_needed <= counter_capacity &&
               block_needed <= block_capacity && joint_needed <= joint_capacity;
#if STRATA_LAYOUT == 1
    rank_needed = pixels > 0u ? strata_pixel_count() : 0u;
    fit = fit && rank_needed <= rank_capacity;
#endif
    fits = uint(fit);
    if (!fit)
        return;
#if STRATA_LAYOUT == 1
    element_groups = groups_for(elements > 0u ? parts_of(strata_pool_needed(), ELEMENTS_PER_INVOCATION) : 0u);
#else
    element_groups = groups_for(parts_of(elements, ELEMENTS_PER_INVOCATION));
#endif
    stream_groups = groups_for(streams);
    counter_groups = groups_for(parts_of(counter_needed, COUNTERS_PER_INVOCATION));
    chunk_groups = groups_for(chunks);
    joint_groups = groups_for(joints);
}

void main() {
    uint lane = gl_LocalInvocationID.x;
    uint share = (group_count() + STRATA_GROUP - 1u) / STRATA_GROUP;
    uint begin = min(lane * share, group_count()), end = min(begin + share, group_count());
    uvec4 sum = uvec4(0u), total;
    for (uint i = begin; i < end; ++i)
        sum = add(sum, sums[i]);
    uvec4 offset = scan(sum, total);
    for (uint i = begin; i < end; ++i) {
        uvec4 group = sums[i];
        sums[i] = offset;
        offset = add(offset, group);
    }
    if (lane == 0u)
        set_table(total);
#ifdef HYBRID
    if (lane == 0u)
        strata_class_offsets();
#endif
}
