/* SPDX-License-Identifier: MIT
 *
 * How much a mesh's transparent material hides: for estimates of what fragments behind others can
 * still add. Factors, vertex colours and textures are read, a few hundred samples of each; effects
 * and lights are not.
 */
#ifndef STRATA_HOST_OPACITY_H
#define STRATA_HOST_OPACITY_H

#include "scene/scene.h"

/* Mean of -ln(transmittance) of its fragments, of the channel that lets most through: 0 hides
 * nothing, at most 17 (alpha = 1 - 2^-24). */
double opacity_optical_depth(const scene *s, const scene_mesh *mesh);

#endif
