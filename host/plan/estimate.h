/* SPDX-License-Identifier: MIT
 *
 * A quick estimate, on the CPU, of how deep the transparent parts of a scene are in one view:
 * projected triangle areas, clipped to the image, summed over a coarse grid. It fills
 * strata_scene_stats, which the plan and the techniques' memory estimates read before anything
 * was drawn. Deterministic: the same scene and view give the same bits.
 */
#ifndef STRATA_HOST_ESTIMATE_H
#define STRATA_HOST_ESTIMATE_H

#include "scene/scene.h"
#include "strata/scene.h"

/* Triangles and splats evaluated at most; larger scenes are sampled evenly and scaled. */
#define ESTIMATE_MAX_SAMPLES 200000u

typedef struct estimate_view {
    float world_to_clip[16]; /* column-major, depth 1 near .. 0 far */
    uint32_t width, height;  /* of the sub-pixel grid, > 0 */
} estimate_view;

/* transparent: one byte a material, 1 = drawn with draws.transparent (plan_transparent_materials).
 * Materials without visible triangles count for nothing. Occlusion by opaque surfaces is not
 * considered: the estimate is an upper one. */
strata_result estimate_stats(const scene *s, const estimate_view *view,
                             const unsigned char *transparent, strata_scene_stats *out,
                             base_error *err);

/* Opaque objects, and how much of them nobody sees: hidden_triangles, outside_triangles and
 * opaque_overdraw. A few thousand samples; 0 for scenes of few objects. Called by estimate_stats.
 */
strata_result estimate_hidden(const scene *s, const estimate_view *view,
                              const unsigned char *transparent, strata_scene_stats *stats,
                              base_error *err);

#endif
