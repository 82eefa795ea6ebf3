// SPDX-License-Identifier: MIT
//
// kplus, array and heap, before the fragments: every cell is empty. With memory=fixed also what the pool
// needs.
#include "slots.glsl"
#include "cells.glsl"
#ifdef EXACT
#include "strata/tiles.glsl"
#else
#include "strata/scan.glsl"
#endif

layout(std430) buffer StrataFragmentPool { uint strata_needed; uint strata_capacity; };

void main() {
    uint pixel = strata_item();
    if (pixel >= strata_pixel_count())
        return;
    uvec2 position = strata_position(pixel);
    uvec2 cell = uvec2(STRATA_NO_KEY, 0u);
#ifdef EXACT
    uint needed = strata_needed;
    if (strata_count_at(pixel) <= slots_of(position).y)
        cell.y = CELL_ROOMY;
#else
    uint needed = slots_needed();
    if (pixel == 0u)
        strata_needed = needed;
#endif
    put_cell(position, needed > strata_capacity ? CELL_CLOSED : cell);
}
