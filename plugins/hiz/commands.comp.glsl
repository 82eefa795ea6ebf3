// SPDX-License-Identifier: MIT
//
// hiz: the commands of each chunk of objects, in the objects' order.
#include "strata/objects.glsl"
#include "strata/scan.glsl"
#include "marks.glsl"

struct Command {
    uint index_count, instance_count, first_index;
    int vertex_offset;
    uint first_instance;
};

layout(std430) readonly buffer Marks { uint marks[]; };
layout(std430) readonly buffer Chunks { uint chunks[]; };
layout(std430) readonly buffer Sums { uint sums[]; };
layout(std430) writeonly buffer Commands { Command commands[]; };
STRATA_PARAMS { uint count; } params;

void main() {
    uint chunk = strata_item(), first = min(chunk * CHUNK, params.count),
         last = min(first + CHUNK, params.count), before = 0u;
    if (first >= last)
        return;
    uint at = sums[chunk / STRATA_GROUP] + chunks[chunk];
    Command command = Command(0u, 0u, 0u, 0, 0u);
    for (uint i = first; i < last; ++i) {
        uint mark = marks[i];
        if ((mark & DRAWN) != 0u) {
            if ((mark & JOINS) == 0u || (before & DRAWN) == 0u) {
                if (command.instance_count > 0u)
                    commands[at++] = command;
                command = Command(strata_objects[i].index_count, 1u, strata_objects[i].first_index, 0, i);
            } else if ((strata_objects[i].flags & STRATA_OBJECT_NEXT) != 0u) {
                ++command.instance_count;
            } else {
                command.index_count += strata_objects[i].index_count;
            }
        }
        before = mark;
    }
    if (command.instance_count > 0u)
        commands[at] = command;
}
