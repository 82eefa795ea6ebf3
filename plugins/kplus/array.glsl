// SPDX-License-Identifier: MIT
//
// kplus, max-array: records stay where they were put; the place of the farthest is found again whenever
// it changes, by one walk over the keys. Faster than a heap for few slots.

uint farthest_place(uvec2 slots, uvec2 cell) { return cell.y >> CELL_PLACE_SHIFT & CELL_PLACE; }

// After a record was stored at `place`: the state of a pixel with `count` of them.
uvec2 settle(uvec2 slots, uvec2 cell, uint count, uint place, uvec2 record) {
    if (count < slots.y || (cell.y & CELL_ROOMY) != 0u)
        return uvec2(STRATA_NO_KEY, count | (cell.y & CELL_ROOMY));
    uint farthest = 0u, at = 0u;
    bool tied = false;
    for (uint i = 0u; i < count; ++i) {
        uint key = key_at(slots.x + i).x;
        if (key >= farthest) {
            tied = key == farthest;
            farthest = key;
            at = i;
        }
    }
    if (tied) {
        uint last = 0u;
        for (uint i = 0u; i < count; ++i) {
            uvec2 key = key_at(slots.x + i);
            if (key.x == farthest && key.y >= last) {
                last = key.y;
                at = i;
            }
        }
    }
    return uvec2(farthest, count | at << CELL_PLACE_SHIFT);
}
