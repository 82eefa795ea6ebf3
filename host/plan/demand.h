/* SPDX-License-Identifier: MIT
 *
 * Demand: what a scene calls for. Counts over what is visible, each with the sentence that proves
 * it; effects name these facts in `called_for_by`. No evidence, no effect. Second noun of
 * scene -> demand -> plan -> frame -> fragments -> image. Pure: reads the scene, touches nothing.
 */
#ifndef STRATA_HOST_DEMAND_H
#define STRATA_HOST_DEMAND_H

#include "scene/scene.h"

#define DEMAND_MAX_FACTS 24u

typedef struct demand_fact {
    const char *id;     /* "materials.blend"; static */
    uint64_t value;     /* materials, triangles, ... in use by visible instances */
    char evidence[192]; /* "3 materials with alphaMode BLEND, 2,060 triangles"; "" when 0 */
} demand_fact;

typedef struct demand {
    demand_fact facts[DEMAND_MAX_FACTS];
    uint32_t count;
} demand;

/* Counts every fact; zeros are listed too, so that the facts of any two scenes compare. */
strata_result demand_make(const scene *s, demand *out, base_error *err);

/* NULL when there is no fact of that id. */
const demand_fact *demand_find(const demand *d, const char *id);

/* Whether this material is one of those that the fact counts; 0 for facts that count other things.
 */
int demand_material_counts(const scene_material *material, const char *fact);

/* A number as people read it: "2,060". Returns text. */
const char *demand_number(uint64_t value, char text[32]);

/* What a fact counts, one line for help and lists; NULL past the last. *id is set. */
const char *demand_describe(uint32_t index, const char **id);

#endif
