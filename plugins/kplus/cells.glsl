// SPDX-License-Identifier: MIT
//
// kplus, array and heap: the state of a pixel in two words while fragments arrive.
//   x  the key of the farthest record once all slots are taken, STRATA_NO_KEY before: what lies behind
//      it is culled at a glance. It only falls, so that it may be read without exclusion.
//   y  records so far; the array's farthest among them; flags
const uint CELL_COUNT = 0xffffu;
const uint CELL_PLACE_SHIFT = 16u;
const uint CELL_PLACE = 0x3fffu;           // after the shift
const uint CELL_ROOMY = 0x40000000u;       // no more fragments arrive than there are slots
const uint CELL_LOCKED = 0x80000000u;
const uvec2 CELL_CLOSED = uvec2(0u, 0xffffu); // the pool is too small: nothing is stored
