// SPDX-License-Identifier: MIT
//
// kplus, array and heap: the state of a pixel in two words while fragments arrive.
//   x  once all slots are taken, the key of the farthest record, or one behind it: what lies behind that
//      is culled at a glance. STRATA_NO_KEY before. It only falls, so that it may be read without exclusion.
//   y  records so far; flags
// With TEXELS one word does: the key, or beyond every key the number of records.
const uint CELL_COUNT = 0xffffu;
const uint CELL_ROOMY = 0x40000000u; // no more fragments arrive than there are slots
const uint CELL_LOCKED = 0x80000000u;
const uvec2 CELL_CLOSED = uvec2(STRATA_NO_KEY, 0xffffu); // the pool is too small: nothing is stored

#ifdef TEXELS
#include "texels.glsl"

const uint CELL_FILLING = 0x40000000u;

uvec2 cell_at(uvec2 position) {
    uint word = placed_at(texel_of(places_of(position), params.k));
    return word > STRATA_FAR_KEY ? uvec2(STRATA_NO_KEY, word & CELL_COUNT) : uvec2(word, params.k);
}
void put_cell(uvec2 position, uvec2 cell) {
    uint word = cell.x == STRATA_NO_KEY ? CELL_FILLING | cell.y : cell.x;
    put_placed(texel_of(places_of(position), params.k), word);
}
#else
#ifndef CELLS
#define CELLS // qualifiers
#endif
#ifdef LOCK // single words, for atomics
layout(std430) CELLS buffer Cells { uvec2 cells[]; };
uvec2 cell_at(uvec2 position) { return cells[block_index(position)]; }
void put_cell(uvec2 position, uvec2 cell) { cells[block_index(position)] = cell; }
#else
layout(std430) CELLS buffer Cells { STRATA_PAIR cells[]; };
uvec2 cell_at(uvec2 position) { return STRATA_FROM_PAIR(cells[block_index(position)]); }
void put_cell(uvec2 position, uvec2 cell) { cells[block_index(position)] = STRATA_TO_PAIR(cell); }
#endif
#endif
