// SPDX-License-Identifier: MIT
//
// fpc: the ranked pixels, each with its first element, chunk and joint. These ascend with the rank, so
// an invocation finds the pixel of an element by bisection: the same work wherever fragments lie.
layout(std430) readonly buffer RankedElements { uvec2 ranked_elements[]; }; // pixel, first element
layout(std430) readonly buffer RankedChunks { uvec2 ranked_chunks[]; };     // first chunk, first joint

uint chunks_of(uint count) { return (count + CHUNK - 1u) / CHUNK; }

// The last rank whose first item is not beyond `item`; every rank has an item.
#define RANK_BY(name, table, first)                                                                \
    uint name(uint item) {                                                                         \
        uint low = 0u, high = pixels - 1u;                                                         \
        while (low < high) {                                                                       \
            uint middle = low + (high - low + 1u) / 2u;                                            \
            if (table[middle].first <= item)                                                       \
                low = middle;                                                                      \
            else                                                                                   \
                high = middle - 1u;                                                                \
        }                                                                                          \
        return low;                                                                                \
    }
