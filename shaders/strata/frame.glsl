// SPDX-License-Identifier: MIT
//
// The frame as every shader sees it: camera, image, and the band that is being rendered. Filled by
// the host (struct render_frame_block in host/render); bound by it under this name.
#ifndef STRATA_FRAME_GLSL
#define STRATA_FRAME_GLSL

layout(std140) uniform StrataFrame {
    mat4 strata_world_to_clip; // reversed depth: near 1, far 0
    mat4 strata_world_to_eye;
    mat4 strata_clip_to_world;
    vec4 strata_eye;           // world position, w = 1; orthographic: direction towards the eye, w = 0
    vec4 strata_background;    // linear, premultiplied
    uvec4 strata_frame_size;   // width, height in sub-pixels; samples a pixel; frame index
    uvec4 strata_band;         // x, y, width, height of the band in sub-pixels
    uvec4 strata_counts;       // lights, materials, records, textures
};

// Software rasterisers take words of a uniform block lane by lane, and a flat input at once: there the
// vertex stage hands on what most fragments read of the frame.
#ifdef STRATA_FLAT
#ifdef STRATA_STAGE_VERTEX
#define STRATA_VARYING out
#else
#define STRATA_VARYING in
#endif
layout(location = 13) flat STRATA_VARYING vec4 strata_flat_eye;
layout(location = 14) flat STRATA_VARYING uvec4 strata_flat_band;
#endif

// strata_eye and strata_band, the cheaper way.
#if defined(STRATA_FLAT) && defined(STRATA_STAGE_FRAGMENT)
vec4 strata_frame_eye() { return strata_flat_eye; }
uvec4 strata_frame_band() { return strata_flat_band; }
#else
vec4 strata_frame_eye() { return strata_eye; }
uvec4 strata_frame_band() { return strata_band; }
#endif

// Index of a pixel within the band, row by row: where its range in fragments/1 stands.
uint strata_pixel(uvec2 position) {
    uvec4 band = strata_frame_band();
    uvec2 p = position - band.xy;
    return p.y * band.z + p.x;
}

uint strata_pixel_count() { return strata_band.z * strata_band.w; }

uvec2 strata_position(uint pixel) {
    return strata_band.xy + uvec2(pixel % strata_band.z, pixel / strata_band.z);
}

#endif
