// SPDX-License-Identifier: MIT
//
// The fold of a pixel of at most 64 sorted slots, and its end; with CLASS_THRESHOLD where the walk
// has ended, the rest being counted as lost.
#include "strata/ended.glsl"
#include "strata/loss.glsl"
#include "strata/output.glsl"

#ifdef CLASS_THRESHOLD
STRATA_PARAMS { float threshold; } params;
#define CLASS_ENDED(walk) strata_ended(walk, params.threshold)
#define CLASS_LOSE(pixel, slot) strata_lose(pixel, strata_payload_load(slot))
#else
#define CLASS_ENDED(walk) false
#define CLASS_LOSE(pixel, slot)
#endif

#define CLASS_STEP(pixel, walk, slot)                                                              \
    if (CLASS_ENDED(walk)) {                                                                       \
        CLASS_LOSE(pixel, slot);                                                                   \
    } else {                                                                                       \
        strata_fold_step(walk, strata_event(strata_payload_load(slot)));                           \
    }

#define CLASS_FOLD(pixel, slots, count)                                                            \
    {                                                                                              \
        StrataElement walk = strata_fold_begin();                                                  \
        for (uint at = 0u; at < count; ++at) {                                                     \
            CLASS_STEP(pixel, walk, slots[at])                                                     \
        }                                                                                          \
        strata_output(pixel, walk);                                                                \
    }
