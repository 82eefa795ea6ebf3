// SPDX-License-Identifier: MIT
//
// ppc: pixels in classes by their number of fragments, and the table that the passes share. A pixel
// without fragments has no class and costs nothing.

#define CLASS_COUNT 6u
#define CLASS_DEEP 5u // more than a register network holds
#define DEEP_BLOCK 32u
#define WALK_CHUNK 32768u // fragments that one invocation folds: well below drivers' loop budgets

uint class_of(uint count) {
    return count == 1u ? 0u : count <= 8u ? 1u : count <= 16u ? 2u : count <= 32u ? 3u
         : count <= 64u ? 4u : CLASS_DEEP;
}

struct Class {
    uint count;  // pixels
    uint offset; // of its first pixel in Lists
    uint cursor;
    uint unused;
    uvec4 groups; // of its indirect dispatch
};

// Mirrors struct table in ppc.c.
#define CLASS_TABLE(access)                                                                        \
    layout(std430) access buffer Classes {                                                         \
        Class classes[CLASS_COUNT];                                                                \
        uvec4 tied_groups;  /* pixels with equal keys */                                           \
        uvec4 block_groups; /* blocks of the deep pixels */                                        \
        uint largest;       /* fragments in one pixel */                                           \
        uint blocks;        /* of the deep pixels */                                               \
        uint cursor;        /* of pass 3: blocks that were given out */                            \
        uint deep_fits;     /* 1: no pool of the deep pixels is too small */                       \
    };
