/* SPDX-License-Identifier: MIT
 *
 * Every path of kplus, for its tests.
 */
#ifndef STRATA_TESTS_KPLUS_VARIANTS_H
#define STRATA_TESTS_KPLUS_VARIANTS_H

#include "techniques/picture.h"

/* How fragments are kept apart, the structure, the memory. */
typedef struct kplus_variant {
    const char *settings[4];
    const char *fact; /* that it needs of the device */
    uint32_t cheap;   /* 1: also where a pixel has very many layers */
    uint32_t k_most;  /* the largest k that it takes; 0 = any */
} kplus_variant;

enum { KPLUS_VARIANTS = 15 };
extern const kplus_variant kplus_variants[KPLUS_VARIANTS];

/* With an interlock, as far as picture_fact counts it. */
extern const char *const kplus_backends[2];

/* Whether this device has what it needs, and it takes so many fragments a pixel. */
int kplus_runs(const strata *instance, const kplus_variant *v, uint32_t k);

#endif
