// SPDX-License-Identifier: MIT
//
// fpc, pass 3: ranks the pixels that have fragments and says where their elements, chunks and joints
// begin.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "pixels.glsl"

FPC_TABLE(readonly)
layout(std430) readonly buffer Sums { uvec4 sums[]; };
layout(std430) writeonly buffer RankedElements { uvec2 ranked_elements[]; };
layout(std430) writeonly buffer RankedChunks { uvec2 ranked_chunks[]; };
#if STRATA_LAYOUT == 1
layout(std430) writeonly buffer RankOf { uint rank_of[]; };
#endif

void main() {
    if (pixels == 0u)
        return; // for all alike: the hybrid may leave nothing
    uvec4 sum = uvec4(0u), total;
    for (uint i = 0u; i < PIXELS_PER_INVOCATION; ++i)
        sum = add(sum, share_of(count_of(pixel_at(i))));
    uvec4 at = scan(sum, total);
    uint group = strata_item() / STRATA_GROUP;
    if (fits == 0u || group >= group_count())
        return;
    at = add(at, sums[group]);
    for (uint i = 0u; i < PIXELS_PER_INVOCATION; ++i) {
        uint pixel = pixel_at(i), count = count_of(pixel);
        if (count == 0u)
            continue;
        ranked_elements[at.x] = uvec2(pixel, at.y);
        ranked_chunks[at.x] = at.zw;
#if STRATA_LAYOUT == 1
        rank_of[pixel] = at.x;
#endif
        at += share_of(count);
    }
}
