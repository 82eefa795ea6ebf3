// SPDX-License-Identifier: MIT
//
// ppc, pass 2, one invocation: where each class's list begins, and the indirect dispatches.
#include "strata/frame.glsl"
#include "strata/scan.glsl"
#include "classes.glsl"

CLASS_TABLE(restrict)
layout(std430) writeonly buffer DeepPool { uint deep_needed; };
layout(std430) writeonly buffer BlockPool { uint block_needed; };
layout(std430) writeonly buffer SlotPool { uint slot_needed; };
layout(std430) writeonly buffer WalkPool { uint walk_needed; };
#if STRATA_LAYOUT == 1
layout(std430) writeonly buffer IndexPool { uint index_needed; };
#endif

void main() {
    if (gl_LocalInvocationID.x != 0u)
        return;
    uint offset = 0u;
    for (uint c = 0u; c < CLASS_COUNT; ++c) {
        classes[c].offset = offset;
        classes[c].groups = uvec4(strata_groups(classes[c].count), 0u);
        offset += classes[c].count;
    }
    block_groups = uvec4(strata_groups(blocks), 0u);
    deep_needed = classes[CLASS_DEEP].count;
    block_needed = blocks;
    slot_needed = blocks > 0xffffffffu / DEEP_BLOCK ? 0xffffffffu : blocks * DEEP_BLOCK;
    walk_needed = largest > WALK_CHUNK ? classes[CLASS_DEEP].count : 0u;
#if STRATA_LAYOUT == 1
    index_needed = blocks > 0u ? strata_pixel_count() : 0u;
#endif
    blocks = 0u; // becomes the cursor of pass 3
}
