// SPDX-License-Identifier: MIT
//
// kplus, 64-bit atomics, last: values become records of fragments/1, key before order in memory.
#define STRATA_RECORDS
#include "slots.glsl"
#include "strata/scan.glsl"
#include "strata/pool.glsl"

void main() {
    uint slot = strata_item();
    if (slot < min(strata_pool_needed(), strata_pool_capacity()))
        strata_keys[slot] = strata_keys[slot].yx;
}
