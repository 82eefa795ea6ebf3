// SPDX-License-Identifier: MIT
//
// fpc, segmented fold, leaves of the tree, one invocation a chunk: CHUNK fragments of one pixel from
// the front on, counted from the pixel's first, so that the tree depends on the pixel alone.
#define STRATA_PAYLOAD_READ
#include "strata/fragments.glsl"
#include "strata/fold.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "ranked.glsl"
#include "joints.glsl"

FPC_TABLE(readonly)
layout(std430) readonly buffer Slots0 { uint slots0[]; };
STRATA_PARAMS { uint stride; float threshold; } params;
RANK_BY(rank_of_chunk, ranked_chunks, x)

void main() {
    uint chunk = strata_item();
    if (chunk >= chunks)
        return;
    uint rank = rank_of_chunk(chunk), at = chunk - ranked_chunks[rank].x;
    uint pixel = ranked_elements[rank].x, first = ranked_elements[rank].y;
    uint count = strata_range_at(pixel).y;
    uint begin = at * CHUNK, end = min(begin + CHUNK, count);
    StrataElement walk = strata_fold_begin();
    uint i = begin;
    for (; i < end && !strata_ended(walk, params.threshold); ++i)
        strata_fold_step(walk, strata_event(strata_payload_load(slots0[first + i])));
#ifdef STRATA_BOUND
    for (; i < end; ++i)
        strata_lose(pixel, strata_payload_load(slots0[first + i]));
#endif
    if (count <= CHUNK) {
        strata_output(pixel, walk);
        return;
    }
    uint joint = ranked_chunks[rank].y + at;
    put_joint(joint, rank, walk);
}
