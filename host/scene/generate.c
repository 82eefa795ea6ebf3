/* SPDX-License-Identifier: MIT
 *
 * scene_generate: reads "K=V" settings against a scene's knobs, builds the scene and finishes it.
 * First noun of scene -> demand -> plan -> frame -> fragments -> image, made instead of loaded.
 */
#include "scene/generate_hard.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* In the order of scene_generators. */
static void (*const builders[])(generate_builder *) = {
    generate_shells, generate_soup, generate_hairball, generate_needles, generate_particles,
    generate_stack,  generate_city, generate_layers,   generate_glass,   generate_burst,
};

enum { MAX_KNOBS = 16 };

uint32_t generate_knob(const generate_builder *b, int knob) {
    return (uint32_t)b->knobs[knob];
}

static void list_names(const scene_generator *kind, base_text *text) {
    for (uint32_t i = 0; i < kind->knob_count; i++) {
        const scene_generator_knob *knob = &kind->knobs[i];
        base_text_add(text, "%s%s", i ? ", " : "", knob->name);
        for (uint32_t c = 0; knob->choices && knob->choices[c]; c++)
            base_text_add(text, "%s%s", c ? "|" : "=", knob->choices[c]);
        if (!knob->choices)
            base_text_add(text, "=%.12g..%.12g", knob->minimum, knob->maximum);
    }
}

/* One line: what is wrong, then every knob with its range. */
static strata_result fail_knob(const scene_generator *kind, const char *setting, const char *why,
                               base_error *err) {
    base_text names = {0};
    list_names(kind, &names);
    strata_result result =
        base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s: '%.80s' %s; knobs: %s", kind->name,
                  setting, why, names.data ? names.data : "");
    base_text_free(&names);
    return result;
}

/* Locale-independent enough: digits, one point, an exponent; nothing behind. */
static int parse_number(const char *text, double *value) {
    if (!text[0] || text[strspn(text, "0123456789.eE+-")])
        return 0;
    char *end = NULL;
    errno = 0;
    *value = strtod(text, &end);
    return end != text && !*end && isfinite(*value);
}

static strata_result set_knob(const scene_generator *kind, const char *setting, double *values,
                              base_error *err) {
    const char *equals = strchr(setting, '=');
    const scene_generator_knob *knob = NULL;
    uint32_t at = 0;
    if (!equals)
        return fail_knob(kind, setting, "is not KNOB=VALUE", err);
    for (uint32_t i = 0; i < kind->knob_count && !knob; i++) {
        size_t length = strlen(kind->knobs[i].name);
        if (length == (size_t)(equals - setting) &&
            memcmp(kind->knobs[i].name, setting, length) == 0) {
            knob = &kind->knobs[i];
            at = i;
        }
    }
    if (!knob)
        return fail_knob(kind, setting, "is not a knob of this scene", err);
    for (uint32_t c = 0; knob->choices && knob->choices[c]; c++) {
        if (strcmp(knob->choices[c], equals + 1) == 0) {
            values[at] = c;
            return STRATA_OK;
        }
    }
    double value;
    if (knob->choices)
        return fail_knob(kind, setting, "is not one of the choices", err);
    if (!parse_number(equals + 1, &value))
        return fail_knob(kind, setting, "is not a number", err);
    if (value < knob->minimum || value > knob->maximum)
        return fail_knob(kind, setting, "is out of range", err);
    if (knob->whole && value != floor(value))
        return fail_knob(kind, setting, "has to be a whole number", err);
    values[at] = value;
    return STRATA_OK;
}

static strata_result find_kind(const char *name, const scene_generator **kind, uint32_t *at,
                               base_error *err) {
    uint32_t count;
    const scene_generator *kinds = scene_generators(&count);
    base_text names = {0};
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(kinds[i].name, name) == 0) {
            *kind = &kinds[i];
            *at = i;
            base_text_free(&names);
            return STRATA_OK;
        }
        base_text_add(&names, "%s%s", i ? ", " : "", kinds[i].name);
    }
    strata_result result =
        base_fail(err, STRATA_ERROR_NOT_FOUND, "'%.80s': no such procedural scene; there are: %s",
                  name, names.data ? names.data : "");
    base_text_free(&names);
    return result;
}

static strata_result build(const char *name, void (*builder)(generate_builder *),
                           const double *values, uint64_t seed, scene **out, base_error *err) {
    generate_builder b = {.s = scene_new(name), .knobs = values, .random = generate_seed(seed)};
    strata_result result = STRATA_OK;
    b.failed = !b.s;
    if (!b.failed)
        builder(&b);
    if (b.failed)
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY,
                           "%s: no memory for a scene of this size", name);
    else
        result = scene_finish(b.s, err);
    if (result == STRATA_OK)
        *out = b.s;
    else
        scene_free(b.s);
    return result;
}

/* The procedural scene `of`, called `name`. */
static strata_result build_kind(const char *name, const char *of, const char *const *knobs,
                                uint32_t knob_count, scene **out, base_error *err) {
    const scene_generator *kind = NULL;
    uint32_t at = 0;
    double values[MAX_KNOBS];
    strata_result result = find_kind(of, &kind, &at, err);
    for (uint32_t i = 0; result == STRATA_OK && i < kind->knob_count; i++)
        values[i] = kind->knobs[i].preset;
    for (uint32_t i = 0; result == STRATA_OK && i < knob_count; i++)
        result = set_knob(kind, knobs[i], values, err);
    return result == STRATA_OK ? build(name, builders[at], values, (uint64_t)values[0], out, err)
                               : result;
}

static strata_result build_hard(const char *name, uint32_t knob_count, scene **out,
                                base_error *err) {
    const generate_hard_case *hard = generate_hard_find(name);
    uint32_t count = 0;
    if (!hard)
        return base_fail(err, STRATA_ERROR_NOT_FOUND,
                         "'%.80s': no such hard case; `strata list' shows them", name);
    if (knob_count > 0)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s: a hard case has no knobs", name);
    if (hard->build)
        return build(name, hard->build, hard->values, 1, out, err);
    while (count < BASE_COUNT(hard->knobs) && hard->knobs[count])
        count++;
    return build_kind(name, hard->of, hard->knobs, count, out, err);
}

strata_result scene_generate(const char *name, const char *const *knobs, uint32_t knob_count,
                             scene **out, base_error *err) {
    *out = NULL;
    return strncmp(name, "hard:", 5) == 0 ? build_hard(name, knob_count, out, err)
                                          : build_kind(name, name, knobs, knob_count, out, err);
}
