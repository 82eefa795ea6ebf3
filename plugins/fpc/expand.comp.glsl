// SPDX-License-Identifier: MIT
//
// fpc, pass 4, contiguous records: an element for each fragment, in the order of the ranks.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "ranked.glsl"

FPC_TABLE(restrict)
#include "sorting.glsl"
#include "extent.glsl"
RANK_BY(rank_of_element, ranked_elements, y)

void main() {
    uint begin = strata_item() * ELEMENTS_PER_INVOCATION;
    uvec4 extent = uvec4(0u);
    begin_extent();
    if (begin < elements) {
        uint rank = rank_of_element(begin), end = min(begin + ELEMENTS_PER_INVOCATION, elements);
        uint first = ranked_elements[rank].y;
        uvec2 range = strata_range_at(ranked_elements[rank].x);
        for (uint i = begin; i < end; ++i) {
            if (i - first >= range.y) {
                first = i;
                range = strata_range_at(ranked_elements[++rank].x);
            }
            uint slot = range.x + (i - first);
            uvec2 key = strata_key_at(slot);
            FROM_ELEMENTS[i] = uvec2(rank, key.x);
            FROM_SLOTS[i] = slot;
            extent = max(extent, extent_of(key));
        }
    }
    end_extent(extent);
}
