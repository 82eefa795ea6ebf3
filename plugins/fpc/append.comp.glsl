// SPDX-License-Identifier: MIT
//
// fpc, pass 4, linked records: an element for each record of a ranked pixel, in any order, which the
// sort makes one. Lists are not walked, so their length does not matter.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "pixels.glsl"

FPC_TABLE(restrict)
layout(std430) readonly buffer RankOf { uint rank_of[]; };
#include "sorting.glsl"
#include "extent.glsl"
#include "strata/pool.glsl"
shared uint group_at;

void main() {
    uint begin = strata_item() * ELEMENTS_PER_INVOCATION;
    uint end = min(begin + ELEMENTS_PER_INVOCATION, strata_pool_needed()), mine = 0u, total;
    uvec4 extent = uvec4(0u);
    begin_extent();
    for (uint slot = begin; slot < end; ++slot)
        mine += uint(count_of(strata_link_at(slot).y) > 0u);
    uint at = strata_scan(mine, total);
    if (gl_LocalInvocationID.x == 0u && total > 0u)
        group_at = atomicAdd(appended, total);
    barrier();
    at += group_at;
    for (uint slot = begin; slot < end; ++slot) {
        uint pixel = strata_link_at(slot).y;
        if (count_of(pixel) == 0u)
            continue;
        uvec2 key = strata_key_at(slot);
        if (at < elements) {
            FROM_ELEMENTS[at] = uvec2(rank_of[pixel], key.x);
            FROM_SLOTS[at] = slot;
        }
        ++at;
        extent = max(extent, extent_of(key));
    }
    end_extent(extent);
}
