/* SPDX-License-Identifier: MIT
 *
 * Draws a scene without plan or modules: upload, a camera, the passes of plugins/surface. For tests
 * of what host/scene/upload.h and shaders/strata promise.
 */
#ifndef STRATA_TESTS_GPU_DRAWING_H
#define STRATA_TESTS_GPU_DRAWING_H

#include "gpu/gpu.h"
#include "scene/upload.h"

typedef struct drawing {
    gpu *g;
    gpu_scope *scope;
    upload *u;
    uint32_t width, height, exact;
    strata_image color, depth, winners;
    strata_buffer frame;
    strata_program programs[3]; /* nearest, winner, surface */
    float *pixels;              /* [height][width][4], row 0 = bottom */
    float *depths;              /* [height][width] */
} drawing;

typedef struct drawing_options {
    const char *camera, *slot; /* NULL: "draws.opaque/1" */
    uint32_t width, height, seed, exact, samples;
    uint32_t round; /* not 0: over what was drawn before */
} drawing_options;

/* The device stays open between drawings. 0 = failed, err says why. */
int drawing_make(drawing *d, gpu *g, const scene *s, const drawing_options *options,
                 base_error *err);
/* Draws with the scene as it is, after upload_update. */
int drawing_draw(drawing *d, const scene *s, const drawing_options *options, base_error *err);
void drawing_free(drawing *d);
int drawing_save(const drawing *d, const char *path);

#endif
