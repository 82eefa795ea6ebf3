// SPDX-License-Identifier: MIT
//
// fpc, contiguous records, merge sort, step 1, one invocation a chunk: its slots as sorted runs of
// STRATA_SORT_BLOCK, in the order of the ranks.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "ranked.glsl"

FPC_TABLE(readonly)
#include "sorting.glsl"
#define STRATA_SORT_FROM(at) (at)
#define STRATA_SORT_TO(at, slot) FROM_SLOTS[at] = slot
#include "strata/sort_block.glsl"
RANK_BY(rank_of_chunk, ranked_chunks, x)

void main() {
    uint chunk = strata_item();
    if (chunk >= chunks)
        return;
    uint rank = rank_of_chunk(chunk), begin = (chunk - ranked_chunks[rank].x) * CHUNK;
    uvec2 range = strata_range_at(ranked_elements[rank].x);
    uint base = ranked_elements[rank].y;
    for (uint at = begin; at < min(begin + CHUNK, range.y); at += STRATA_SORT_BLOCK)
        strata_sort_block(range.x + at, base + at, min(range.y - at, STRATA_SORT_BLOCK));
}
