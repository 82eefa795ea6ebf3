// SPDX-License-Identifier: MIT
//
// kplus, before the fragments. Atomics: every slot is empty. With memory=fixed also what the pool needs;
// ordered attachments need nothing else (NEEDS_ONLY).
#define STRATA_RECORDS writeonly
#define STRATA_KEYS STRATA_PAIR
#include "slots.glsl"
#include "strata/scan.glsl"

layout(std430) buffer StrataFragmentPool { uint strata_needed; uint strata_capacity; };

void main() {
    uint slot = strata_item();
#ifndef EXACT
    if (slot == 0u)
        strata_needed = slots_needed();
#endif
#ifndef NEEDS_ONLY
    if (slot < strata_capacity)
        strata_keys[slot] = STRATA_TO_PAIR(uvec2(0xffffffffu));
#endif
}
