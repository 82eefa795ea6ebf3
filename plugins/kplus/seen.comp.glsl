// SPDX-License-Identifier: MIT
//
// kplus, k per pixel, before a frame: pixels begin anew unless scene and view are those of the last frame,
// so that what a frame shows never depends on another view. One work group compares (COMPARE), then
// all pixels follow.
#include "strata/frame.glsl"
#include "strata/scan.glsl"

layout(std430) buffer Seen { uint seen_anew; uint seen[22]; };
STRATA_PARAMS { uint begin; uint anew; uint revision_low; uint revision_high; } params;

#ifdef COMPARE
uint word(uint i) {
    if (i < 16u)
        return floatBitsToUint(strata_world_to_clip[i / 4u][i % 4u]);
    return i < 20u ? floatBitsToUint(strata_background[i - 16u])
                   : i == 20u ? params.revision_low : params.revision_high;
}

void main() {
    if (strata_item() > 0u)
        return;
    bool anew = params.anew != 0u;
    for (uint i = 0u; i < 22u; ++i) {
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
