// SPDX-License-Identifier: MIT
//
// Vertex stage of full-screen passes: one triangle that covers the target, counter-clockwise, at the
// far plane. Three vertices without any input.
#ifndef STRATA_FULLSCREEN_GLSL
#define STRATA_FULLSCREEN_GLSL

void main() {
    uint corner = STRATA_VERTEX % 3u;
    gl_Position = vec4(corner == 1u ? 3.0 : -1.0, corner == 2u ? 3.0 : -1.0, 0.0, 1.0);
}

#endif
