// SPDX-License-Identifier: MIT
//
// fpc: what its passes share. Pixels that have fragments are ranked 0, 1, ..; an element is one fragment,
// (rank, key) and the slot of its record. Elements of a rank lie together once they are sorted.

#ifdef HYBRID
#define FPC_LEAST 65u // fragments of a pixel that is sorted and folded here
#else
#define FPC_LEAST 1u
#endif
#define PIXELS_PER_INVOCATION 16u
#define ELEMENTS_PER_INVOCATION 16u // of passes that run over elements one by one
#define DIGITS 256u                 // of the radix sort, 8 bits
#define COUNTERS_PER_INVOCATION 64u
#define CHUNK 64u // fragments, then nodes, that one invocation folds in order: the tree's fan-in
#ifdef STRATA_BOUND // of words, that a node of that tree takes
#define JOINT_PAIRS (STRATA_CHANNELS == 3 ? 8u : 6u)
#else
#define JOINT_PAIRS (STRATA_CHANNELS == 3 ? 4u : 3u)
#endif

// Mirrors struct table in fpc.c.
#define FPC_TABLE(access)                                                                          \
    layout(std430) access buffer Table {                                                           \
        uvec4 element_groups;  /* work groups of passes over elements, streams, counters, .. */    \
        uvec4 stream_groups;                                                                       \
        uvec4 counter_groups;                                                                      \
        uvec4 chunk_groups;                                                                        \
        uvec4 joint_groups;                                                                        \
        uint pixels;           /* that were ranked */                                              \
        uint elements;                                                                             \
        uint chunks;                                                                               \
        uint joints;           /* chunks of pixels that have more than one */                      \
        uint streams;                                                                              \
        uint deepest;          /* fragments in one pixel */                                        \
        uint inverse_nearest;  /* the bits inverted of the least key, so that 0 is a beginning */  \
        uint farthest;         /* the largest key */                                               \
        uint inverse_first;    /* the same of order */                                             \
        uint last;                                                                                 \
        uint key_bits;         /* that the sort must look at, of key - nearest and so on */        \
        uint rank_bits;                                                                            \
        uint order_bits;       /* 0 while ties are few and short */                                \
        uint long_ties;        /* 1: more than TIE_LIMIT fragments of a pixel have one key */      \
        uint appended;         /* linked records only: elements so far */                          \
        uint fits;             /* 1: no pool is too small */                                       \
        uint stream;           /* elements that one invocation counts and scatters in order */     \
    };
