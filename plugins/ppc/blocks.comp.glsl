// SPDX-License-Identifier: MIT
//
// ppc, deep pass 3, one invocation a block: sorts its DEEP_BLOCK slots by (key, order) in registers.
#define STRATA_EXCHANGE(i, j)                                                                      \
    {                                                                                              \
        uint ki = k[i], kj = k[j], oi = o[i], oj = o[j], si = s[i], sj = s[j];                     \
        bool swap = kj < ki || (kj == ki && oj < oi);                                              \
        k[i] = swap ? kj : ki;                                                                     \
        k[j] = swap ? ki : kj;                                                                     \
        o[i] = swap ? oj : oi;                                                                     \
        o[j] = swap ? oi : oj;                                                                     \
        s[i] = swap ? sj : si;                                                                     \
        s[j] = swap ? si : sj;                                                                     \
    }
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "strata/sort.glsl"
#include "deep.glsl"

layout(std430) readonly buffer BlockOwner { uint block_owner[]; };
layout(std430) writeonly buffer Slots0 { uint slots0[]; };
#if STRATA_LAYOUT == 1
layout(std430) readonly buffer Slots1 { uint slots1[]; };
#define SLOT(i) slots1[block * DEEP_BLOCK + i]
#else
#define SLOT(i) (range.x + first + i)
#endif

#define LOAD(i)                                                                                    \
    k[i] = STRATA_NO_KEY;                                                                          \
    o[i] = STRATA_NO_KEY;                                                                          \
    s[i] = 0u;                                                                                     \
    if (first + i < range.y) {                                                                     \
        s[i] = SLOT(i);                                                                            \
        k[i] = strata_keys[s[i]].x;                                                                \
        o[i] = strata_keys[s[i]].y;                                                                \
    }
#define STORE(i)                                                                                   \
    if (first + i < range.y)                                                                       \
        slots0[block * DEEP_BLOCK + i] = s[i];

void main() {
    uint block = strata_item();
    if (deep_fits == 0u || block >= blocks)
        return;
    uint deep = block_owner[block];
    uvec2 range = strata_ranges[lists[classes[CLASS_DEEP].offset + deep]];
    uint first = (block - deep_base[deep]) * DEEP_BLOCK;
    uint k[DEEP_BLOCK], o[DEEP_BLOCK], s[DEEP_BLOCK];
    STRATA_REPEAT_32(LOAD, 0u)
    STRATA_SORT_32(0)
    STRATA_REPEAT_32(STORE, 0u)
}
