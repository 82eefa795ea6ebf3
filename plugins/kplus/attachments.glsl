// SPDX-License-Identifier: MIT
//
// kplus, ordered attachments: K records a pixel as pairs in RGBA32U texels, two a texel, in complement, so
// that a cleared texel holds records nearer than none and the farthest is the smallest pair. Where there
// is room, the pair after them counts what arrived; with K = 16, `dropped` counts instead.
#if K < 16
#define COUNTED
#define PAIRS (K + 1)
#else
#define PAIRS 16
#endif

// EACH(M) is M(0) M(1) .. for the attachments that hold PAIRS pairs.
#if PAIRS > 2
#define EACH_1(M) M(1)
#else
#define EACH_1(M)
#endif
#if PAIRS > 4
#define EACH_2(M) M(2)
#else
#define EACH_2(M)
#endif
#if PAIRS > 6
#define EACH_3(M) M(3)
#else
#define EACH_3(M)
#endif
#if PAIRS > 8
#define EACH_4(M) M(4)
#else
#define EACH_4(M)
#endif
#if PAIRS > 10
#define EACH_5(M) M(5)
#else
#define EACH_5(M)
#endif
#if PAIRS > 12
#define EACH_6(M) M(6)
#else
#define EACH_6(M)
#endif
#if PAIRS > 14
#define EACH_7(M) M(7)
#else
#define EACH_7(M)
#endif
#define EACH(M)                                                                                    \
    M(0) EACH_1(M) EACH_2(M) EACH_3(M) EACH_4(M) EACH_5(M) EACH_6(M) EACH_7(M)
