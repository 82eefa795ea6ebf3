// SPDX-License-Identifier: MIT
//
// kplus, k per pixel, before a frame: pixels begin anew unless scene, view and light are those of the last frame,
// so that what a frame shows never depends on another view. One work group compares (COMPARE), then
// all pixels follow.
#include "strata/frame.glsl"
#include "strata/scan.glsl"

layout(std430) buffer Seen { uint seen_anew; uint seen[38]; };
STRATA_PARAMS { uint begin; uint anew; uint revision_low; uint revision_high; } params;

#ifdef COMPARE
#ifdef STRATA_LIGHT_COUNT
layout(std140) uniform StrataLights { vec4 first_light[4]; }; // of a scene without any: the camera's
#endif

uint word(uint i) {
    if (i < 16u)
        return floatBitsToUint(strata_world_to_clip[i / 4u][i % 4u]);
    if (i < 20u)
        return floatBitsToUint(strata_background[i - 16u]);
    if (i < 22u)
        return i == 20u ? params.revision_low : params.revision_high;
#ifdef STRATA_LIGHT_COUNT
    return floatBitsToUint(first_light[(i - 22u) / 4u][(i - 22u) % 4u]);
#else
    return 0u;
#endif
}

void main() {
    if (strata_item() > 0u)
        return;
    bool anew = params.anew != 0u;
    for (uint i = 0u; i < 38u; ++i) {
        anew = anew || seen[i] != word(i);
        seen[i] = word(i);
    }
    seen_anew = uint(anew);
}
#else
layout(std430) writeonly buffer Nearest { uint nearest[]; };

void main() {
    uint at = strata_item();
    if (seen_anew != 0u && at < strata_frame_size.x * strata_frame_size.y)
        nearest[at] = params.begin;
}
#endif
