/* SPDX-License-Identifier: MIT
 *
 * kplus: what may be set, and the values of choices.
 */
#ifndef STRATA_KPLUS_KNOBS_H
#define STRATA_KPLUS_KNOBS_H

#include "strata/strata.h"

enum { K_MOST = 16384 }; /* CELL_PLACE holds it */

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

#endif
