// SPDX-License-Identifier: MIT
//
// fpc, merge sort, step 2 and on, one invocation a chunk of output: merges neighbouring sorted runs of
// params.run slots of a pixel into runs twice as long.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "ranked.glsl"

FPC_TABLE(readonly)
#include "sorting.glsl"
STRATA_PARAMS { uint run; } params;
#define STRATA_MERGE_FROM(at) FROM_SLOTS[at]
#define STRATA_MERGE_TO(at, slot) TO_SLOTS[at] = slot
#include "strata/merge.glsl"
RANK_BY(rank_of_chunk, ranked_chunks, x)

void main() {
    uint chunk = strata_item();
    if (chunk >= chunks)
        return;
    uint rank = rank_of_chunk(chunk), begin = (chunk - ranked_chunks[rank].x) * CHUNK;
    uint count = strata_range_at(ranked_elements[rank].x).y;
    strata_merge(ranked_elements[rank].y, count, params.run, begin, begin + CHUNK);
}
