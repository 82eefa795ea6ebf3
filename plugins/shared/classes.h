/* SPDX-License-Identifier: MIT
 *
 * Pixels in classes of 1, 2 to 8, to 16, to 32, to 64 and more fragments, those of at most 64 each
 * sorted by a network in registers and folded. What is deeper is the technique's own.
 *
 *   histogram -> (a pass of the technique) -> lists    the pixels of each class
 *   resolve, once for each class                       one invocation a pixel
 *   ties -> tied                                       pixels with equal keys, by (key, order)
 *
 * The technique's pass calls strata_class_offsets() of strata/class_offsets.glsl.
 */
#ifndef STRATA_PLUGINS_CLASSES_H
#define STRATA_PLUGINS_CLASSES_H

#include "shared/binds.h"

enum { CLASSES_COUNT = 6, CLASSES_DEEP = 5, CLASSES_BLOCK = 32 };

/* Mirrors CLASS_TABLE in strata/classes.glsl. */
typedef struct classes_table {
    struct {
        uint32_t count, offset, cursor, unused, groups[4];
    } classes[CLASSES_COUNT];
    uint32_t tied_groups[4], block_groups[4];
    uint32_t largest, blocks, cursor, deep_fits;
} classes_table;
_Static_assert(sizeof(classes_table) == 240, "mirrors CLASS_TABLE");

/* Part of a technique's state. */
typedef struct classes {
    const strata_fragments *fragments;
    strata_image color;
    strata_buffer table, lists;
    strata_pool tied;
    strata_program histogram_program, lists_program, resolve_program[CLASSES_DEEP], ties_program,
        tied_program;
    uint32_t seen;      /* bit for each class that some frame had */
    uint32_t tied_seen; /* 1: some frame had equal keys */
    uint32_t ends;      /* 1: folds end early */
    float threshold;    /* where that is */
} classes;

/* In prepare(). `blocks`: deep pixels take blocks, and the lists pass names DeepBase and with
 * linked records DeepIndex. `ends`: c->threshold counts. What was learned stays. */
strata_result classes_prepare(classes *c, const strata_gpu *gpu, const strata_view *view,
                              uint32_t blocks, uint32_t ends);

void classes_record_histogram(const classes *c, const strata_frame *frame);
/* `more`: binds of the deep pixels' pools. */
void classes_record_lists(const classes *c, const strata_frame *frame, const binds *more);
void classes_record_folds(const classes *c, const strata_frame *frame);

/* In verify(), with the table as read back. Returns the classes that are present and were not
 * recorded, as bits, and in *tied whether equal keys were left behind; records them from now on. */
uint32_t classes_learn(classes *c, const strata_frame *frame, const classes_table *table,
                       uint32_t *tied);

#endif
