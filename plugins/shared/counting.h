/* SPDX-License-Identifier: MIT
 *
 * Exact allocation for captures (S-buffer, Vasilakis and Fudos 2012): a geometry pass counts the
 * fragments of each pixel by blending, scans turn the counts into ranges of fragments/1 and the
 * size of its pool. Compiled into each module that uses it; the GLSL is shaders/strata/count*.glsl.
 */
#ifndef STRATA_SHARED_COUNTING_H
#define STRATA_SHARED_COUNTING_H

#include "strata/strata.h"

#define COUNTING_LIMIT (1u << 24) /* fragments in a pixel from which a count is not exact */
#define COUNTING_ALL   UINT32_MAX /* `most`: every fragment gets a record */

/* Mirrors block Totals in shaders/strata/totals.glsl. */
typedef struct counting_totals {
    uint32_t largest;
    uint32_t arrived[2], kept[2]; /* low and high words */
} counting_totals;

/* How a store pass finds its slots in a pixel's range. */
#define COUNTING_STARTS  0 /* by itself: offsets are the ranges' beginnings */
#define COUNTING_ENDS    1 /* offsets are the ranges' ends, which it counts down to the beginnings */
#define COUNTING_CURSORS 2 /* beginnings, and in the image of counts too, which it counts up */

typedef struct counting {
    strata_image count; /* R32F; with COUNTING_CURSORS also cursors, see strata/cursor.glsl */
    strata_buffer sums, totals;
    strata_buffer nearest; /* set before counting_prepare: one uint for each pixel of the frame, the
                              most records that this pixel gets */
    strata_program count_program, sums_program, offsets_program, ranges_program;
} counting;

/* The totals or the image of counts alone, for captures that add to them by themselves. */
strata_result counting_prepare_totals(counting *c, const strata_gpu *gpu);
strata_result counting_prepare_image(counting *c, const strata_gpu *gpu);

/* All that counting_record needs, in prepare(). offsets: COUNTING_STARTS, _ENDS or _CURSORS. */
strata_result counting_prepare(counting *c, const strata_gpu *gpu, const strata_view *view,
                               int offsets);

/* In record(): counts the draws in front of or level with `limit`, gives each pixel a range for
 * at most `most` records in the block StrataRanges and tells the pool how many it needs. */
void counting_record(const counting *c, const strata_frame *frame, strata_draws draws,
                     strata_image limit, strata_buffer ranges, strata_pool records, uint32_t most);

/* The geometry pass after that which stores every fragment (ends = 1); contiguous or linked. */
extern const strata_glsl counting_store_glsl;

/* In verify(): the totals, reported; fails the frame where a count was not exact. */
strata_result counting_verify(const counting *c, const strata_frame *frame,
                              counting_totals *totals);

#endif
