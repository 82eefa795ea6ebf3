/* SPDX-License-Identifier: MIT
 *
 * One line of text to a procedural scene, for tests.
 */
#ifndef STRATA_TESTS_GENERATED_H
#define STRATA_TESTS_GENERATED_H

#include "scene/scene.h"

/* "NAME KNOB=VALUE ..."; fails the running test when that is not a scene. */
scene *generated(const char *text);

#endif
