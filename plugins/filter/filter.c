/* SPDX-License-Identifier: MIT
 *
 * Technique module `filter`: sub-pixels to pixels. Fills image/1 from color/1 with box, tent or
 * Gaussian weights, for every technique that folds and does not do this itself; where a certificate
 * is asked for, image.bound/1 from bound/1 with the same.
 *
 * Recorded once a frame, after all bands: weights reach beyond a pixel, and so beyond its band.
 */
#include "filter_glsl.h"
#include "strata/strata.h"

#include <math.h>
#include <string.h>

enum { LARGEST_SIDE = 32, REACH = 3 /* pixels that the widest weights cover */ };

/* Mirrors the STRATA_PARAMS of filter.comp.glsl. */
typedef struct params {
    int32_t side, first, count;
    float rounding;
} params;

typedef struct filter {
    const strata_gpu *gpu;
    strata_image color, image, bound, image_bound;
    strata_buffer weights;
    strata_program program, bound_program;
    params params;
} filter;

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((filter *)state)->gpu = gpu;
    return STRATA_OK;
}

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
static void tabulate(uint32_t kind, int32_t side, params *out, float *weights) {
    *out = (params){.side = side};
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

static strata_result program(const filter *f, const char *label, uint32_t of_bounds,
                             strata_program *out) {
    static const char *const bound[] = {"FILTER_BOUND"};
    return f->gpu->program_create(f->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = STRATA_PROGRAM_COMPUTE,
                                                         .label = label,
                                                         .source = &filter_comp_glsl,
                                                         .defines = bound,
                                                         .define_count = of_bounds},
                                  out);
}

static strata_result prepare(void *state, const strata_view *view) {
    filter *f = state;
    float weights[REACH * LARGEST_SIDE];
    int32_t side = 1;
    while ((uint32_t)(side * side) < view->samples)
        ++side;
    if (side > LARGEST_SIDE)
        return STRATA_ERROR_UNSUPPORTED;
    f->color = view->image(view->self, "color/1");
    f->image = view->image(view->self, "image/1");
    f->bound = view->image(view->self, "bound/1");
    f->image_bound = view->image(view->self, "image.bound/1");
    if (!f->color.id || !f->image.id)
        return STRATA_ERROR_INVALID_STATE;
    tabulate(view->filter, side, &f->params, weights);
    strata_result r = f->gpu->buffer_create(
        f->gpu->self,
        &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                              .label = "weights",
                              .size = (uint64_t)f->params.count * sizeof(float),
                              .data = weights},
        &f->weights);
    if (r == STRATA_OK)
        r = program(f, "filter", 0, &f->program);
    if (r == STRATA_OK && f->image_bound.id)
        r = program(f, "filter bound", 1, &f->bound_program);
    return r;
}

static void record_mean(const filter *f, const strata_frame *frame, uint32_t of_bounds) {
    const uint32_t side = (uint32_t)f->params.side;
    const strata_bind binds[] = {
        {.struct_size = sizeof(strata_bind),
         .name = "sub_pixels",
         .image = of_bounds ? f->bound : f->color},
        {.struct_size = sizeof(strata_bind),
         .name = "pixels",
         .image = of_bounds ? f->image_bound : f->image},
        {.struct_size = sizeof(strata_bind), .name = "Weights", .buffer = f->weights},
        {.struct_size = sizeof(strata_bind), .name = "colors", .image = f->color}};
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = of_bounds ? "filter bound" : "filter",
                        .program = of_bounds ? f->bound_program : f->program,
                        .params = &f->params,
                        .params_size = sizeof f->params,
                        .binds = binds,
                        .bind_count = of_bounds ? 4 : 3};
    strata_groups((uint64_t)(frame->width / side) * (frame->height / side), pass.groups);
    frame->pass(frame->self, &pass);
}

static void record(void *state, const strata_frame *frame) {
    const filter *f = state;
    record_mean(f, frame, 0);
    if (f->image_bound.id)
        record_mean(f, frame, 1);
}

static void destroy(void *state) {
    memset(state, 0, sizeof(filter));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    (void)settings;
    cost->bytes_per_pixel = 0;
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = REACH * LARGEST_SIDE * sizeof(float);
    return STRATA_OK;
}

static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "color/1"};
static const strata_slot_use image_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_PRODUCES, .slot = "image/1"};
static const strata_slot_use bound_use = {.struct_size = sizeof(strata_slot_use),
                                          .use = STRATA_SLOT_CONSUMES,
                                          .slot = "bound/1",
                                          .optional = 1};
static const strata_slot_use image_bound_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_PRODUCES, .slot = "image.bound/1"};
static const strata_slot_use *const slots[] = {&color_use, &image_use, &bound_use,
                                               &image_bound_use};

static const strata_promises promises = {.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_EXACT,
                                         .determinism = STRATA_DETERMINISM_BIT,
                                         .memory = "a table of weights; image/1 is the host's"};

/* A sub-pixel lies under the weights of one pixel (box), four (tent) or nine (Gaussian). */
static const strata_cost_model cost = {
    .struct_size = sizeof(strata_cost_model), .frame = 2000, .per_pixel = 0.5};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(filter),
    .id = "filter",
    .title = "Sub-pixels to pixels: box, tent or Gaussian",
    .reference = "Patney, Tzeng, Owens 2010 (samples and their weights)",
    .stage = "filter",
    .slots = slots,
    .slot_count = 4,
    .promises = &promises,
    .cost = &cost,
    .estimate = estimate,
    .create = create,
    .prepare = prepare,
    .record = record,
    .destroy = destroy,
};
static const strata_technique *const techniques[] = {&technique};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "filter",
    .title = "Sub-pixel filter",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
