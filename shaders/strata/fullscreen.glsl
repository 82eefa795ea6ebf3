// SPDX-License-Identifier: MIT
//
// Vertex stage of full-screen passes: one triangle that covers the target, counter-clockwise, at the
// far plane. Three vertices without any input; STRATA_CORNER places those of the host's self-tests.
#ifndef STRATA_FULLSCREEN_GLSL
#define STRATA_FULLSCREEN_GLSL

#ifndef STRATA_CORNER
#define STRATA_CORNER(v) vec2(v % 3u == 1u ? 3.0 : -1.0, v % 3u == 2u ? 3.0 : -1.0)
#endif

void main() { gl_Position = vec4(STRATA_CORNER(STRATA_VERTEX), 0.0, 1.0); }

#endif
