// SPDX-License-Identifier: MIT
//
// What a fragment of the scene is: whether it exists, its number, and its surface shaded by glTF's
// metallic-roughness model. Opaque shading and transparent capture call the same functions, at the
// start of main() (derivatives are taken inside); a stage that shades few of its fragments takes
// strata_slopes() there and the rest later.
#ifndef STRATA_SHADING_GLSL
#define STRATA_SHADING_GLSL

#include "strata/frame.glsl"
#include "strata/math.glsl"
#include "strata/scene.glsl"
#include "strata/surface.glsl"

layout(location = 0) flat in uvec4 strata_in_ids;
layout(location = 1) flat in vec4 strata_in_base_color;
layout(location = 2) in vec3 strata_in_position;
#ifdef STRATA_HAS_LIT
layout(location = 3) in vec3 strata_in_normal;
#ifdef STRATA_HAS_TANGENTS
layout(location = 4) in vec4 strata_in_tangent;
#endif
#endif
#ifdef STRATA_HAS_TEXTURES
#include "strata/texture.glsl"
layout(location = 5) in vec4 strata_in_uv;
StrataUv strata_uv() { return StrataUv(strata_in_uv, dFdx(strata_in_uv), dFdy(strata_in_uv)); }
#else
struct StrataUv {
    float none;
};
const bool STRATA_SRGB = true;
const bool STRATA_LINEAR = false;
StrataUv strata_uv() { return StrataUv(0.0); }
#endif
struct StrataSlopes {
    StrataUv uv;
#if defined(STRATA_HAS_LIT) && defined(STRATA_HAS_TEXTURES)
    vec3 dx, dy; // of the position in the world
#endif
};
#ifdef STRATA_HAS_COLORS
layout(location = 6) in vec4 strata_in_color;
#endif
#ifdef STRATA_HAS_POINTS
layout(location = 7) in vec2 strata_in_disc;
#endif
#ifdef STRATA_HAS_LIT
layout(location = 8) flat in vec4 strata_in_reflection;
#endif
#if defined(STRATA_HAS_EMISSION) || defined(STRATA_HAS_MASK)
layout(location = 9) flat in vec4 strata_in_emissive;
#endif
#ifdef STRATA_HAS_TEXTURES
layout(location = 10) flat in uvec4 strata_in_textures;
layout(location = 11) flat in uvec4 strata_in_more_textures;
#else
const uvec4 strata_in_textures = uvec4(STRATA_NO_INDEX);
const uvec4 strata_in_more_textures = uvec4(STRATA_NO_INDEX, STRATA_NO_INDEX, 0u, 0u);
#endif
#ifdef STRATA_WANTS_RECORD // a program that defines it has the record's number
layout(location = 12) flat in uint strata_in_record;
#endif
#ifdef STRATA_HAS_PRIMITIVE_MAP
STRATA_READ(StrataPrimitiveMap, uint)
#endif

bool strata_is(uint flag) { return (strata_in_ids.w & flag) != 0u; }

// NaN and infinities become zero, bit by bit: no compiler may assume that they do not occur.
float strata_finite(float x) {
    return (floatBitsToUint(x) & 0x7f800000u) == 0x7f800000u ? 0.0 : x;
}
vec3 strata_finite(vec3 v) {
    return vec3(strata_finite(v.x), strata_finite(v.y), strata_finite(v.z));
}

uint strata_primitive() {
    uint id = uint(gl_PrimitiveID);
#ifdef STRATA_HAS_POINTS
    if (strata_is(STRATA_RECORD_SPLATS))
        id >>= 1;
#endif
#ifdef STRATA_HAS_PRIMITIVE_MAP
    if (strata_in_ids.z != STRATA_NO_INDEX)
        id = STRATA_AT_UINT(StrataPrimitiveMap, strata_in_ids.z + id);
#endif
    return strata_in_ids.y + id;
}

// The side that glTF calls the front is seen.
bool strata_front() { return gl_FrontFacing != strata_is(STRATA_RECORD_MIRRORED); }

// Samples one of a material's textures; white where there is none.
vec4 strata_textured(uint index, bool srgb, StrataUv uv) {
#ifdef STRATA_HAS_TEXTURES
    if (index != STRATA_NO_INDEX)
        return strata_sample(index, srgb, uv);
#endif
    return vec4(1.0);
}

// Factor, vertex colour and texture. Precise: alpha tests in different programs must agree.
precise vec4 strata_base_color(StrataUv uv) {
    vec4 color = strata_in_base_color;
#ifdef STRATA_HAS_COLORS
    color *= strata_in_color;
#endif
    return color * strata_textured(strata_in_textures.x, STRATA_SRGB, uv);
}

// Whether the fragment exists, given its alpha: discs of splats, faces without a back, alpha tests.
bool strata_exists(float alpha) {
    bool exists = true;
#ifdef STRATA_HAS_POINTS
    exists = strata_dot(strata_in_disc, strata_in_disc) <= 1.0;
#endif
#ifdef STRATA_HAS_SINGLE_SIDED
    exists = exists && (strata_is(STRATA_RECORD_DOUBLE_SIDED) || strata_front());
#endif
#ifdef STRATA_HAS_MASK
    if (strata_is(STRATA_RECORD_MASK))
        exists = exists && alpha >= strata_in_emissive.w;
#endif
    return exists;
}

// strata_surface()'s answer without the shading.
bool strata_covered() {
    float alpha = 1.0;
#ifdef STRATA_HAS_MASK
    alpha = strata_base_color(strata_uv()).a;
#endif
    return strata_exists(alpha);
}

#ifdef STRATA_HAS_LIT
#include "strata/lighting.glsl"
#endif

precise vec3 strata_emission(StrataUv uv) {
#ifdef STRATA_HAS_EMISSION
    if (!strata_is(STRATA_RECORD_UNLIT))
        return strata_in_emissive.rgb *
               strata_textured(strata_in_more_textures.x, STRATA_SRGB, uv).rgb;
#endif
    return vec3(0.0);
}

// All that shading takes across the screen, in uniform control flow.
StrataSlopes strata_slopes() {
#if defined(STRATA_HAS_LIT) && defined(STRATA_HAS_TEXTURES)
    return StrataSlopes(strata_uv(), dFdx(strata_in_position), dFdy(strata_in_position));
#else
    return StrataSlopes(strata_uv());
#endif
}

// False when the fragment does not exist; the surface is complete all the same.
bool strata_surface(StrataSlopes slopes, out StrataSurface surface) {
    StrataUv uv = slopes.uv;
    vec4 base = strata_base_color(uv);
    surface.color = base.rgb;
    surface.alpha = 1.0;
    surface.transmission = 0.0;
    surface.tint = vec3(0.0);
    surface.primitive = strata_primitive();
    surface.material = strata_in_ids.x;
    surface.position = strata_in_position;
    surface.normal = vec3(0.0);
#ifdef STRATA_HAS_BLEND
    if (strata_is(STRATA_RECORD_BLEND))
        surface.alpha = clamp(strata_finite(base.a), 0.0, 1.0);
#endif
#ifdef STRATA_HAS_LIT
    if (strata_is(STRATA_RECORD_NORMALS)) {
        vec3 view = strata_towards_eye();
        surface.normal = strata_shading_normal(slopes, view);
        if (!strata_is(STRATA_RECORD_UNLIT))
            strata_shade(base.rgb, uv, view, surface);
    }
#endif
    precise vec3 color = surface.color + strata_emission(uv);
    surface.color = strata_finite(color);
    surface.tint = strata_finite(surface.tint);
    return strata_exists(base.a);
}

bool strata_surface(out StrataSurface surface) { return strata_surface(strata_slopes(), surface); }

#endif
