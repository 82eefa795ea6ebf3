/* SPDX-License-Identifier: MIT
 *
 * Technique module `filter`: sub-pixels to pixels. Fills image/1 from color/1 with box, tent or
 * Gaussian weights, for every technique that folds and does not do this itself; where a certificate
 * is asked for, image.bound/1 from bound/1 with the same. The work is shared/filtering.h's.
 *
 * Recorded once a frame, after all bands: weights reach beyond a pixel, and so beyond its band.
 */
#include "shared/filtering.h"
#include "shared/slots.h"

#include <string.h>

typedef struct filter {
    const strata_gpu *gpu;
    filtering filtering;
} filter;

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((filter *)state)->gpu = gpu;
    return STRATA_OK;
}

static strata_result prepare(void *state, const strata_view *view) {
    filter *f = state;
    return filtering_prepare(&f->filtering, f->gpu, view);
}

static void record(void *state, const strata_frame *frame) {
    filtering_record(&((const filter *)state)->filtering, frame);
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
    cost->bytes_fixed = FILTERING_REACH * FILTERING_LARGEST_SIDE * sizeof(float);
    return STRATA_OK;
}

static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "color/1"};
static const strata_slot_use bound_use = {.struct_size = sizeof(strata_slot_use),
                                          .use = STRATA_SLOT_CONSUMES,
                                          .slot = "bound/1",
                                          .optional = 1};
static const strata_slot_use *const slots[] = {&color_use, &slots_image, &bound_use,
                                               &slots_image_bound};

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
