// SPDX-License-Identifier: MIT
//
// Textures from the atlas: every mip level of every image is a rectangle on a page of one of two
// arrays, colour (sRGB) and data (linear). Sampling is written out over texelFetch, so that all
// backends give the same bits: wrap modes, filters, and the level from the derivatives.
#ifndef STRATA_TEXTURE_GLSL
#define STRATA_TEXTURE_GLSL

#include "strata/math.glsl"
#include "strata/scene.glsl"

struct StrataTexture {
    vec4 scale_rotate; // KHR_texture_transform, a row-major 2x2 matrix
    vec2 offset;
    uint size;         // width | height << 16
    uint flags;        // bit 0 second coordinates, 1 magnify linear, 2 minify linear, 3 nearest
                       // level, 4 blended levels, 5-6 wrap u, 7-8 v (0 repeat, 1 mirror, 2 clamp)
    uint levels;       // how many
    uint first_level;  // in StrataTexels
    uint reserved[2];
};

STRATA_READ(StrataTextures, StrataTexture)
STRATA_READ(StrataTexels, uvec2) // x | y << 16, page

StrataTexture strata_texture_at(uint i) {
#ifdef STRATA_TEXELS
    StrataTexture t;
    t.scale_rotate = STRATA_AT_VEC4(StrataTextures, 3u * i);
    t.offset = STRATA_AT_VEC2(StrataTextures, 6u * i + 2u);
    t.size = STRATA_AT_UINT(StrataTextures, 12u * i + 6u);
    t.flags = STRATA_AT_UINT(StrataTextures, 12u * i + 7u);
    t.levels = STRATA_AT_UINT(StrataTextures, 12u * i + 8u);
    t.first_level = STRATA_AT_UINT(StrataTextures, 12u * i + 9u);
    return t;
#else
    return StrataTextures_at[i];
#endif
}

#ifdef STRATA_HAS_SRGB
uniform sampler2DArray strata_atlas_srgb;
#endif
#ifdef STRATA_HAS_LINEAR
uniform sampler2DArray strata_atlas_linear;
#endif

const bool STRATA_SRGB = true;
const bool STRATA_LINEAR = false;

// Both sets of coordinates with their derivatives, which must be taken in uniform control flow.
struct StrataUv {
    vec4 at, dx, dy;
};

vec4 strata_texel(bool srgb, ivec3 texel) {
#ifdef STRATA_HAS_SRGB
    if (srgb)
        return texelFetch(strata_atlas_srgb, texel, 0);
#endif
#ifdef STRATA_HAS_LINEAR
    if (!srgb)
        return texelFetch(strata_atlas_linear, texel, 0);
#endif
    return vec4(1.0);
}

// Brings a coordinate into [0, 1]; texels beyond the edges are found by strata_wrap_texel.
precise float strata_wrap(float u, uint mode) {
    float x = abs(u) <= 1e6 ? u : 0.0; // also NaN
    if (mode == 0u)
        return x - floor(x);
    return mode == 1u ? abs(x - 2.0 * floor(x * 0.5 + 0.5)) : clamp(x, 0.0, 1.0);
}

int strata_wrap_texel(int i, int size, uint mode) {
    if (mode != 0u)
        return clamp(i, 0, size - 1);
    return i < 0 ? i + size : (i >= size ? i - size : i);
}

vec4 strata_filter(StrataTexture t, bool srgb, int level, bool linear, vec2 uv) {
    uint wrap_u = (t.flags >> 5) & 3u, wrap_v = (t.flags >> 7) & 3u;
    ivec2 size = max(ivec2(t.size & 0xffffu, t.size >> 16) >> level, ivec2(1));
    uvec2 place = STRATA_AT_UVEC2(StrataTexels, t.first_level + uint(level));
    ivec2 corner = ivec2(place.x & 0xffffu, place.x >> 16);
    int page = int(place.y);
    precise vec2 at = vec2(strata_wrap(uv.x, wrap_u), strata_wrap(uv.y, wrap_v)) * vec2(size);
    if (!linear) {
        ivec2 i = clamp(ivec2(floor(at)), ivec2(0), size - 1);
        return strata_texel(srgb, ivec3(corner + i, page));
    }
    at -= 0.5;
    precise vec2 base = floor(at);
    precise vec2 f = at - base;
    ivec2 i = ivec2(base);
    int x0 = corner.x + strata_wrap_texel(i.x, size.x, wrap_u);
    int x1 = corner.x + strata_wrap_texel(i.x + 1, size.x, wrap_u);
    int y0 = corner.y + strata_wrap_texel(i.y, size.y, wrap_v);
    int y1 = corner.y + strata_wrap_texel(i.y + 1, size.y, wrap_v);
    vec4 a = strata_texel(srgb, ivec3(x0, y0, page)), b = strata_texel(srgb, ivec3(x1, y0, page));
    vec4 c = strata_texel(srgb, ivec3(x0, y1, page)), d = strata_texel(srgb, ivec3(x1, y1, page));
    return strata_mix(strata_mix(a, b, f.x), strata_mix(c, d, f.x), f.y);
}

// log2 of how many texels a step of one pixel crosses; 0 or less magnifies.
precise float strata_level(StrataTexture t, vec2 dx, vec2 dy) {
    vec2 size = vec2(t.size & 0xffffu, t.size >> 16);
    vec2 x = dx * size, y = dy * size;
    float square = max(strata_dot(x, x), strata_dot(y, y));
    return square > 1.0 ? 0.5 * log2(min(square, 1e20)) : 0.0;
}

precise vec2 strata_transform(StrataTexture t, vec2 uv) {
    return vec2(strata_dot(t.scale_rotate.xy, uv), strata_dot(t.scale_rotate.zw, uv));
}

vec4 strata_sample(uint index, bool srgb, StrataUv uv) {
    StrataTexture t = strata_texture_at(index);
    bool second = (t.flags & 1u) != 0u;
    precise vec2 at = strata_transform(t, second ? uv.at.zw : uv.at.xy) + t.offset;
    vec2 dx = strata_transform(t, second ? uv.dx.zw : uv.dx.xy);
    vec2 dy = strata_transform(t, second ? uv.dy.zw : uv.dy.xy);
    float level = strata_level(t, dx, dy);
    if (!(level > 0.0))
        return strata_filter(t, srgb, 0, (t.flags & 2u) != 0u, at);
    bool linear = (t.flags & 4u) != 0u;
    int last = int(t.levels) - 1;
    if ((t.flags & 16u) == 0u) {
        int nearest = (t.flags & 8u) != 0u ? min(int(level + 0.5), last) : 0;
        return strata_filter(t, srgb, nearest, linear, at);
    }
    precise float within = min(level, float(last));
    int fine = int(within);
    precise float f = within - float(fine);
    vec4 a = strata_filter(t, srgb, fine, linear, at);
    if (f == 0.0)
        return a;
    return strata_mix(a, strata_filter(t, srgb, min(fine + 1, last), linear, at), f);
}

#endif
