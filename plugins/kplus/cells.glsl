// SPDX-License-Identifier: MIT
//
// kplus, array and heap: the state of a pixel in two words while fragments arrive.
//   x  once all slots are taken, the key of the farthest record, or one behind it: what lies behind that
//      is culled at a glance. STRATA_NO_KEY before. It only falls, so that it may be read without exclusion.
//   y  records so far; flags
const uint CELL_COUNT = 0xffffu;
const uint CELL_ROOMY = 0x40000000u;       // no more fragments arrive than there are slots
const uint CELL_LOCKED = 0x80000000u;
const uvec2 CELL_CLOSED = uvec2(0u, 0xffffu); // the pool is too small: nothing is stored
