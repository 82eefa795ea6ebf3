// SPDX-License-Identifier: MIT
//
// hiz: where an object may land in the image, never less than where its vertices do.
//
// A vertex is exact up to 8 roundings of the magnitudes that add up in the two matrices (4 each), and
// so are the corners of the box; clipping adds a few. MARGIN roundings cover both. Perspective keeps
// the vertices within the corners' hull as long as every w is positive.
#ifndef HIZ_EXTENT_GLSL
#define HIZ_EXTENT_GLSL

#include "strata/transform.glsl"

const float ROUNDING = 1.1920929e-7; // 2^-23: of one operation, to nearest or not
const float MARGIN = 24.0;
const float SNAP = 1.0 / 128.0;      // pixels: vertices are snapped to 1/256 of one
const float DEPTH_ULPS = 4.0;        // interpolation of depth within a triangle

struct Extent {
    bool outside;      // no part of it is in the view
    bool near;         // it may reach the near plane: what follows is meaningless
    ivec2 first, last; // pixels whose centres it may cover; first > last: none
    float nearest;     // its largest depth (reversed), from above
};

Extent extent_of(StrataRecord record, vec3 lower, vec3 upper) {
    vec3 reach = max(abs(lower), abs(upper)), world;
    for (int i = 0; i < 3; ++i)
        world[i] = dot(abs(record.world[i].xyz), reach) + abs(record.world[i].w);
    vec4 margin = abs(strata_world_to_clip[0]) * world.x + abs(strata_world_to_clip[1]) * world.y +
                  abs(strata_world_to_clip[2]) * world.z + abs(strata_world_to_clip[3]);
    margin *= MARGIN * ROUNDING;

    const float HUGE = 3.0e38;
    vec4 inside = vec4(-HUGE); // most that a corner lies within the left, right, lower, upper plane
    float before_near = -HUGE, behind_near = -HUGE, farthest = -HUGE, least_w = HUGE;
    vec3 low = vec3(HUGE), high = vec3(-HUGE);
    bool finite = true;
    for (uint i = 0u; i < 8u; ++i) {
        vec3 corner = mix(lower, upper, notEqual(uvec3(i) & uvec3(1u, 2u, 4u), uvec3(0u)));
        vec4 clip = strata_project(strata_to_world(record, corner));
        inside = max(inside, clip.w + vec4(clip.x, -clip.x, clip.y, -clip.y));
        before_near = max(before_near, clip.z - clip.w);
        behind_near = max(behind_near, clip.w - clip.z);
        farthest = max(farthest, clip.z);
        least_w = min(least_w, clip.w);
        finite = finite && all(lessThan(abs(clip), vec4(HUGE)));
        vec3 ndc = clip.xyz / clip.w;
        low = min(low, ndc);
        high = max(high, ndc);
    }
    Extent e;
    e.outside = finite && (any(lessThan(inside, -vec4(margin.xx, margin.yy) - margin.w)) ||
                           behind_near < -margin.z - margin.w || farthest < -margin.z);
    float w = least_w - margin.w;
    e.near = !finite || !(w > margin.w) || !(before_near < -margin.z - margin.w);

    vec2 size = vec2(strata_frame_size.xy), slack = SNAP + size * (8.0 * ROUNDING);
    vec2 from = low.xy - (margin.xy + margin.w * abs(low.xy)) / w;
    vec2 to = high.xy + (margin.xy + margin.w * abs(high.xy)) / w;
    from = clamp((from * 0.5 + 0.5) * size - slack, vec2(-1.0), size + 1.0);
    to = clamp((to * 0.5 + 0.5) * size + slack, vec2(-1.0), size + 1.0);
    e.first = max(ivec2(ceil(from - 0.5)), ivec2(0));
    e.last = min(ivec2(floor(to - 0.5)), ivec2(strata_frame_size.xy) - 1);
    e.nearest = high.z + (margin.z + margin.w * abs(high.z)) / w;
    e.nearest += abs(e.nearest) * (DEPTH_ULPS * ROUNDING);
    return e;
}

#endif
