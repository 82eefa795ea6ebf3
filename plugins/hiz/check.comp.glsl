// SPDX-License-Identifier: MIT
//
// hiz.certify: holds the certificate of each object that is said to be hidden against every pixel of the
// final depth that it speaks of, `slices` work groups an object: drivers bound an invocation's loops.
// Uses nothing of the pyramid.
#define HIZ_CERTIFICATES readonly
#include "strata/frame.glsl"
#include "strata/objects.glsl"
#include "strata/scan.glsl"
#include "certificates.glsl"

uniform sampler2D depth_image;
layout(std430) buffer Checked { uint checked, broken; };
STRATA_PARAMS { uint count, slices; } params;

void main() {
    uint group = gl_WorkGroupID.y * STRATA_GROUP_ROW + gl_WorkGroupID.x;
    uint item = group / params.slices, slice = group % params.slices;
    if (item >= params.count || strata_object_states[item] != STRATA_OCCLUDED)
        return;
    Certificate c = certificates[item];
    uvec2 size = c.last - c.first + 1u;
    bool holds = c.nearest < c.farthest && all(lessThanEqual(c.first, c.last)) &&
                 all(lessThan(c.last, strata_frame_size.xy));
    uint step = STRATA_GROUP * params.slices;
    for (uint i = slice * STRATA_GROUP + gl_LocalInvocationID.x; holds && i < size.x * size.y;
         i += step) {
        uvec2 p = c.first + uvec2(i % size.x, i / size.x);
        holds = c.nearest < texelFetch(depth_image, ivec2(p), 0).r;
    }
    if (!holds)
        atomicAdd(broken, 1u);
    if (slice == 0u && gl_LocalInvocationID.x == 0u)
        atomicAdd(checked, 1u);
}
