// SPDX-License-Identifier: MIT
//
// ppc, pass 2, one invocation: where each class's list begins, and the indirect dispatches.
#include "strata/scan.glsl"
#include "classes.glsl"

CLASS_TABLE()
layout(std430) writeonly buffer DeepPool { uint deep_needed; };
layout(std430) writeonly buffer BlockPool { uint block_needed; };
layout(std430) writeonly buffer WalkPool { uint walk_needed; };

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
    block_needed = blocks * DEEP_BLOCK;
    walk_needed = largest > WALK_CHUNK ? classes[CLASS_DEEP].count : 0u;
    blocks = 0u; // becomes the cursor of pass 3
}
