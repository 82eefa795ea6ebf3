// SPDX-License-Identifier: MIT
//
// From an object to the clip volume, in the one written order that the vertex stage has: who predicts
// where vertices will land computes with the same roundings.
#ifndef STRATA_TRANSFORM_GLSL
#define STRATA_TRANSFORM_GLSL

#include "strata/frame.glsl"
#include "strata/scene.glsl"

STRATA_READ(StrataRecords, StrataRecord)

StrataRecord strata_record_at(uint i) {
#ifdef STRATA_TEXELS
    uint at = 24u * i, row = 6u * i;
    StrataRecord record;
    for (uint k = 0u; k < 3u; ++k)
        record.world[k] = STRATA_AT_VEC4(StrataRecords, row + k);
    record.material = STRATA_AT_UINT(StrataRecords, at + 12u);
    record.primitive_base = STRATA_AT_UINT(StrataRecords, at + 13u);
    record.primitive_map = STRATA_AT_UINT(StrataRecords, at + 14u);
    record.flags = STRATA_AT_UINT(StrataRecords, at + 15u);
    record.position = STRATA_AT_UINT(StrataRecords, at + 16u);
    record.normal = STRATA_AT_UINT(StrataRecords, at + 17u);
    record.tangent = STRATA_AT_UINT(StrataRecords, at + 18u);
    record.uv0 = STRATA_AT_UINT(StrataRecords, at + 19u);
    record.uv1 = STRATA_AT_UINT(StrataRecords, at + 20u);
    record.color = STRATA_AT_UINT(StrataRecords, at + 21u);
    record.radius = STRATA_AT_UINT(StrataRecords, at + 22u);
    record.scale = STRATA_AT_FLOAT(StrataRecords, at + 23u);
    return record;
#else
    return StrataRecords_at[i];
#endif
}

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
