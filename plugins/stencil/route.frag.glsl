// SPDX-License-Identifier: MIT
//
// stencil, once a layer or once for the samples of a batch: which fragments are routed.
//
// ALL: every one; so the stencil test comes before the shader. Right where none is hidden and all exist.
//
// Else one that is hidden, or that does not exist, leaves by discard and does not touch the stencil, so
// that layers hold visible fragments only. A depth test could not see to that: a fragment that fails the
// stencil test moves the stencil whatever its depth. Tests are late then; so nothing but the attachment
// is written here.
#include "strata/shading.glsl"

#ifdef SAMPLES
#define LAYER(number) unpackUnorm4x8(number)
layout(location = 0) out vec4 routed; // into the sample that the stencil lets through
#else
#define LAYER(number) uvec4(number)
layout(location = 0) out uvec4 routed; // of which the pass writes the channel of its layer
#endif

#ifdef ALL
layout(early_fragment_tests) in;

void main() { routed = LAYER(strata_primitive() + 1u); }
#else
uniform sampler2D limit_image;

void main() {
    bool covered = strata_covered();
    if (!covered || gl_FragCoord.z < texelFetch(limit_image, ivec2(gl_FragCoord.xy), 0).r)
        discard;
    routed = LAYER(strata_primitive() + 1u);
}
#endif
