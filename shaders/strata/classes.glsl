// SPDX-License-Identifier: MIT
//
// Pixels in classes by their number of fragments, and the table that the passes over them share
// (plugins/shared/classes.h). A pixel without fragments has no class and costs nothing.
#ifndef STRATA_CLASSES_GLSL
#define STRATA_CLASSES_GLSL

#define CLASS_COUNT 6u
#define CLASS_DEEP 5u  // more than a register network holds
#define DEEP_BLOCK 32u // fragments of a deep pixel that a network sorts at once, where one does

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

// Mirrors struct classes_table in plugins/shared/classes.h.
#define CLASS_TABLE(access)                                                                        \
    layout(std430) access buffer Classes {                                                         \
        Class classes[CLASS_COUNT];                                                                \
        uvec4 tied_groups;  /* pixels with equal keys */                                           \
        uvec4 block_groups; /* blocks of the deep pixels */                                        \
        uint largest;       /* fragments in one pixel */                                           \
        uint blocks;        /* of the deep pixels */                                               \
        uint cursor;        /* of the lists: blocks that were given out */                         \
        uint deep_fits;     /* 1: no pool of the deep pixels is too small */                       \
    };

#endif
