/* SPDX-License-Identifier: MIT
 *
 * strata/scene.h - what a technique learns of the scene: counts and estimates. Geometry and
 * materials themselves are bound by the host to programs that include shaders/strata.
 */
#ifndef STRATA_SCENE_H
#define STRATA_SCENE_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Counts over visible instances and estimates for the current camera and image size. */
typedef struct strata_scene_stats {
    uint32_t struct_size;
    uint32_t width, height;             /* of the sub-pixel grid the estimates are for */
    uint32_t instances, materials, lights;
    uint64_t opaque_draws, transparent_draws;
    uint64_t opaque_triangles, transparent_triangles; /* a splat counts as two */
    double transparent_fragments;  /* estimate: projected areas, clipped to the image, summed */
    double covered_pixels;         /* estimate: pixels with at least one transparent fragment */
    double mean_depth;             /* transparent_fragments / covered_pixels, 0 when none */
    double largest_depth;          /* estimate: most fragments in one pixel */
    uint64_t opaque_objects;       /* that can be culled one by one: instances, and clusters of large meshes */
    double hidden_triangles;       /* estimate: opaque ones of objects that others hide; 0 for few objects */
    double outside_triangles;      /* estimate: opaque ones of objects outside of the view; likewise */
    double opaque_overdraw;        /* estimate: fragments that opaque triangles, drawn in no order, shade
                                      beyond the first of a pixel; likewise */
    double mean_optical_depth;     /* estimate: mean of -ln(transmittance) of a transparent fragment; 0 when none */
} strata_scene_stats;

#ifdef __cplusplus
}
#endif
#endif
