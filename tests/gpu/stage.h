/* SPDX-License-Identifier: MIT
 *
 * Small scenes for the GPU tests, seen by an orthographic camera for which world x and y in
 * [-1, 1] fill the image and z grows towards the eye. Failing allocations end the test.
 */
#ifndef STRATA_TESTS_GPU_STAGE_H
#define STRATA_TESTS_GPU_STAGE_H

#include "gpu/drawing.h"
#include "scene/scene_internal.h"

typedef struct stage {
    scene *s;
    size_t meshes, instances, materials, images;
} stage;

stage stage_new(void);
/* Double-sided, unlit, of that colour. */
uint32_t stage_material(stage *t, float r, float g, float b);
/* A rectangle that faces the eye, with uv (0, 0) at its upper left; its instance. */
uint32_t stage_quad(stage *t, uint32_t material, float x0, float y0, float x1, float y1, float z);
uint32_t stage_points(stage *t, uint32_t material, const float *positions, const float *radii,
                      uint32_t count);
uint32_t stage_image(stage *t, uint32_t width, uint32_t height, const unsigned char *pixels);
/* scene_finish, and normals as they are. */
void stage_finish(stage *t);

extern const char *const stage_backends[2];

/* NULL (after saying why) when the backend cannot be opened. Driver validation is on. */
gpu *stage_open(const char *backend);
/* Fails the test with the error's line when anything fails. */
drawing stage_draw(gpu *g, const scene *s, drawing_options options);
const float *stage_pixel(const drawing *d, uint32_t x, uint32_t y); /* y 0 = bottom */
/* Same bits in colour and depth. */
int stage_same(const drawing *a, const drawing *b);

#endif
