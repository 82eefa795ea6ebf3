// SPDX-License-Identifier: MIT
//
// Sorts a block of STRATA_SORT_BLOCK slots or fewer by (key, order), in registers. The includer says
// where slots come from and go to: STRATA_SORT_FROM(at) and STRATA_SORT_TO(at, slot).
#ifndef STRATA_SORT_BLOCK_GLSL
#define STRATA_SORT_BLOCK_GLSL

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
#include "strata/sort.glsl"

#define STRATA_SORT_BLOCK 32u

#define STRATA_SORT_LOAD(i)                                                                        \
    k[i] = STRATA_NO_KEY;                                                                          \
    o[i] = STRATA_NO_KEY;                                                                          \
    s[i] = 0u;                                                                                     \
    if (i < count) {                                                                               \
        s[i] = STRATA_SORT_FROM(from + i);                                                         \
        k[i] = strata_key_at(s[i]).x;                                                              \
        o[i] = strata_key_at(s[i]).y;                                                              \
    }
#define STRATA_SORT_STORE(i)                                                                       \
    if (i < count)                                                                                 \
        STRATA_SORT_TO(to + i, s[i]);

void strata_sort_block(uint from, uint to, uint count) {
    uint k[STRATA_SORT_BLOCK], o[STRATA_SORT_BLOCK], s[STRATA_SORT_BLOCK];
    STRATA_REPEAT_32(STRATA_SORT_LOAD, 0u)
    STRATA_SORT_32(0)
    STRATA_REPEAT_32(STRATA_SORT_STORE, 0u)
}

#endif
