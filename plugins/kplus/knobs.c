/* SPDX-License-Identifier: MIT
 *
 * The knobs; see knobs.h.
 */
#include "kplus/knobs.h"

#include "shared/records.h"

static const char *const structure_choices[] = {"auto", "array", "heap", NULL};
static const char *const exclusion_choices[] = {"auto",     "lock",    "atomic64",  "atomic32",
                                                "unlocked", "ordered", "interlock", NULL};
static const char *const memory_choices[] = {"fixed", "exact", NULL};
static const strata_knob k = {.struct_size = sizeof(strata_knob),
                              .type = STRATA_KNOB_INT,
                              .name = "k",
                              .title = "fragments a pixel that are kept; 0 = all",
                              .unit = "fragments",
                              .maximum = K_MOST,
                              .preset = 8,
                              .trades_accuracy = 1};
static const strata_knob structure = {.struct_size = sizeof(strata_knob),
                                      .type = STRATA_KNOB_CHOICE,
                                      .name = "structure",
                                      .title = "how the farthest record is found",
                                      .maximum = 2,
                                      .choices = structure_choices};
static const strata_knob exclusion = {.struct_size = sizeof(strata_knob),
                                      .type = STRATA_KNOB_CHOICE,
                                      .name = "exclusion",
                                      .title = "what keeps fragments of a pixel apart",
                                      .maximum = 6,
                                      .choices = exclusion_choices};
static const strata_knob memory = {.struct_size = sizeof(strata_knob),
                                   .type = STRATA_KNOB_CHOICE,
                                   .name = "memory",
                                   .title = "k slots a pixel, or as many as it fills",
                                   .maximum = 1,
                                   .choices = memory_choices};
static const strata_knob tries = {.struct_size = sizeof(strata_knob),
                                  .type = STRATA_KNOB_INT,
                                  .name = "tries",
                                  .title = "of the lock, before the frame does without",
                                  .maximum = 32768,
                                  .preset = 4096};
static const strata_knob begin = {.struct_size = sizeof(strata_knob),
                                  .type = STRATA_KNOB_INT,
                                  .name = "begin",
                                  .title = "of k, with a tolerance: what each pixel begins with; "
                                           "0 = k",
                                  .unit = "fragments",
                                  .maximum = K_MOST};
const strata_knob *const kplus_knobs[KNOB_COUNT] = {
    &k, &structure, &exclusion, &memory, &records_payload_knob, &tries, &begin};

enum { ARRAY_MOST = 32, TEXELS_MOST = 128 }; /* a heap wins above; with keys in texels */

uint32_t kplus_is_exact(const double *values) {
    return values[KNOB_K] == 0 || values[KNOB_BEGIN] > 0 || values[KNOB_MEMORY] == MEMORY_EXACT;
}

/* By the fragments that pixels may keep; where each has a k of its own, most keep few of theirs,
 * and a heap's nodes would be the larger part of what that spares. */
uint32_t kplus_is_heap(const double *values, const strata_scene_stats *stats, uint32_t unlocked) {
    const double chosen = values[KNOB_STRUCTURE], half = stats->mean_depth / 2,
                 most = values[KNOB_BEGIN] > 0 && half < values[KNOB_K] ? half : values[KNOB_K];
    if (chosen != STRUCTURE_AUTO)
        return chosen == STRUCTURE_HEAP;
    return most > (unlocked && !kplus_is_exact(values) ? TEXELS_MOST : ARRAY_MOST);
}
