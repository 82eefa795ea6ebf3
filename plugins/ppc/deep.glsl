// SPDX-License-Identifier: MIT
//
// ppc, deep pixels: a pixel's fragments as a permutation of slots, in blocks of DEEP_BLOCK, held twice
// so that merging can alternate between the copies. The work items are blocks, so that no invocation
// loops over a whole pixel; only the fold does, in chunks of WALK_CHUNK.
#include "classes.glsl"

CLASS_TABLE(readonly)
layout(std430) readonly buffer Lists { uint lists[]; };
layout(std430) readonly buffer DeepBase { uint deep_base[]; }; // first block of a deep pixel

uint blocks_of(uint count) { return (count + DEEP_BLOCK - 1u) / DEEP_BLOCK; }
