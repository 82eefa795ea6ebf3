/* SPDX-License-Identifier: MIT
 *
 * Sub-pixels to pixels: image/1 from color/1 with box, tent or Gaussian weights and, where a
 * certificate is asked for, image.bound/1 from bound/1 with the same. Compiled into each module
 * that fills image/1; the GLSL is shaders/strata/filter.comp.glsl.
 */
#ifndef STRATA_SHARED_FILTERING_H
#define STRATA_SHARED_FILTERING_H

#include "strata/strata.h"

enum {
    FILTERING_LARGEST_SIDE = 32,
    FILTERING_REACH = 3 /* pixels that the widest weights cover */
};

/* Mirrors the STRATA_PARAMS of strata/filter.comp.glsl. */
typedef struct filtering_params {
    int32_t side, first, count;
    float rounding;
} filtering_params;

/* Part of a technique's state. */
typedef struct filtering {
    strata_image color, image, bound, image_bound;
    strata_buffer weights;
    strata_program program, bound_program;
    filtering_params params;
} filtering;

/* In prepare(), by who fills image/1: view->image() hands it over. */
strata_result filtering_prepare(filtering *f, const strata_gpu *gpu, const strata_view *view);

/* In record(), once all of color/1 and bound/1 is what it will be: weights reach beyond a pixel,
 * and so beyond its band. */
void filtering_record(const filtering *f, const strata_frame *frame);

#endif
