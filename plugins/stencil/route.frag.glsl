// SPDX-License-Identifier: MIT
//
// stencil, once a layer: which fragments are routed. One that is hidden, or that does not exist, leaves
// by discard and does not touch the stencil, so that layers hold visible fragments only. A depth test
// could not see to that: a fragment that fails the stencil test moves the stencil whatever its depth.
// Tests are late for that reason; so nothing but the attachment is written here.
#include "strata/shading.glsl"

uniform sampler2D limit_image;
layout(location = 0) out uvec4 routed; // of which the pass writes the channel of its layer

void main() {
    bool covered = strata_covered();
    if (!covered || gl_FragCoord.z < texelFetch(limit_image, ivec2(gl_FragCoord.xy), 0).r)
        discard;
    routed = uvec4(strata_primitive() + 1u);
}
