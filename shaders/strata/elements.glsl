// SPDX-License-Identifier: MIT
//
// Records of fragments/1 as elements (C, T), for deep images: one invocation a record, run by the host.
#define STRATA_PAYLOAD_READ
#include "strata/fold.glsl"
#include "strata/scan.glsl"

layout(std430) writeonly buffer StrataElements { vec4 strata_elements[]; }; // C, T: two a record
STRATA_PARAMS { uint first; uint count; } params;

void main() {
    uint item = strata_item();
    if (item >= params.count)
        return;
    StrataElement element = strata_event(strata_payload_load(params.first + item));
    strata_elements[2u * item] = element.color;
    strata_elements[2u * item + 1u] = strata_transmittance4(element);
}
