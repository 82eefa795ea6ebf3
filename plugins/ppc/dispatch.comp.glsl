// SPDX-License-Identifier: MIT
//
// ppc, pass 2, one invocation: where each class's list begins, and the indirect dispatches.
#include "strata/frame.glsl"
#include "strata/scan.glsl"
#include "classes.glsl"

CLASS_TABLE(restrict)
#include "strata/class_offsets.glsl"
#include "strata/pool.glsl"
layout(std430) buffer DeepPool { uint deep_needed; uint deep_capacity; };
layout(std430) buffer BlockPool { uint block_needed; uint block_capacity; };
layout(std430) buffer SlotPool { uint slot_needed; uint slot_capacity; };
layout(std430) buffer WalkPool { uint walk_needed; uint walk_capacity; };
#if STRATA_LAYOUT == 1
layout(std430) buffer IndexPool { uint index_needed; uint index_capacity; };
#endif

void main() {
    if (gl_LocalInvocationID.x != 0u)
        return;
    strata_class_offsets();
    block_groups = uvec4(strata_groups(blocks), 0u);
    deep_needed = classes[CLASS_DEEP].count;
    block_needed = blocks;
    slot_needed = blocks > 0xffffffffu / DEEP_BLOCK ? 0xffffffffu : blocks * DEEP_BLOCK;
    walk_needed = largest > WALK_CHUNK ? WALK_STATE * classes[CLASS_DEEP].count : 0u;
    bool fits = !strata_pool_short() && deep_needed <= deep_capacity &&
                block_needed <= block_capacity && slot_needed <= slot_capacity &&
                walk_needed <= walk_capacity;
#if STRATA_LAYOUT == 1
    index_needed = blocks > 0u ? strata_pixel_count() : 0u;
    fits = fits && index_needed <= index_capacity;
#endif
    deep_fits = uint(fits);
}
