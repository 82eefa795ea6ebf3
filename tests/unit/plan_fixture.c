/* SPDX-License-Identifier: MIT
 *
 * The made-up modules of plan_fixture.h. Costs are round numbers, so that tests can say which way
 * is the cheapest: for 1,000 fragments over 100 pixels abuffer + ppc cost 4,000.
 */
#include "unit/plan_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define BOTH       3u /* layouts */
#define CONTIGUOUS 1u
#define LINKED     2u

#define SLOT(verb, name, bits, none)                                                               \
    &(const strata_slot_use) {                                                                     \
        .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_##verb, .slot = (name),         \
        .layouts = (bits), .optional = (none)                                                      \
    }
#define SLOTS(...)                                                                                 \
    .slots = (const strata_slot_use *const[]){__VA_ARGS__},                                        \
    .slot_count = sizeof((const strata_slot_use *const[]){__VA_ARGS__}) / sizeof(void *)
#define KNOBS(...)                                                                                 \
    .knobs = (const strata_knob *const[]){__VA_ARGS__},                                            \
    .knob_count = sizeof((const strata_knob *const[]){__VA_ARGS__}) / sizeof(void *)
#define COST(fragment)                                                                             \
    .cost = &(const strata_cost_model) {                                                           \
        .struct_size = sizeof(strata_cost_model), .per_fragment = (fragment)                       \
    }
#define FIXED(units)                                                                               \
    .cost = &(const strata_cost_model) {                                                           \
        .struct_size = sizeof(strata_cost_model), .frame = (units)                                 \
    }
#define PROMISE(kind, same, deepest)                                                               \
    .promises = &(const strata_promises) {                                                         \
        .struct_size = sizeof(strata_promises), .order = STRATA_ORDER_##kind,                      \
        .determinism = STRATA_DETERMINISM_##same, .largest_depth = (deepest)                       \
    }

static const strata_knob mode = {
    .struct_size = sizeof mode,
    .type = STRATA_KNOB_CHOICE,
    .name = "mode",
    .maximum = 1,
    .choices = (const char *const[]){"contiguous", "linked", NULL},
};
static const strata_knob payload = {
    .struct_size = sizeof payload,
    .type = STRATA_KNOB_CHOICE,
    .name = "payload",
    .maximum = 2,
    .choices = (const char *const[]){"float", "half", "unorm8", NULL},
    .trades_accuracy = 1,
};
static const strata_knob other_payload = {
    .struct_size = sizeof other_payload,
    .type = STRATA_KNOB_CHOICE,
    .name = "payload",
    .maximum = 3,
    .choices = (const char *const[]){"float", "half", "unorm8", "words", NULL},
    .trades_accuracy = 1,
};
static const strata_knob first_nearest = {
    .struct_size = sizeof first_nearest,
    .type = STRATA_KNOB_INT,
    .name = "begin",
    .maximum = 64,
};
static const strata_knob nearest = {
    .struct_size = sizeof nearest,
    .type = STRATA_KNOB_INT,
    .name = "k",
    .unit = "fragments",
    .maximum = 64,
    .preset = 8,
    .trades_accuracy = 1,
};
static const strata_knob buckets = {
    .struct_size = sizeof buckets,
    .type = STRATA_KNOB_INT,
    .name = "buckets",
    .maximum = 1024,
};
static const strata_knob threshold = {
    .struct_size = sizeof threshold,
    .type = STRATA_KNOB_FLOAT,
    .name = "threshold",
    .minimum = 0,
    .maximum = 1,
    .preset = 0.25,
};

static const strata_knob layers = {
    .struct_size = sizeof layers,
    .type = STRATA_KNOB_INT,
    .name = "layers",
    .maximum = 64,
    .trades_accuracy = 1,
};
static const strata_knob sides = {
    .struct_size = sizeof sides,
    .type = STRATA_KNOB_CHOICE,
    .name = "mode",
    .maximum = 1,
    .choices = (const char *const[]){"front_to_back", "dual", NULL},
    .trades_accuracy = 1,
};

#define TRANSPARENT SLOT(CONSUMES, "draws.transparent/1", 0, 0), SLOT(CONSUMES, "limit/1", 0, 0)
#define CERTIFIES   SLOT(UPDATES, "bound/1", 0, 1)
#define FOLDS(bits)                                                                                \
    SLOTS(SLOT(CONSUMES, "fragments/1", bits, 0), SLOT(UPDATES, "color/1", 0, 0), CERTIFIES)

static const modules_technique_note techniques[] = {
    {.id = "surface",
     .stage = "surface",
     SLOTS(SLOT(CONSUMES, "draws.opaque/1", 0, 0), SLOT(UPDATES, "color/1", 0, 0),
           SLOT(UPDATES, "depth/1", 0, 0)),
     PROMISE(EXACT, BIT, 0),
     COST(1)},
    {.id = "flat",
     .stage = "surface",
     SLOTS(SLOT(CONSUMES, "draws.opaque/1", 0, 0), SLOT(UPDATES, "color/1", 0, 0)),
     PROMISE(EXACT, BIT, 0),
     .cost = &(const strata_cost_model){.struct_size = sizeof(strata_cost_model), .frame = 1e9}},
    {.id = "hiz",
     .stage = "draws",
     SLOTS(SLOT(UPDATES, "draws.opaque/1", 0, 0), SLOT(UPDATES, "draws.transparent/1", 0, 0),
           SLOT(CONSUMES, "depth/1", 0, 0)),
     COST(0)},
    {.id = "cull", /* objects, by the depth of the first round */
     .stage = "draws",
     SLOTS(SLOT(UPDATES, "draws.opaque/1", 0, 0), SLOT(UPDATES, "objects/1", 0, 0),
           SLOT(CONSUMES, "depth/1", 0, 0)),
     .cost = &(const strata_cost_model){.struct_size = sizeof(strata_cost_model),
                                        .frame = 1000,
                                        .per_object = 9}},
    {.id = "frustum", /* objects, by the view alone */
     .stage = "draws",
     SLOTS(SLOT(UPDATES, "draws.opaque/1", 0, 0), SLOT(UPDATES, "objects/1", 0, 0)),
     .cost = &(const strata_cost_model){.struct_size = sizeof(strata_cost_model), .per_object = 1}},
    {.id = "painter",
     .stage = "surface",
     SLOTS(SLOT(CONSUMES, "draws.opaque/1", 0, 0), SLOT(UPDATES, "color/1", 0, 0),
           SLOT(UPDATES, "depth/1", 0, 0)),
     .cost = &(const strata_cost_model){.struct_size = sizeof(strata_cost_model),
                                        .per_triangle = 2,
                                        .per_fragment = 10}},
    {.id = "facesort",
     .stage = "draws",
     SLOTS(SLOT(UPDATES, "draws.transparent/1", 0, 0)),
     COST(0)},
    {.id = "occupancy",
     .stage = "clip",
     SLOTS(SLOT(PRODUCES, "limit/1", 0, 0), SLOT(CONSUMES, "draws.transparent/1", 0, 0),
           SLOT(CONSUMES, "depth/1", 0, 0)),
     KNOBS(&buckets),
     PROMISE(NEAREST, BIT, 0),
     COST(1)},
    {.id = "range", .stage = "clip", SLOTS(SLOT(PRODUCES, "limit/1", 0, 0)), COST(1)},
    {.id = "abuffer",
     .stage = "capture",
     SLOTS(TRANSPARENT, SLOT(PRODUCES, "fragments/1", BOTH, 0)),
     KNOBS(&mode, &payload, &threshold),
     PROMISE(EXACT, BIT, 0),
     COST(3)},
    {.id = "chain", /* linked only, no knobs, cheap */
     .stage = "capture",
     SLOTS(TRANSPARENT, SLOT(PRODUCES, "fragments/1", LINKED, 0)),
     PROMISE(EXACT, BIT, 0),
     COST(0.5)},
    {.id = "stencil",
     .stage = "capture",
     SLOTS(TRANSPARENT, SLOT(PRODUCES, "fragments/1", CONTIGUOUS, 0)),
     PROMISE(EXACT, BIT, 254),
     COST(2),
     .needs = (const char *const[]){"feature.stencil_export", NULL}},
    {.id = "kplus",
     .stage = "capture",
     SLOTS(TRANSPARENT, SLOT(PRODUCES, "fragments/1", CONTIGUOUS, 0)),
     KNOBS(&nearest),
     PROMISE(NEAREST, BIT, 0),
     COST(1)},
    {.id = "growk", /* finds the k of each pixel */
     .stage = "capture",
     SLOTS(TRANSPARENT, SLOT(CONSUMES, "color/1", 0, 1),
           SLOT(PRODUCES, "fragments/1", CONTIGUOUS, 0)),
     KNOBS(&nearest, &first_nearest),
     PROMISE(NEAREST, BIT, 0),
     COST(1)},
    {.id = "slowk", /* the same, and dear */
     .stage = "capture",
     SLOTS(TRANSPARENT, SLOT(PRODUCES, "fragments/1", CONTIGUOUS, 0)),
     KNOBS(&nearest),
     PROMISE(NEAREST, BIT, 0),
     COST(5)},
    {.id = "packk", /* the same, and may pack its records */
     .stage = "capture",
     SLOTS(TRANSPARENT, SLOT(PRODUCES, "fragments/1", CONTIGUOUS, 0)),
     KNOBS(&nearest, &payload),
     PROMISE(NEAREST, BIT, 0),
     COST(2)},
    {.id = "ppc", .stage = "resolve", FOLDS(CONTIGUOUS), PROMISE(EXACT, BIT, 0), COST(1)},
    {.id = "fpc", .stage = "resolve", FOLDS(BOTH), PROMISE(EXACT, BOUNDED, 0), COST(4)},
    {.id = "sums", .stage = "resolve", FOLDS(BOTH), PROMISE(EXACT, BOUNDED, 0), COST(0.7)},
    {.id = "quicksums", .stage = "resolve", FOLDS(BOTH), PROMISE(EXACT, BOUNDED, 0), COST(0.6)},
    {.id = "walker", .stage = "resolve", FOLDS(LINKED), PROMISE(EXACT, BIT, 0), COST(2)},
    {.id = "peel",
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0), CERTIFIES),
     KNOBS(&layers, &sides),
     PROMISE(EXACT, BIT, 0),
     COST(5)},
    {.id = "pass", /* one for each layer: 10 units of depth for 1,000 fragments */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0), CERTIFIES),
     KNOBS(&layers),
     PROMISE(EXACT, BIT, 100),
     .cost = &(const strata_cost_model){.struct_size = sizeof(strata_cost_model),
                                        .frame = 40,
                                        .per_triangle = 3,
                                        .per_depth = 4,
                                        .per_depth_pixel = 3,
                                        .per_depth_fragment = 0.25,
                                        .per_depth_triangle = 2}},
    {.id = "thin", /* stores payloads, and for one of 20 fragments */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0), CERTIFIES),
     KNOBS(&payload),
     PROMISE(EXACT, BIT, 20),
     COST(6)},
    {.id = "worded", /* has a payload of its own */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0), CERTIFIES),
     KNOBS(&other_payload),
     PROMISE(EXACT, BIT, 0),
     COST(6)},
    {.id = "kbuffer",
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0), CERTIFIES),
     PROMISE(NEAREST, BIT, 0),
     COST(1.5),
     .needs = (const char *const[]){"selftest.ordered_rmw", NULL}},
    {.id = "wboit",
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0)),
     PROMISE(APPROXIMATE, BOUNDED, 0),
     COST(1.1)},
    {.id = "unit", /* what costs are measured in */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0)),
     PROMISE(APPROXIMATE, BOUNDED, 0),
     COST(1)},
    {.id = "window", /* a knob k that is not the nearest k */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0)),
     KNOBS(&nearest),
     PROMISE(APPROXIMATE, BOUNDED, 0),
     COST(1)},
    {.id = "silent", /* promises nothing, costs unknown */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0))},
    {.id = "priceless", /* exact, costs unknown */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0)),
     PROMISE(EXACT, BIT, 0)},
    {.id = "filter",
     .stage = "filter",
     SLOTS(SLOT(CONSUMES, "color/1", 0, 0), SLOT(PRODUCES, "image/1", 0, 0)),
     COST(0)},
    {.id = "blur",
     .stage = "filter",
     SLOTS(SLOT(CONSUMES, "color/1", 0, 0), SLOT(PRODUCES, "image/1", 0, 0)),
     .cost = &(const strata_cost_model){.struct_size = sizeof(strata_cost_model), .frame = 9000}},
    {.id = "fuser", /* folds and filters at once */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(UPDATES, "color/1", 0, 0), SLOT(PRODUCES, "image/1", 0, 0)),
     PROMISE(EXACT, BIT, 0),
     COST(9)},
    {.id = "mystic", .stage = "mystery", COST(0)},
    {.id = "liar", .stage = "capture", SLOTS(TRANSPARENT), PROMISE(EXACT, BIT, 0), COST(0)},
    {.id = "thief",
     .stage = "clip",
     SLOTS(SLOT(PRODUCES, "limit/1", 0, 0), SLOT(PRODUCES, "color/1", 0, 0)),
     COST(0)},
    {.id = "maker", .stage = "draws", SLOTS(SLOT(PRODUCES, "foo/1", 0, 0)), FIXED(2)},
    {.id = "maker2", .stage = "draws", SLOTS(SLOT(PRODUCES, "foo/1", 0, 0)), FIXED(1)},
    {.id = "taker", /* a fold that wants foo/1 */
     .stage = "stream",
     SLOTS(TRANSPARENT, SLOT(CONSUMES, "foo/1", 0, 0), SLOT(UPDATES, "color/1", 0, 0)),
     PROMISE(EXACT, BIT, 0),
     COST(0.1)},
    {.id = "wisher", /* would like foo/1, and does without */
     .stage = "draws",
     SLOTS(SLOT(CONSUMES, "foo/1", 0, 1), SLOT(UPDATES, "draws.opaque/1", 0, 0))},
    {.id = "tinted", /* waits for a late stage */
     .stage = "surface",
     SLOTS(SLOT(CONSUMES, "draws.opaque/1", 0, 0), SLOT(CONSUMES, "tint/1", 0, 0),
           SLOT(UPDATES, "color/1", 0, 0)),
     COST(0)},
    {.id = "tinter",
     .stage = "certificate",
     SLOTS(SLOT(PRODUCES, "tint/1", 0, 0), SLOT(UPDATES, "bound/1", 0, 0))},
    {.id = "egg",
     .stage = "draws",
     SLOTS(SLOT(CONSUMES, "hen/1", 0, 0), SLOT(PRODUCES, "egg/1", 0, 0),
           SLOT(UPDATES, "draws.opaque/1", 0, 0))},
    {.id = "hen",
     .stage = "draws",
     SLOTS(SLOT(CONSUMES, "egg/1", 0, 0), SLOT(PRODUCES, "hen/1", 0, 0))},
};

#define FIELD(id, width, bits)                                                                     \
    &(const strata_field) {                                                                        \
        .struct_size = sizeof(strata_field), .channels = (width), .name = (id), .exact = (bits)    \
    }
#define PAYLOAD(...)                                                                               \
    .payload = (const strata_field *const[]){__VA_ARGS__},                                         \
    .field_count = sizeof((const strata_field *const[]){__VA_ARGS__}) / sizeof(void *)
#define NEED(id, least)                                                                            \
    .called_for_by = (const strata_need *const[]){&(const strata_need){                            \
        .struct_size = sizeof(strata_need), .fact = (id), .threshold = (least)}},                  \
    .need_count = 1

static const modules_effect_note effects[] = {
    {.id = "over",
     .transmittance_channels = 1,
     PAYLOAD(FIELD("color", 4, 0)),
     NEED("materials.blend", 1)},
    {.id = "transmission",
     .transmittance_channels = 3,
     .priority = 1,
     PAYLOAD(FIELD("color", 4, 0), FIELD("transmittance", 3, 0)),
     NEED("materials.transmission", 1)},
    {.id = "media",
     .flags = STRATA_EFFECT_SEQUENTIAL,
     .transmittance_channels = 3,
     PAYLOAD(FIELD("tint", 2, 0), FIELD("object", 1, 1)),
     NEED("materials.emissive", 2)},
    {.id = "clash",
     .transmittance_channels = 1,
     PAYLOAD(FIELD("color", 3, 0)),
     NEED("materials.unlit", 1)},
    {.id = "precise",
     .transmittance_channels = 1,
     PAYLOAD(FIELD("color", 4, 1)),
     NEED("materials.unlit", 0)},
    {.id = "greedy",
     .transmittance_channels = 1,
     PAYLOAD(FIELD("a", 4, 1), FIELD("b", 4, 1), FIELD("c", 4, 1), FIELD("d", 1, 0)),
     NEED("weather.rain", 1)},
    {.id = "idle", .transmittance_channels = 1, PAYLOAD(FIELD("color", 4, 0))},
};

const modules_effect_note *kit_effect(const char *id) {
    for (size_t i = 0; i < BASE_COUNT(effects); i++)
        if (strcmp(effects[i].id, id) == 0)
            return &effects[i];
    fprintf(stderr, "plan_fixture: no effect '%s'\n", id);
    abort();
}

static void add(kit *k, const char *id) {
    /* Copies of what is static, since each must point back to its own module. */
    static modules_technique_note technique_copies[BASE_COUNT(techniques)];
    static modules_effect_note effect_copies[BASE_COUNT(effects)];
    modules_note *note = &k->notes[k->count];
    *note = (modules_note){.id = id, .title = id, .version = "1", .licence = "MIT", .path = id};
    for (size_t i = 0; i < BASE_COUNT(techniques); i++) {
        if (strcmp(techniques[i].id, id) != 0)
            continue;
        technique_copies[i] = techniques[i];
        technique_copies[i].module = note;
        technique_copies[i].title = techniques[i].id;
        note->id = techniques[i].id;
        note->techniques = &technique_copies[i];
        note->technique_count = 1;
    }
    for (size_t i = 0; i < BASE_COUNT(effects) && !note->techniques; i++) {
        if (strcmp(effects[i].id, id) != 0)
            continue;
        effect_copies[i] = effects[i];
        effect_copies[i].module = note;
        effect_copies[i].title = effects[i].id;
        note->id = effects[i].id;
        note->effects = &effect_copies[i];
        note->effect_count = 1;
    }
    if ((!note->techniques && !note->effects) || k->count >= KIT_MOST) {
        fprintf(stderr, "plan_fixture: no module '%s'\n", id);
        abort();
    }
    note->title = note->path = note->id;
    k->list[k->count++] = note;
}

void kit_make(kit *k, const char *ids) {
    char id[64];
    int used;
    k->count = 0;
    for (; sscanf(ids, " %63s%n", id, &used) == 1; ids += used)
        add(k, id);
}

const modules_technique_note *kit_technique(const kit *k, const char *id) {
    for (uint32_t i = 0; i < k->count; i++)
        if (k->list[i]->technique_count && strcmp(k->list[i]->techniques->id, id) == 0)
            return k->list[i]->techniques;
    fail_msg("no technique '%s'", id);
    return NULL;
}

/* ---- measurements ---------------------------------------------------------------------------- */

strata_scene_stats kit_sizes(uint32_t i) {
    const double side = 100.0 + 97.0 * (i % 7), depth = 2.0 + (i * i) % 31;
    return (strata_scene_stats){.struct_size = sizeof(strata_scene_stats),
                                .width = 800,
                                .height = 600,
                                .covered_pixels = side * side,
                                .mean_depth = depth,
                                .largest_depth = 3.0 * depth + i % 5,
                                .transparent_fragments = side * side * depth,
                                .transparent_triangles = 500 + 7919 * (i % 11)};
}

void kit_measure(const kit *k, costs *c, const char *id, costs_form form,
                 const double x[COSTS_TERMS], uint32_t points, double noise) {
    double terms[COSTS_TERMS];
    char name[COSTS_NAME];
    costs_name(kit_technique(k, id), form, name);
    for (uint32_t i = 0; i < points; i++) {
        const strata_scene_stats stats = kit_sizes(i);
        costs_terms(kit_technique(k, id), &stats, 1.0 + i % 9, terms);
        const double off = 1.0 + noise * ((double)(i * 7 % 11) / 5.0 - 1.0);
        assert_true(costs_add(c, name, terms, costs_sum(x, terms) * 20e-6 * off));
    }
}

/* ---- asking for a plan ------------------------------------------------------------------------
 */

void kit_scene(const char *letters, demand *d, strata_scene_stats *stats) {
    static const struct {
        char letter;
        const char *fact, *evidence;
        uint64_t value;
    } facts[] = {
        {'o', "materials.opaque", "1 material", 1},
        {'b', "materials.blend", "3 materials with alphaMode BLEND, 2,060 triangles", 3},
        {'t', "materials.transmission", "1 material with glass", 1},
        {'e', "materials.emissive", "2 materials with emission", 2},
        {'f', "materials.emissive", "1 material with emission", 1},
        {'u', "materials.unlit", "1 material with unlit", 1},
    };
    *d = (demand){0};
    *stats = (strata_scene_stats){.struct_size = sizeof *stats, .width = 100, .height = 100};
    for (size_t i = 0; i < BASE_COUNT(facts); i++) {
        int there = strchr(letters, facts[i].letter) != NULL;
        if (!there && strchr("ef", facts[i].letter) && strpbrk(letters, "ef"))
            continue; /* the other of the two says it */
        if (!there && facts[i].letter == 'f')
            continue;
        demand_fact *f = &d->facts[d->count++];
        f->id = facts[i].fact;
        f->value = there ? facts[i].value : 0;
        if (there)
            snprintf(f->evidence, sizeof f->evidence, "%s", facts[i].evidence);
    }
    if (strchr(letters, 'o')) {
        stats->opaque_draws = 2;
        stats->opaque_triangles = 20;
    }
    if (strpbrk(letters, "cv")) {
        stats->opaque_triangles = 20000;
        stats->opaque_objects = 1000;
        stats->hidden_triangles = strchr(letters, 'c') ? 9000 : 100;
        stats->outside_triangles = 1000;
        stats->opaque_overdraw = 100;
    }
    if (strpbrk(letters, "btefu")) {
        stats->transparent_draws = 4;
        stats->transparent_triangles = 40;
        stats->transparent_fragments = 1000;
        stats->covered_pixels = 100;
        stats->mean_depth = 10;
        stats->mean_optical_depth = strchr(letters, 'n') ? 3.0 : strchr(letters, 'g') ? 0.05 : 0.3;
        stats->largest_depth = strchr(letters, 'd') ? 300 : 10;
        if (strchr(letters, 'h')) {
            stats->covered_pixels = 10;
            stats->mean_depth = 100;
        }
        stats->materials = 4;
        stats->lights = strchr(letters, 'l') ? 4 : 0;
    }
}

/* user: a space-separated list of the facts that the device has. */
static uint64_t fact_in_list(void *user, const char *id) {
    return strstr(user, id) != NULL;
}

strata_result ask(const request *r, kit *k, demand *d, plan **out, base_error *err) {
    strata_scene_stats stats;
    char everything[] = "feature.stencil_export selftest.ordered_rmw", facts[128];
    plan_input in = {
        .demand = d,
        .modules = (const modules_note *const *)k->list,
        .stats = &stats,
        .use = r->use,
        .effects = r->effects,
        .settings = r->settings,
        .fact = r->device && r->device[0] == '?' ? NULL : fact_in_list,
        .user = facts,
        .tolerance = r->tolerance,
        .raise = r->raise,
        .samples = r->samples,
        .need_fragments = r->deep,
        .costs = r->costs,
        .budget = r->budget,
        .ns = r->ns,
        .beside = r->beside,
        .late = r->late,
        .least_late = r->least_late,
    };
    snprintf(facts, sizeof facts, "%s", r->device ? r->device : everything);
    kit_make(k, r->installed);
    kit_scene(r->scene, d, &stats);
    in.module_count = k->count;
    while (in.setting_count < BASE_COUNT(r->settings) && r->settings[in.setting_count])
        in.setting_count++;
    *err = (base_error){0};
    return plan_make(&in, out, err);
}

plan *get(const request *r, kit *k, demand *d) {
    plan *p = NULL;
    base_error err;
    if (ask(r, k, d, &p, &err) != STRATA_OK)
        fail_msg("scene '%s', use '%s': %s", r->scene, r->use ? r->use : "", err.text);
    return p;
}

const char *order_of(const plan *p) {
    static char text[256];
    size_t length = 0;
    text[0] = '\0';
    for (uint32_t i = 0; i < p->technique_count; i++)
        length += (size_t)snprintf(text + length, sizeof text - length, "%s%s", i ? " " : "",
                                   p->techniques[i].technique->id);
    return text;
}

const char *reason_of(const plan *p, const char *id) {
    for (uint32_t i = 0; i < p->technique_count; i++)
        if (strcmp(p->techniques[i].technique->id, id) == 0)
            return p->techniques[i].reason;
    for (uint32_t i = 0; i < p->left_out_count; i++)
        if (strcmp(p->left_out[i].technique->id, id) == 0)
            return p->left_out[i].reason;
    for (uint32_t i = 0; i < p->effect_count; i++)
        if (strcmp(p->effects[i].effect->id, id) == 0)
            return p->effects[i].reason;
    return "nowhere in the plan";
}
