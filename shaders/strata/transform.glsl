// SPDX-License-Identifier: MIT
//
// From an object to the clip volume, in the one written order that the vertex stage has: who predicts
// where vertices will land computes with the same roundings.
#ifndef STRATA_TRANSFORM_GLSL
#define STRATA_TRANSFORM_GLSL

#include "strata/frame.glsl"
#include "strata/scene.glsl"

layout(std430) readonly buffer StrataRecords { StrataRecord strata_records[]; };

vec3 strata_to_world(StrataRecord record, vec3 p) {
    precise vec3 world;
    for (int i = 0; i < 3; ++i)
        world[i] = record.world[i].x * p.x + record.world[i].y * p.y + record.world[i].z * p.z +
                   record.world[i].w;
    return world;
}

vec4 strata_project(vec3 world) {
    precise vec4 clip = strata_world_to_clip[0] * world.x + strata_world_to_clip[1] * world.y +
                        strata_world_to_clip[2] * world.z + strata_world_to_clip[3];
    return clip;
}

#endif
