// SPDX-License-Identifier: MIT
//
// The scene on the GPU as the stages share it: records (one an instance of a mesh), materials,
// flags. Written by host/scene/upload*.c, whose structs mirror these. Parts that a scene does not
// have are not declared. The host defines STRATA_LIGHT_COUNT, and STRATA_HAS_* for what there is:
//   LIT           a material that is shaded         TEXTURES      a material with a texture
//   SRGB, LINEAR  colour, data pages of the atlas   UV0, UV1      texture coordinates
//   COLORS        vertex colours                    TANGENTS      vertex tangents
//   POINTS        splats                            RADII         splats with their own radius
//   MASK          alpha-tested materials            BLEND         materials with coverage below 1
//   EMISSION      emissive materials                TRANSMISSION  materials that let light through
//   SINGLE_SIDED  faces without a back              PRIMITIVE_MAP primitives out of order
//   LOCAL_LIGHTS  points and spots; else all lights are directional
#ifndef STRATA_SCENE_GLSL
#define STRATA_SCENE_GLSL

// StrataRecord.flags
const uint STRATA_RECORD_MIRRORED = 1u;      // the world matrix turns the winding around
const uint STRATA_RECORD_UNLIT = 2u;         // base colour is the colour
const uint STRATA_RECORD_SPLATS = 4u;        // points: four vertices and two triangles each
const uint STRATA_RECORD_NORMALS = 8u;       // streams that the mesh has
const uint STRATA_RECORD_TANGENTS = 16u;
const uint STRATA_RECORD_UV0 = 32u;
const uint STRATA_RECORD_UV1 = 64u;
const uint STRATA_RECORD_COLORS = 128u;
const uint STRATA_RECORD_RADII = 256u;
const uint STRATA_RECORD_DOUBLE_SIDED = 512u;
const uint STRATA_RECORD_MASK = 1024u;       // alpha tested against the material's cutoff
const uint STRATA_RECORD_BLEND = 2048u;      // alpha is coverage; else coverage is 1

const uint STRATA_NO_INDEX = 0xffffffffu;

struct StrataRecord {
    vec4 world[3];       // rows of the object-to-world matrix
    uint material;
    uint primitive_base; // number of the first primitive in the whole scene
    uint primitive_map;  // where its primitives start in StrataPrimitiveMap, or STRATA_NO_INDEX
    uint flags;
    uint position;       // first vertex in each stream; meaningless for streams that it lacks
    uint normal;
    uint tangent;
    uint uv0;
    uint uv1;
    uint color;
    uint radius;
    float scale;         // of lengths: cube root of |determinant|
};

struct StrataMaterial {
    vec4 base_color;
    vec4 emissive;       // rgb; alpha cutoff
    float metallic;
    float roughness;
    float normal_scale;
    float occlusion_strength;
    float f0;            // reflectance of the dielectric at normal incidence
    float transmission;
    uint base_color_texture; // indices into StrataTextures, or STRATA_NO_INDEX
    uint metallic_roughness_texture;
    uint normal_texture;
    uint occlusion_texture;
    uint emissive_texture;
    uint transmission_texture;
};

STRATA_READ(StrataMaterials, StrataMaterial)

StrataMaterial strata_material_at(uint i) {
#ifdef STRATA_TEXELS
    uint at = 20u * i, part = 5u * i;
    vec4 factors = STRATA_AT_VEC4(StrataMaterials, part + 2u);
    StrataMaterial material;
    material.base_color = STRATA_AT_VEC4(StrataMaterials, part);
    material.emissive = STRATA_AT_VEC4(StrataMaterials, part + 1u);
    material.metallic = factors.x;
    material.roughness = factors.y;
    material.normal_scale = factors.z;
    material.occlusion_strength = factors.w;
    material.f0 = STRATA_AT_FLOAT(StrataMaterials, at + 12u);
    material.transmission = STRATA_AT_FLOAT(StrataMaterials, at + 13u);
    material.base_color_texture = STRATA_AT_UINT(StrataMaterials, at + 14u);
    material.metallic_roughness_texture = STRATA_AT_UINT(StrataMaterials, at + 15u);
    material.normal_texture = STRATA_AT_UINT(StrataMaterials, at + 16u);
    material.occlusion_texture = STRATA_AT_UINT(StrataMaterials, at + 17u);
    material.emissive_texture = STRATA_AT_UINT(StrataMaterials, at + 18u);
    material.transmission_texture = STRATA_AT_UINT(StrataMaterials, at + 19u);
    return material;
#else
    return StrataMaterials_at[i];
#endif
}

#endif
