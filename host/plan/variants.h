/* SPDX-License-Identifier: MIT
 *
 * Which ways to fold there are: techniques with their knobs turned, and those of them that the
 * slots bring together, read from the modules' notes alone. For what tries many of them: sweeps,
 * and the test that every combination renders.
 */
#ifndef STRATA_HOST_VARIANTS_H
#define STRATA_HOST_VARIANTS_H

#include "modules/modules.h"

enum {
    PLAN_VARIANT_KNOBS = 2,    /* turned at most at once */
    PLAN_VARIANT_SETTING = 192 /* bytes of "ID.KNOB=VALUE": none of the three is longer than 63 */
};

enum {
    /* Each knob alone, at the edges of its range; `k` around the depth, where exactness begins. */
    PLAN_BREADTH_EDGES,
    /* What trades accuracy, in powers of two up to the depth; and `mode`; those of them that shape
     * records in each payload. */
    PLAN_BREADTH_LADDER,
    /* And every other choice. */
    PLAN_BREADTH_LADDER_ALL
};

/* A technique with some of its knobs away from their presets. */
typedef struct plan_variant {
    const modules_technique_note *technique;
    char settings[PLAN_VARIANT_KNOBS][PLAN_VARIANT_SETTING]; /* "" after the last */
    uint32_t payload;                      /* of its records, STRATA_PAYLOAD_* */
    double keeps;                          /* nearest fragments a pixel; 0: all */
    uint32_t order;                        /* STRATA_ORDER_*, as the knobs stand */
    int crossed;    /* knobs of how it keeps (mode, k) at most: combined with all others */
    int exact;      /* all fragments, in order, to the bit of the preset's payload */
    int orderly;    /* the same bits on each run */
    int ends_early; /* a knob beside k, mode and payload gives accuracy away */
} plan_variant;

typedef struct plan_variants { /* zero-initialised = empty; free(at) */
    plan_variant *at;
    uint32_t count, capacity;
} plan_variants;

/* All of the installed techniques of a stage, presets first, for a scene of this largest depth
 * complexity. OUT_OF_HOST_MEMORY. */
strata_result plan_variants_collect(const modules *installed, const char *stage, uint32_t depth,
                                    int breadth, plan_variants *out, base_error *err);

/* Whether both are used together at this breadth. */
int plan_variants_meet(const plan_variant *capture, const plan_variant *resolve, int breadth);

#endif
