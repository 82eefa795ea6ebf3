/* SPDX-License-Identifier: MIT
 *
 * What the nearest fragments of a pixel fold to, by a deep image: the sequential fold in float, as
 * techniques that keep all or the nearest k must have it, bit for bit.
 */
#ifndef STRATA_TESTS_DEEP_H
#define STRATA_TESTS_DEEP_H

#include <stddef.h>
#include <stdint.h>

#include "strata/host.h"

/* A deep image of a scene, its own copy. */
typedef struct deep_copy {
    size_t pixels;
    uint32_t *count;
    uint64_t *offset;
    float *color; /* RGBA of each sample, nearest first */
} deep_copy;

/* Of abuffer + ppc; what cannot be rendered fails the test. */
deep_copy deep_of(const char *backend, strata *instance, strata_scene *sc, uint32_t width,
                  uint32_t height);
void deep_free(deep_copy *d);

/* The nearest k of a pixel, 0 = all, over the background. */
void fold_nearest(const deep_copy *d, size_t pixel, uint32_t k, float out[4]);

/* Of the last frame: as many fragments, kept and dropped, as there are. */
void deep_check_report(const strata *instance, const deep_copy *d, uint32_t k, const char *what);

#endif
