// SPDX-License-Identifier: MIT
//
// Colour attachments that a fragment shader reads and replaces, one fragment of a pixel after the other,
// in primitive order (strata_attachment.read). A source declares each of them, by its number:
//     STRATA_ORDERED_UINT(0)
//     STRATA_ORDERED_FLOAT(1)
// and in main(), as uvec4 or vec4 whatever the format has of it:
//     uvec4 before = STRATA_ORDERED_LOAD(0);
//     STRATA_ORDERED_STORE(0, after);
// Each that is declared is loaded somewhere, and every fragment that is not discarded stores to it.
#ifndef STRATA_ORDERED_GLSL
#define STRATA_ORDERED_GLSL

#ifdef VULKAN
#define STRATA_ORDERED_UINT(n)                                                                     \
    layout(input_attachment_index = n) uniform usubpassInput strata_before_##n;                    \
    layout(location = n) out uvec4 strata_ordered_##n;
#define STRATA_ORDERED_FLOAT(n)                                                                    \
    layout(input_attachment_index = n) uniform subpassInput strata_before_##n;                     \
    layout(location = n) out vec4 strata_ordered_##n;
#define STRATA_ORDERED_LOAD(n) subpassLoad(strata_before_##n)
#else // SPIR-V for OpenGL cannot say inout; the backend does, by the name
#define STRATA_ORDERED_UINT(n) layout(location = n) out uvec4 strata_ordered_##n;
#define STRATA_ORDERED_FLOAT(n) layout(location = n) out vec4 strata_ordered_##n;
#define STRATA_ORDERED_LOAD(n) strata_ordered_##n
#endif
#define STRATA_ORDERED_STORE(n, value) strata_ordered_##n = (value)

#endif
