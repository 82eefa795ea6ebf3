// SPDX-License-Identifier: MIT
//
// The one vertex stage of all that draws the scene. Vertices are pulled from storage by index, so
// that a slot is one multi-draw whatever its meshes have. Position is invariant and computed in one
// written order: a fragment's depth has the same bits in every pass.
#include "strata/frame.glsl"
#ifdef STRATA_HAS_LIT
#include "strata/lights.glsl"
#endif
#include "strata/math.glsl"
#include "strata/transform.glsl"

STRATA_READ(StrataPositions, float)

layout(location = 0) flat out uvec4 strata_out_ids; // material, primitive base and map, flags
layout(location = 1) flat out vec4 strata_out_base_color;
layout(location = 2) out vec3 strata_out_position;
#ifdef STRATA_HAS_LIT
STRATA_READ(StrataNormals, float)
layout(location = 3) out vec3 strata_out_normal;
#ifdef STRATA_HAS_TANGENTS
STRATA_READ(StrataTangents, vec4)
layout(location = 4) out vec4 strata_out_tangent;
#endif
#endif
#ifdef STRATA_HAS_TEXTURES
#ifdef STRATA_HAS_UV0
STRATA_READ(StrataUv0, vec2)
#endif
#ifdef STRATA_HAS_UV1
STRATA_READ(StrataUv1, vec2)
#endif
layout(location = 5) out vec4 strata_out_uv;
#endif
#ifdef STRATA_HAS_COLORS
STRATA_READ(StrataColors, vec4)
layout(location = 6) out vec4 strata_out_color;
#endif
#ifdef STRATA_HAS_POINTS
#ifdef STRATA_HAS_RADII
STRATA_READ(StrataRadii, float)
#endif
layout(location = 7) out vec2 strata_out_disc; // within the splat's disc: length <= 1; else 0
#endif

// What a fragment needs of its material: flat values cost it nothing, loads would.
#ifdef STRATA_HAS_LIT
layout(location = 8) flat out vec4 strata_out_reflection; // metallic, roughness, f0, transmission
#endif
#if defined(STRATA_HAS_EMISSION) || defined(STRATA_HAS_MASK)
layout(location = 9) flat out vec4 strata_out_emissive; // rgb, alpha cutoff
#endif
#ifdef STRATA_HAS_TEXTURES
// Base colour, metallic and roughness, normal, occlusion; emissive, transmission, and as bits of
// floats the strengths of normal map and occlusion.
layout(location = 10) flat out uvec4 strata_out_textures;
layout(location = 11) flat out uvec4 strata_out_more_textures;
#endif
#ifdef STRATA_WANTS_RECORD
layout(location = 12) flat out uint strata_out_record;
#endif

invariant gl_Position;

const float STRATA_SPLAT_PIXELS = 1.5; // radius of a splat that has none of its own

vec3 strata_world_position(StrataRecord record, uint vertex) {
    uint at = (record.position + vertex) * 3u;
    return strata_to_world(record, vec3(STRATA_AT_FLOAT(StrataPositions, at),
                                        STRATA_AT_FLOAT(StrataPositions, at + 1u),
                                        STRATA_AT_FLOAT(StrataPositions, at + 2u)));
}

#ifdef STRATA_HAS_LIT
// By the cofactors of the world matrix: right for any scale, also where it is singular.
precise vec3 strata_world_normal(StrataRecord record, vec3 n, float mirror) {
    vec3 a = record.world[0].xyz, b = record.world[1].xyz, c = record.world[2].xyz;
    vec3 largest = max(abs(a), max(abs(b), abs(c)));
    float size = max(largest.x, max(largest.y, max(largest.z, 1e-30)));
    a /= size;
    b /= size;
    c /= size;
    vec3 turned = vec3(strata_dot(strata_cross(b, c), n), strata_dot(strata_cross(c, a), n),
                       strata_dot(strata_cross(a, b), n));
    return strata_unit(turned * mirror);
}

void strata_write_normal(StrataRecord record, uint vertex) {
    float mirror = (record.flags & STRATA_RECORD_MIRRORED) != 0u ? -1.0 : 1.0;
    strata_out_normal = vec3(0.0);
    if ((record.flags & STRATA_RECORD_NORMALS) != 0u) {
        uint at = (record.normal + vertex) * 3u;
        vec3 n =
            vec3(STRATA_AT_FLOAT(StrataNormals, at), STRATA_AT_FLOAT(StrataNormals, at + 1u),
                 STRATA_AT_FLOAT(StrataNormals, at + 2u));
        strata_out_normal = strata_world_normal(record, n, mirror);
    }
#ifdef STRATA_HAS_TANGENTS
    strata_out_tangent = vec4(0.0);
    if ((record.flags & STRATA_RECORD_TANGENTS) != 0u) {
        vec4 t = STRATA_AT_VEC4(StrataTangents, record.tangent + vertex);
        vec3 world = vec3(strata_dot(record.world[0].xyz, t.xyz),
                          strata_dot(record.world[1].xyz, t.xyz),
                          strata_dot(record.world[2].xyz, t.xyz));
        strata_out_tangent = vec4(strata_unit(world), t.w * mirror);
    }
#endif
}
#endif

#ifdef STRATA_HAS_POINTS
// Moves a corner of a splat's quad, which faces the image plane, out from its centre.
void strata_expand_splat(StrataRecord record, uint vertex, vec2 corner, inout vec3 world,
                         inout vec4 clip) {
#ifdef STRATA_HAS_RADII
    if ((record.flags & STRATA_RECORD_RADII) != 0u) {
        float radius = STRATA_AT_FLOAT(StrataRadii, record.radius + vertex) * record.scale;
        vec3 right = vec3(strata_world_to_eye[0].x, strata_world_to_eye[1].x,
                          strata_world_to_eye[2].x);
        vec3 up = vec3(strata_world_to_eye[0].y, strata_world_to_eye[1].y,
                       strata_world_to_eye[2].y);
        precise vec3 moved = world + (right * corner.x + up * corner.y) * radius;
        world = moved;
        clip = strata_project(moved);
        return;
    }
#endif
    vec2 size = vec2(strata_frame_size.xy);
    float radius = STRATA_SPLAT_PIXELS * sqrt(float(max(strata_frame_size.z, 1u)));
    precise vec2 moved = clip.xy + corner * (2.0 * radius / size) * clip.w;
    clip.xy = moved;
}
#endif

void strata_write_material(StrataMaterial material) {
    strata_out_base_color = material.base_color;
#ifdef STRATA_HAS_LIT
    strata_out_reflection =
        vec4(material.metallic, material.roughness, material.f0, material.transmission);
#endif
#if defined(STRATA_HAS_EMISSION) || defined(STRATA_HAS_MASK)
    strata_out_emissive = material.emissive;
#endif
#ifdef STRATA_HAS_TEXTURES
    strata_out_textures = uvec4(material.base_color_texture, material.metallic_roughness_texture,
                                material.normal_texture, material.occlusion_texture);
    strata_out_more_textures = uvec4(material.emissive_texture, material.transmission_texture,
                                     floatBitsToUint(material.normal_scale),
                                     floatBitsToUint(material.occlusion_strength));
#endif
}

// What STRATA_FLAT hands on.
void strata_write_frame() {
#ifdef STRATA_FLAT
    strata_flat_eye = strata_eye;
    strata_flat_band = strata_band;
#endif
#ifdef STRATA_FLAT_LIGHTS
    for (int i = 0; i < STRATA_LIGHT_COUNT; ++i) {
        strata_flat_directions[i] = strata_lights[i].direction.xyz;
        strata_flat_colors[i] = strata_lights[i].color.rgb;
    }
#endif
}

void main() {
    StrataRecord record = strata_record_at(STRATA_INSTANCE);
    uint vertex = STRATA_VERTEX;
#ifdef STRATA_HAS_POINTS
    bool splat = (record.flags & STRATA_RECORD_SPLATS) != 0u;
    vec2 corner = vec2(vertex & 1u, (vertex >> 1) & 1u) * 2.0 - 1.0;
    if (splat)
        vertex >>= 2;
#endif
    vec3 world = strata_world_position(record, vertex);
    vec4 clip = strata_project(world);
#ifdef STRATA_HAS_POINTS
    strata_out_disc = splat ? corner : vec2(0.0);
    if (splat)
        strata_expand_splat(record, vertex, corner, world, clip);
#endif
    gl_Position = clip;
    strata_write_frame();
    strata_out_ids =
        uvec4(record.material, record.primitive_base, record.primitive_map, record.flags);
#ifdef STRATA_WANTS_RECORD
    strata_out_record = STRATA_INSTANCE;
#endif
    strata_write_material(strata_material_at(record.material));
    strata_out_position = world;
#ifdef STRATA_HAS_LIT
    strata_write_normal(record, vertex);
#endif
#ifdef STRATA_HAS_TEXTURES
    strata_out_uv = vec4(0.0);
#ifdef STRATA_HAS_UV0
    if ((record.flags & STRATA_RECORD_UV0) != 0u)
        strata_out_uv.xy = STRATA_AT_VEC2(StrataUv0, record.uv0 + vertex);
#endif
#ifdef STRATA_HAS_UV1
    if ((record.flags & STRATA_RECORD_UV1) != 0u)
        strata_out_uv.zw = STRATA_AT_VEC2(StrataUv1, record.uv1 + vertex);
#endif
#endif
#ifdef STRATA_HAS_COLORS
    strata_out_color = (record.flags & STRATA_RECORD_COLORS) != 0u
                           ? STRATA_AT_VEC4(StrataColors, record.color + vertex)
                           : vec4(1.0);
#endif
}
