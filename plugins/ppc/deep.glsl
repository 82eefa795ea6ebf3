// SPDX-License-Identifier: MIT
//
// ppc, deep pixels: a pixel's fragments as a permutation of slots, in blocks of DEEP_BLOCK, held twice
// so that merging can alternate between the copies. The work items are blocks, so that no invocation
// loops over a whole pixel; only the fold does, in chunks of WALK_CHUNK.
#include "classes.glsl"

layout(std430) readonly buffer Lists { uint lists[]; };
layout(std430) readonly buffer DeepBase { uint deep_base[]; }; // first block of a deep pixel
layout(std430) readonly buffer DeepPool { uint deep_needed; uint deep_capacity; };
layout(std430) readonly buffer BlockPool { uint block_needed; uint block_capacity; };
layout(std430) readonly buffer SlotPool { uint slot_needed; uint slot_capacity; };

// False while a pool is too small: the frame is going to be recorded again.
bool deep_fits() {
    return deep_needed <= deep_capacity && block_needed <= block_capacity &&
           slot_needed <= slot_capacity && strata_needed <= strata_capacity;
}

uint blocks_of(uint count) { return (count + DEEP_BLOCK - 1u) / DEEP_BLOCK; }
