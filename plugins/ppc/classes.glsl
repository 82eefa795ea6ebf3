// SPDX-License-Identifier: MIT
//
// ppc: the classes of pixels, and how the fold of the deep ones is cut up.
#include "strata/classes.glsl"

#define WALK_CHUNK 32768u // fragments that one invocation folds: well below drivers' loop budgets
#ifdef STRATA_BOUND
#define WALK_STATE 8u // pairs of floats that a fold's state takes
#else
#define WALK_STATE 4u
#endif
