/* SPDX-License-Identifier: MIT
 *
 * Sub-pixels to pixels: weights, programs and passes. See filtering.h.
 */
#include "shared/filtering.h"

#include "shared/binds.h"

#include <math.h>

static const strata_glsl filter_glsl = {"#include \"strata/filter.comp.glsl\"\n", "filter.comp"};

/* Weight at a distance from the pixel's centre, in pixels; 0 outside of the support. */
static double weight(uint32_t kind, double distance) {
    const double deviation = 0.5;
    if (kind == STRATA_FILTER_TENT)
        return distance < 1.0 ? 1.0 - distance : 0.0;
    if (kind == STRATA_FILTER_GAUSSIAN)
        return distance < 1.5 ? exp(-0.5 * distance * distance / (deviation * deviation)) : 0.0;
    return distance < 0.5 ? 1.0 : 0.0;
}

/* Relative rounding of a mean of n terms, outward: a weight has that of two table entries and their
 * product, a term one more, a sum n - 1, for numerator and denominator, and the division one;
 * doubled, so that it also covers the rounding of what is made of it. */
static float rounding(double n) {
    const double u = ldexp(1.0, -24), m = 2.0 * n + 6.0;
    return (float)(2.0 * m * u / (1.0 - m * u));
}

/* Weights along one axis of the sub-pixels from `first` on. Those of 0 are left out: they would
 * only turn an infinite value into NaN. */
static void tabulate(uint32_t kind, int32_t side, filtering_params *out, float *weights) {
    *out = (filtering_params){.side = side};
    for (int32_t i = -side; i < 2 * side; ++i) {
        const double at = (i + 0.5) / side - 0.5;
        const double w = weight(kind, fabs(at));
        if (!(w > 0.0))
            continue;
        if (out->count == 0)
            out->first = i;
        weights[out->count++] = (float)w;
    }
    out->rounding = rounding((double)out->count * out->count);
}

static strata_result program(const strata_gpu *gpu, const char *label, uint32_t of_bounds,
                             strata_program *out) {
    static const char *const bound[] = {"FILTER_BOUND"};
    return gpu->program_create(gpu->self,
                               &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                      .kind = STRATA_PROGRAM_COMPUTE,
                                                      .label = label,
                                                      .source = &filter_glsl,
                                                      .defines = bound,
                                                      .define_count = of_bounds},
                               out);
}

strata_result filtering_prepare(filtering *f, const strata_gpu *gpu, const strata_view *view) {
    float weights[FILTERING_REACH * FILTERING_LARGEST_SIDE];
    int32_t side = 1;
    while ((uint32_t)(side * side) < view->samples)
        ++side;
    if (side > FILTERING_LARGEST_SIDE)
        return STRATA_ERROR_UNSUPPORTED;
    f->color = view->image(view->self, "color/1");
    f->image = view->image(view->self, "image/1");
    f->bound = view->image(view->self, "bound/1");
    f->image_bound = view->image(view->self, "image.bound/1");
    if (!f->color.id || !f->image.id)
        return STRATA_ERROR_INVALID_STATE;
    tabulate(view->filter, side, &f->params, weights);
    strata_result r =
        gpu->buffer_create(gpu->self,
                           &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                 .label = "weights",
                                                 .size = (uint64_t)f->params.count * sizeof(float),
                                                 .data = weights},
                           &f->weights);
    if (r == STRATA_OK)
        r = program(gpu, "filter", 0, &f->program);
    if (r == STRATA_OK && f->image_bound.id)
        r = program(gpu, "filter bound", 1, &f->bound_program);
    return r;
}

static void record_mean(const filtering *f, const strata_frame *frame, uint32_t of_bounds) {
    const uint32_t side = (uint32_t)f->params.side;
    binds b = {.count = 0};
    binds_image(&b, "sub_pixels", of_bounds ? f->bound : f->color);
    binds_image(&b, "pixels", of_bounds ? f->image_bound : f->image);
    binds_buffer(&b, "Weights", f->weights);
    if (of_bounds)
        binds_image(&b, "colors", f->color);
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = of_bounds ? "filter bound" : "filter",
                        .program = of_bounds ? f->bound_program : f->program,
                        .params = &f->params,
                        .params_size = sizeof f->params,
                        .binds = b.at,
                        .bind_count = b.count};
    strata_groups((uint64_t)(frame->width / side) * (frame->height / side), pass.groups);
    frame->pass(frame->self, &pass);
}

void filtering_record(const filtering *f, const strata_frame *frame) {
    record_mean(f, frame, 0);
    if (f->image_bound.id)
        record_mean(f, frame, 1);
}
