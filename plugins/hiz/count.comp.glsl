// SPDX-License-Identifier: MIT
//
// hiz: how many commands each chunk of objects makes, and where they begin within its work group's.
#include "strata/scan.glsl"
#include "marks.glsl"

layout(std430) readonly buffer Marks { uint marks[]; };
layout(std430) writeonly buffer Chunks { uint chunks[]; };
layout(std430) writeonly buffer Sums { uint sums[]; };
STRATA_PARAMS { uint count; } params;

void main() {
    uint chunk = strata_item(), first = min(chunk * CHUNK, params.count),
         last = min(first + CHUNK, params.count), runs = 0u, before = 0u;
    for (uint i = first; i < last; ++i) {
        uint mark = marks[i];
        bool joins = (mark & JOINS) != 0u && (before & DRAWN) != 0u;
        runs += uint((mark & DRAWN) != 0u && !joins);
        before = mark;
    }
    uint total, start = strata_scan(runs, total);
    if (first < last) {
        chunks[chunk] = start;
        if (gl_LocalInvocationID.x == 0u)
            sums[chunk / STRATA_GROUP] = total;
    }
}
