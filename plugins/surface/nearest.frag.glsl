// SPDX-License-Identifier: MIT
//
// surface, ties=exact, pass 1: depth alone. Where a fragment is strictly nearer than what an earlier
// round drew, that round's winner no longer counts.
#include "strata/shading.glsl"

layout(location = 0) out uint winner;

void main() {
    if (!strata_covered())
        discard;
    winner = 0u;
}
