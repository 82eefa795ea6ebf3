/* SPDX-License-Identifier: MIT
 *
 * Demand: one table of facts. A fact either counts materials in use, by a predicate, or totals of
 * what is visible. See demand.h.
 */
#include "plan/demand.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct material_use {
    uint64_t triangles, points;
} material_use;

typedef struct totals {
    uint64_t instances, triangles, points, lights, animated;
} totals;

static int is_mask(const scene_material *m) {
    return m->alpha == SCENE_MASK;
}

static int is_blend(const scene_material *m) {
    return m->alpha == SCENE_BLEND;
}

static int is_transmission(const scene_material *m) {
    return m->transmission > 0.0f;
}

static int is_opaque(const scene_material *m) {
    return !is_mask(m) && !is_blend(m) && !is_transmission(m);
}

static int is_unlit(const scene_material *m) {
    return m->unlit != 0;
}

static int is_emissive(const scene_material *m) {
    return m->emissive[0] > 0.0f || m->emissive[1] > 0.0f || m->emissive[2] > 0.0f;
}

static uint64_t get_instances(const totals *t) {
    return t->instances;
}

static uint64_t get_triangles(const totals *t) {
    return t->triangles;
}

static uint64_t get_points(const totals *t) {
    return t->points;
}

static uint64_t get_lights(const totals *t) {
    return t->lights;
}

static uint64_t get_animated(const totals *t) {
    return t->animated;
}

/* `noun` completes the sentence "N material(s) NOUN" or "N NOUN(s)". */
static const struct fact_row {
    const char *id, *noun, *title;
    int (*counts)(const scene_material *);
    uint64_t (*total)(const totals *);
} rows[] = {
    {"materials.opaque", "with alphaMode OPAQUE", "materials in use, opaque without a mask",
     is_opaque, NULL},
    {"materials.mask", "with alphaMode MASK", "materials in use with alphaMode MASK", is_mask,
     NULL},
    {"materials.blend", "with alphaMode BLEND", "materials in use with alphaMode BLEND", is_blend,
     NULL},
    {"materials.transmission", "with KHR_materials_transmission",
     "materials in use with KHR_materials_transmission above 0", is_transmission, NULL},
    {"materials.unlit", "with KHR_materials_unlit", "materials in use that are not shaded",
     is_unlit, NULL},
    {"materials.emissive", "with emission", "materials in use that emit light", is_emissive, NULL},
    {"instances", "visible instance", "visible instances that have geometry", NULL, get_instances},
    {"triangles", "triangle", "triangles of visible instances", NULL, get_triangles},
    {"points", "point", "points (round splats) of visible instances", NULL, get_points},
    {"lights", "light", "lights", NULL, get_lights},
    {"animated", "animated scene", "1 when the scene changes with time", NULL, get_animated},
};
_Static_assert(BASE_COUNT(rows) <= DEMAND_MAX_FACTS, "room for every fact");

const char *demand_number(uint64_t value, char text[32]) {
    char digits[24];
    int length = snprintf(digits, sizeof digits, "%llu", (unsigned long long)value);
    int out = 0;
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0)
            text[out++] = ',';
        text[out++] = digits[i];
    }
    text[out] = '\0';
    return text;
}

const char *demand_describe(uint32_t index, const char **id) {
    if (index >= BASE_COUNT(rows))
        return NULL;
    *id = rows[index].id;
    return rows[index].title;
}

const demand_fact *demand_find(const demand *d, const char *id) {
    for (uint32_t i = 0; i < d->count; i++)
        if (strcmp(d->facts[i].id, id) == 0)
            return &d->facts[i];
    return NULL;
}

int demand_material_counts(const scene_material *material, const char *fact) {
    for (size_t i = 0; i < BASE_COUNT(rows); i++)
        if (rows[i].counts && strcmp(rows[i].id, fact) == 0)
            return rows[i].counts(material);
    return 0;
}

static void material_evidence(const struct fact_row *row, uint64_t materials, material_use use,
                              char *text, size_t size) {
    char a[32], b[32], c[32];
    const char *plural = materials == 1 ? "" : "s";
    demand_number(materials, a);
    demand_number(use.triangles, b);
    demand_number(use.points, c);
    const char *triangles = use.triangles == 1 ? "triangle" : "triangles";
    const char *points = use.points == 1 ? "point" : "points";
    if (use.points == 0)
        snprintf(text, size, "%s material%s %s, %s %s", a, plural, row->noun, b, triangles);
    else if (use.triangles == 0)
        snprintf(text, size, "%s material%s %s, %s %s", a, plural, row->noun, c, points);
    else
        snprintf(text, size, "%s material%s %s, %s %s and %s %s", a, plural, row->noun, b,
                 triangles, c, points);
}

static void fill_fact(const struct fact_row *row, const scene *s, const material_use *uses,
                      const totals *all, demand_fact *fact) {
    material_use sum = {0};
    char number[32];
    *fact = (demand_fact){.id = row->id};
    if (row->total)
        fact->value = row->total(all);
    for (uint32_t i = 0; row->counts && i < s->material_count; i++) {
        if ((uses[i].triangles == 0 && uses[i].points == 0) || !row->counts(&s->materials[i]))
            continue;
        fact->value++;
        sum.triangles += uses[i].triangles;
        sum.points += uses[i].points;
    }
    if (fact->value == 0)
        return;
    if (row->counts)
        material_evidence(row, fact->value, sum, fact->evidence, sizeof fact->evidence);
    else
        snprintf(fact->evidence, sizeof fact->evidence, "%s %s%s",
                 demand_number(fact->value, number), row->noun, fact->value == 1 ? "" : "s");
}

strata_result demand_make(const scene *s, demand *out, base_error *err) {
    *out = (demand){0};
    totals all = {.lights = s->light_count, .animated = s->animations != NULL};
    material_use *uses = base_calloc(s->material_count, sizeof *uses);
    if (!uses)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY,
                         "%s: no memory to count its materials", s->path);
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_instance *instance = &s->instances[i];
        const scene_mesh *mesh = &s->meshes[instance->mesh];
        if (!instance->visible || mesh->index_count == 0)
            continue;
        uint64_t triangles = mesh->topology == SCENE_TRIANGLES ? mesh->index_count / 3u : 0u;
        uint64_t points = mesh->topology == SCENE_POINTS ? mesh->index_count : 0u;
        uses[mesh->material].triangles += triangles;
        uses[mesh->material].points += points;
        all.triangles += triangles;
        all.points += points;
        all.instances++;
    }
    for (size_t i = 0; i < BASE_COUNT(rows); i++)
        fill_fact(&rows[i], s, uses, &all, &out->facts[i]);
    out->count = (uint32_t)BASE_COUNT(rows);
    free(uses);
    return STRATA_OK;
}
