/* SPDX-License-Identifier: MIT
 *
 * kplus, k per pixel: every pixel begins a frame with few slots, and the frame is recorded again
 * with twice as many wherever what was dropped may exceed the tolerance.
 */
#ifndef STRATA_KPLUS_GROW_H
#define STRATA_KPLUS_GROW_H

#include "strata/strata.h"

typedef struct growth {
    uint32_t begin;        /* slots that a pixel begins with; 0: all have k, nothing grows */
    uint32_t k;            /* the most that it may have */
    uint32_t anew;         /* 1: `nearest` and `seen` hold nothing yet */
    float truncation;      /* the most that dropped fragments may change a pixel */
    strata_buffer nearest; /* for each pixel of the frame, how many it keeps */
    strata_buffer grown;   /* pixels that were given more, and records that this takes */
    strata_buffer seen;    /* the last frame's scene and view */
    strata_image behind;
    strata_program compare_program, begin_program, grow_program, room_program;
} growth;

/* What the passes read of the capture. */
typedef struct growth_captured {
    strata_buffer ranges, events;
    strata_image count;
    strata_pool records;
} growth_captured;

/* In prepare(), before the counting's: begin = 0 unless there is a tolerance and begin < k. */
strata_result growth_prepare(growth *g, const strata_gpu *gpu, const strata_view *view,
                             uint32_t begin, uint32_t k, const strata_glsl *const *includes);

/* In record(), before the counting and after the capture. */
void growth_begin(growth *g, const strata_frame *frame);
void growth_record(const growth *g, const strata_frame *frame, const growth_captured *captured);

/* In verify(): RETRY where pixels grew. */
strata_result growth_verify(const growth *g, const strata_frame *frame);

#endif
