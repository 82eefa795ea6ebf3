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

/* Not an array. */
uint32_t kplus_is_heap(const double *values, const strata_scene_stats *stats);

/* Where `unlocked` writes each key to a texel besides: fixed slots, few enough to be filled. */
uint32_t kplus_has_texels(const double *values, const strata_scene_stats *stats);

#endif
