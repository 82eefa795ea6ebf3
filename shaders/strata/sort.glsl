// SPDX-License-Identifier: MIT
//
// Sorting networks in registers (Batcher 1968, odd-even merge). The caller declares `uint k[N]` (keys)
// and `uint s[N]` (what travels with them); every index is a constant expression, so that nothing is
// indexed dynamically. STRATA_SORT_N(0) sorts ascending by k. A caller that compares more than k defines
// its own STRATA_EXCHANGE(i, j) first. STRATA_REPEAT_N(M, o) is M(o) .. M(o + N - 1).
#ifndef STRATA_SORT_GLSL
#define STRATA_SORT_GLSL

#ifndef STRATA_EXCHANGE
#define STRATA_EXCHANGE(i, j)                                                                      \
    {                                                                                              \
        uint ki = k[i], kj = k[j], si = s[i], sj = s[j];                                           \
        bool swap = kj < ki;                                                                       \
        k[i] = min(ki, kj);                                                                        \
        k[j] = max(ki, kj);                                                                        \
        s[i] = swap ? sj : si;                                                                     \
        s[j] = swap ? si : sj;                                                                     \
    }
#endif

// STRATA_CHAIN_n(o, r): n exchanges of neighbours (o, o + r), (o + 2 r, o + 3 r), ...
#define STRATA_CHAIN_1(o, r) STRATA_EXCHANGE(o, (o) + (r))
#define STRATA_CHAIN_2(o, r) STRATA_CHAIN_1(o, r) STRATA_CHAIN_1((o) + 2 * (r), r)
#define STRATA_CHAIN_3(o, r) STRATA_CHAIN_2(o, r) STRATA_CHAIN_1((o) + 4 * (r), r)
#define STRATA_CHAIN_4(o, r) STRATA_CHAIN_2(o, r) STRATA_CHAIN_2((o) + 4 * (r), r)
#define STRATA_CHAIN_7(o, r) STRATA_CHAIN_4(o, r) STRATA_CHAIN_3((o) + 8 * (r), r)
#define STRATA_CHAIN_8(o, r) STRATA_CHAIN_4(o, r) STRATA_CHAIN_4((o) + 8 * (r), r)
#define STRATA_CHAIN_15(o, r) STRATA_CHAIN_8(o, r) STRATA_CHAIN_7((o) + 16 * (r), r)
#define STRATA_CHAIN_16(o, r) STRATA_CHAIN_8(o, r) STRATA_CHAIN_8((o) + 16 * (r), r)
#define STRATA_CHAIN_31(o, r) STRATA_CHAIN_16(o, r) STRATA_CHAIN_15((o) + 32 * (r), r)

// STRATA_MERGE_n(o, r): merges the sorted halves of the n elements o, o + r, o + 2 r, ...
#define STRATA_MERGE_2(o, r) STRATA_EXCHANGE(o, (o) + (r))
#define STRATA_MERGE_4(o, r)                                                                       \
    STRATA_MERGE_2(o, 2 * (r)) STRATA_MERGE_2((o) + (r), 2 * (r)) STRATA_CHAIN_1((o) + (r), r)
#define STRATA_MERGE_8(o, r)                                                                       \
    STRATA_MERGE_4(o, 2 * (r)) STRATA_MERGE_4((o) + (r), 2 * (r)) STRATA_CHAIN_3((o) + (r), r)
#define STRATA_MERGE_16(o, r)                                                                      \
    STRATA_MERGE_8(o, 2 * (r)) STRATA_MERGE_8((o) + (r), 2 * (r)) STRATA_CHAIN_7((o) + (r), r)
#define STRATA_MERGE_32(o, r)                                                                      \
    STRATA_MERGE_16(o, 2 * (r)) STRATA_MERGE_16((o) + (r), 2 * (r)) STRATA_CHAIN_15((o) + (r), r)
#define STRATA_MERGE_64(o, r)                                                                      \
    STRATA_MERGE_32(o, 2 * (r)) STRATA_MERGE_32((o) + (r), 2 * (r)) STRATA_CHAIN_31((o) + (r), r)

#define STRATA_SORT_2(o) STRATA_MERGE_2(o, 1)
#define STRATA_SORT_4(o) STRATA_SORT_2(o) STRATA_SORT_2((o) + 2) STRATA_MERGE_4(o, 1)
#define STRATA_SORT_8(o) STRATA_SORT_4(o) STRATA_SORT_4((o) + 4) STRATA_MERGE_8(o, 1)
#define STRATA_SORT_16(o) STRATA_SORT_8(o) STRATA_SORT_8((o) + 8) STRATA_MERGE_16(o, 1)
#define STRATA_SORT_32(o) STRATA_SORT_16(o) STRATA_SORT_16((o) + 16) STRATA_MERGE_32(o, 1)
#define STRATA_SORT_64(o) STRATA_SORT_32(o) STRATA_SORT_32((o) + 32) STRATA_MERGE_64(o, 1)

#define STRATA_REPEAT_8(M, o)                                                                             \
    M((o) + 0u) M((o) + 1u) M((o) + 2u) M((o) + 3u) M((o) + 4u) M((o) + 5u) M((o) + 6u) M((o) + 7u)
#define STRATA_REPEAT_16(M, o) STRATA_REPEAT_8(M, o) STRATA_REPEAT_8(M, (o) + 8u)
#define STRATA_REPEAT_32(M, o) STRATA_REPEAT_16(M, o) STRATA_REPEAT_16(M, (o) + 16u)
#define STRATA_REPEAT_64(M, o) STRATA_REPEAT_32(M, o) STRATA_REPEAT_32(M, (o) + 32u)

#endif
