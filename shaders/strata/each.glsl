// SPDX-License-Identifier: MIT
//
// STRATA_EACH(M) is M(0) M(1) .. for the STRATA_EACH_COUNT (1 to 8) attachments that the includer has.
#ifndef STRATA_EACH_GLSL
#define STRATA_EACH_GLSL

#if STRATA_EACH_COUNT > 1
#define STRATA_EACH_1(M) M(1)
#else
#define STRATA_EACH_1(M)
#endif
#if STRATA_EACH_COUNT > 2
#define STRATA_EACH_2(M) M(2)
#else
#define STRATA_EACH_2(M)
#endif
#if STRATA_EACH_COUNT > 3
#define STRATA_EACH_3(M) M(3)
#else
#define STRATA_EACH_3(M)
#endif
#if STRATA_EACH_COUNT > 4
#define STRATA_EACH_4(M) M(4)
#else
#define STRATA_EACH_4(M)
#endif
#if STRATA_EACH_COUNT > 5
#define STRATA_EACH_5(M) M(5)
#else
#define STRATA_EACH_5(M)
#endif
#if STRATA_EACH_COUNT > 6
#define STRATA_EACH_6(M) M(6)
#else
#define STRATA_EACH_6(M)
#endif
#if STRATA_EACH_COUNT > 7
#define STRATA_EACH_7(M) M(7)
#else
#define STRATA_EACH_7(M)
#endif
#define STRATA_EACH(M)                                                                             \
    M(0) STRATA_EACH_1(M) STRATA_EACH_2(M) STRATA_EACH_3(M) STRATA_EACH_4(M) STRATA_EACH_5(M)      \
        STRATA_EACH_6(M) STRATA_EACH_7(M)

#endif
