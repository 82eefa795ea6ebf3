// SPDX-License-Identifier: MIT
//
// cullcheck: which object a fragment belongs to, and the nearest that any of it can be.
#ifndef CULLCHECK_OBJECT_GLSL
#define CULLCHECK_OBJECT_GLSL

#include "strata/objects.glsl"
#include "strata/shading.glsl"
#include "strata/transform.glsl"

const uint SEEN = 1u;     // a fragment level with or in front of the final depth
const uint OVERSHOT = 2u; // the same, but nearer than any vertex of the object

// Draws that nobody culled name the first cluster's record for all clusters of a mesh.
uint fragment_object() {
    uint first = strata_in_record, low = 0u, high = strata_objects[first].clusters;
    uint index = strata_objects[first].first_index + 3u * uint(gl_PrimitiveID);
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (strata_objects[first + middle].first_index <= index)
            low = middle;
        else
            high = middle;
    }
    return first + low;
}

// Reversed depth that no vertex is nearer than, from above: 8 roundings of the magnitudes that add up
// in the two matrices for a vertex, 8 for the corner, and 2 for the division. Without bounds, or
// where the box reaches the eye's plane: anything.
float nearest_depth(uint item) {
    const float ROUNDING = 1.1920929e-7, ANYTHING = 2.0; // 2^-23
    StrataObject object = strata_objects[item];
    StrataRecord record = strata_record_at(item);
    if ((object.flags & STRATA_OBJECT_UNBOUNDED) != 0u)
        return ANYTHING;
    vec3 reach = max(abs(object.lower), abs(object.upper)), world;
    for (int i = 0; i < 3; ++i)
        world[i] = dot(abs(record.world[i].xyz), reach) + abs(record.world[i].w);
    vec4 margin = abs(strata_world_to_clip[0]) * world.x + abs(strata_world_to_clip[1]) * world.y +
                  abs(strata_world_to_clip[2]) * world.z + abs(strata_world_to_clip[3]);
    margin *= 16.0 * ROUNDING;
    float nearest = 0.0;
    for (uint i = 0u; i < 8u; ++i) {
        bvec3 upper = notEqual(uvec3(i) & uvec3(1u, 2u, 4u), uvec3(0u));
        vec4 clip = strata_project(strata_to_world(record, mix(object.lower, object.upper, upper)));
        float w = clip.w - margin.w;
        if (!(w > 0.0))
            return ANYTHING;
        nearest = max(nearest, (max(clip.z, 0.0) + margin.z) / w);
    }
    return nearest * (1.0 + 2.0 * ROUNDING);
}

#endif
