/* SPDX-License-Identifier: MIT
 *
 * Shared by the tests of scene loading: load a built GLB or fail the test, compare floats, look for
 * warnings. Include after the cmocka headers.
 */
#ifndef STRATA_TESTS_SCENE_FIXTURE_H
#define STRATA_TESTS_SCENE_FIXTURE_H

#include "scene/scene.h"
#include "scenes/glb.h"

/* Loads what g describes; g is emptied. The test fails with the loader's line when it is refused.
 */
scene *load_glb(test_glb *g);

/* Four corners of the unit square, and the same with one mesh and one node made of them:
 * accessor 0 = POSITION, mode as given (5: strip). attributes: further ones with a leading comma.
 */
void add_square(test_glb *g);
void add_square_scene(test_glb *g, int mode, const char *attributes);

/* Each value within 1e-6 of what is expected, relative above 1. */
void expect_floats(const float *actual, const float *expected, size_t count);
void expect_indices(const scene_mesh *mesh, const uint32_t *expected, size_t count);

/* Some warning contains `part`; with NULL: there is none at all. */
void expect_warning(const scene *s, const char *part);

/* Loading g fails with BAD_FILE, and the line begins with the name and contains `part`. */
void expect_refused(test_glb *g, const char *part);

#endif
