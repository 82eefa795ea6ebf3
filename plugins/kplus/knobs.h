/* SPDX-License-Identifier: MIT
 *
 * kplus: what may be set, the values of choices, and what follows from them.
 */
#ifndef STRATA_KPLUS_KNOBS_H
#define STRATA_KPLUS_KNOBS_H

#include "strata/strata.h"

enum { K_MOST = 16384 }; /* CELL_COUNT holds it */

enum {
    KNOB_K,
    KNOB_STRUCTURE,
    KNOB_EXCLUSION,
    KNOB_MEMORY,
    KNOB_PAYLOAD,
    KNOB_TRIES,
    KNOB_BEGIN,
    KNOB_COUNT
};
enum { STRUCTURE_AUTO, STRUCTURE_ARRAY, STRUCTURE_HEAP };
enum { MEMORY_FIXED, MEMORY_EXACT };
typedef enum path { /* of the knob `exclusion` */
                    PATH_AUTO,
                    PATH_LOCK,
                    PATH_ATOMIC64,
                    PATH_ATOMIC32,
                    PATH_UNLOCKED,
                    PATH_ORDERED,
                    PATH_INTERLOCK
} path;

extern const strata_knob *const kplus_knobs[KNOB_COUNT];

/* Fragments are counted first: ranges are exact. `values` are the knobs', here and below. */
uint32_t kplus_is_exact(const double *values);

/* Not an array. Where accesses are in order without any help (path `unlocked`), one of a fixed
 * number of slots has its keys in texels besides, and pays for longer. */
uint32_t kplus_is_heap(const double *values, const strata_scene_stats *stats, uint32_t unlocked);

#endif
