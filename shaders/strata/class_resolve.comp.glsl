// SPDX-License-Identifier: MIT
//
// One class of pixels, one invocation a pixel: loads up to SIZE records' keys, sorts them in a
// register network, and folds. Pixels with equal keys are left to class_tied.comp.glsl. SIZE 1 sorts nothing.
#define STRATA_PAYLOAD_READ
#include "strata/fragments.glsl"
#include "strata/fold.glsl"
#include "strata/scan.glsl"
#include "strata/sort.glsl"
#include "strata/classes.glsl"
#include "strata/class_fold.glsl"
#include "strata/pool.glsl"

CLASS_TABLE(readonly)
layout(std430) readonly buffer Lists { uint lists[]; };
layout(std430) buffer TiedPool { uint tied_needed; uint tied_capacity; };
layout(std430) writeonly buffer TiedPixels { uint tied_pixels[]; };

void leave_to_tied(uint pixel) {
    uint at = atomicAdd(tied_needed, 1u);
    if (at < tied_capacity)
        tied_pixels[at] = pixel;
}

#if SIZE > 1
// Keys beyond the pixel's last are STRATA_NO_KEY and sort to the end.
#if STRATA_LAYOUT == 1
#define LOAD(i)                                                                                    \
    k[i] = STRATA_NO_KEY;                                                                          \
    s[i] = slot;                                                                                   \
    if (i < range.y) {                                                                             \
        k[i] = strata_key_at(slot).x;                                                              \
        slot = strata_link_at(slot).x;                                                             \
    }
#else
#define LOAD(i)                                                                                    \
    s[i] = range.x + i;                                                                            \
    k[i] = i < range.y ? strata_key_at(range.x + i).x : STRATA_NO_KEY;
#endif
#define COMPARE(i) tied = tied || (k[i] == k[i + 1u] && k[i] != STRATA_NO_KEY);
#endif
#define KEEP(i) sorted[i] = s[i];
#define UNROLLED 16 // steps of a fold; a loop would index the sorted slots dynamically
#define STEP(i)                                                                                    \
    if (i < range.y) {                                                                             \
        CLASS_STEP(pixel, walk, s[i])                                                              \
    }

void main() {
    uint item = strata_item();
    if (item >= classes[CLASS].count)
        return;
    uint pixel = lists[classes[CLASS].offset + item];
    uvec2 range = strata_range_at(pixel);
    if (strata_pool_short())
        return; // this attempt's pool is too small; the frame is recorded again
#if SIZE == 1
    uint s[1] = uint[1](range.x);
#else
#if STRATA_LAYOUT == 1
    uint slot = range.x;
#endif
    uint k[SIZE + 1], s[SIZE];
    k[SIZE] = STRATA_NO_KEY;
    REPEAT_SIZE(LOAD, 0u)
    SORT_SIZE(0)
    bool tied = false;
    REPEAT_SIZE(COMPARE, 0u)
    if (tied) {
        leave_to_tied(pixel);
        return;
    }
#endif
#if SIZE == 1
    CLASS_FOLD(pixel, s, range.y)
#elif SIZE > UNROLLED
    uint sorted[SIZE];
    REPEAT_SIZE(KEEP, 0u)
    CLASS_FOLD(pixel, sorted, range.y)
#else
    StrataElement walk = strata_fold_begin();
    REPEAT_SIZE(STEP, 0u)
    strata_output(pixel, walk);
#endif
}
