// SPDX-License-Identifier: MIT
//
// kplus, k per pixel, after the capture: where the fragments that were dropped may change a pixel by more
// than the tolerance, it keeps more when the frame is recorded again. What decides is the
// certificate's own bound of truncation (strata/bound.glsl) behind what the kept fragments let through.
// That is their product in any order, so it is summed as integers: the same k for every order of arrival.
#define STRATA_PAYLOAD_READ
#define MORE_PARAMS float truncation; // the most that dropped fragments may change a pixel
#include "slots.glsl"
#include "strata/tiles.glsl"
#include "strata/loss.glsl"
#include "strata/fold.glsl"
#include "strata/pool.glsl"

layout(std430) readonly buffer Events { uint events; };
layout(std430) buffer Nearest { uint nearest[]; };
layout(std430) buffer Grown { uint grown_pixels; uint grown_records; };
uniform sampler2D behind_image;

// exp(-x): its series at x / 256, squared eight times.
vec4 passing(vec4 x) {
    vec4 r = min(x, 128.0) * (1.0 / 256.0);
    precise vec4 p = 1.0 - r * (1.0 - r * (0.5 - r * (1.0 / 6.0 - r * (1.0 / 24.0))));
    for (int i = 0; i < 8; ++i)
        p = p * p;
    return p;
}

// How many more the pixel needs; 0: what it keeps suffices. Were those behind like those it keeps, so many
// would bring the bound down to the tolerance; at most twice as many are kept at once.
uint wanted(uint pixel, uvec2 slots) {
    uvec4 units = uvec4(0u);
    for (uint i = 0u; i < slots.y; ++i) {
        StrataWithin within;
        StrataElement element = strata_event_within(strata_payload_load(slots.x + i), within);
        vec4 hides = clamp(1.0 - strata_transmittance4(element), 0.0, 1.0);
        for (uint c = 0u; c < 4u; ++c)
            units[c] = strata_add(units[c], uint(strata_thickness(hides[c]) * 16777216.0));
    }
    vec4 thick = vec4(units) * (1.0 / 16777216.0);
    vec4 behind = texelFetch(behind_image, ivec2(strata_position(pixel)), 0);
    vec4 off = passing(thick) * strata_lost(pixel, behind);
    float kept = float(slots.y), more = 0.0;
    for (uint c = 0u; c < 4u; ++c)
        if (!(off[c] <= params.truncation)) {
            float over = strata_thickness(1.0 - params.truncation / min(off[c], 1e30));
            more = max(more, min(over * kept, 1e30) / max(thick[c], 1e-30));
        }
    return uint(ceil(min(more, kept)));
}

void main() {
    uint pixel = strata_item();
    // What a pool that is too small, a lock that failed or a tie left there says nothing.
    if (pixel >= strata_pixel_count() || strata_pool_short() || events != 0u)
        return;
    uvec2 position = strata_position(pixel), slots = slots_of(position);
    uint count = strata_count_at(pixel), at = position.y * strata_frame_size.x + position.x;
    if (count <= slots.y || slots.y >= params.k)
        return;
    uint more = min(wanted(pixel, slots), min(count, params.k) - slots.y);
    if (more == 0u)
        return;
    nearest[at] = slots.y + more;
    atomicAdd(grown_pixels, 1u);
    atomicAdd(grown_records, more);
}
