/* SPDX-License-Identifier: MIT
 *
 * Techniques with their knobs turned, for sweeps and tests of every combination. What a knob does
 * to promises is said in strata/technique.h and judged here from the note alone.
 */
#include "plan/variants.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_VALUES = 32 };

typedef struct collector {
    plan_variants *out;
    const modules_technique_note *technique;
    uint32_t depth;
    int breadth;
} collector;

static int is_count(const strata_knob *knob) {
    return knob->type == STRATA_KNOB_INT && knob->trades_accuracy;
}

static int is_named(const strata_knob *knob, const char *name) {
    return strcmp(knob->name, name) == 0;
}

static const strata_knob *find_knob(const modules_technique_note *t, const char *name) {
    for (uint32_t i = 0; i < t->knob_count; ++i)
        if (is_named(t->knobs[i], name))
            return t->knobs[i];
    return NULL;
}

/* Whether it promises the exact bits on a scene so deep when it keeps so many, 0 = all. */
static int promises_exact(const modules_technique_note *t, double keeps, uint32_t depth) {
    const strata_promises *p = t->promises;
    if (!p || p->determinism != STRATA_DETERMINISM_BIT ||
        (p->largest_depth && p->largest_depth < depth))
        return 0;
    return p->order == STRATA_ORDER_EXACT
               ? keeps == 0 || keeps >= depth
               : p->order == STRATA_ORDER_NEAREST && (keeps == 0 || keeps >= depth);
}

/* One that keeps the nearest and has no knob for how many may keep one. */
static double preset_keeps(const modules_technique_note *t) {
    const strata_knob *k = find_knob(t, "k");
    return k ? k->preset : t->promises && t->promises->order == STRATA_ORDER_NEAREST ? 1 : 0;
}

/* NULL: out of memory. */
static plan_variant *add(collector *c) {
    plan_variants *v = c->out;
    if (v->count == v->capacity) {
        const uint32_t capacity = v->capacity * 2 + 16;
        plan_variant *at = base_realloc(v->at, capacity, sizeof *at);
        if (!at)
            return NULL;
        v->at = at;
        v->capacity = capacity;
    }
    const strata_promises *p = c->technique->promises;
    plan_variant *added = &v->at[v->count++];
    *added = (plan_variant){.technique = c->technique,
                            .keeps = preset_keeps(c->technique),
                            .order = p ? p->order : STRATA_ORDER_APPROXIMATE,
                            .crossed = 1,
                            .orderly = p && p->determinism == STRATA_DETERMINISM_BIT};
    added->exact = promises_exact(c->technique, added->keeps, c->depth);
    return added;
}

static void set(plan_variant *v, const strata_knob *knob, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void set(plan_variant *v, const strata_knob *knob, const char *format, ...) {
    char value[64];
    const int at = v->settings[0][0] ? 1 : 0;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(value, sizeof value, format, arguments);
    va_end(arguments);
    snprintf(v->settings[at], sizeof v->settings[at], "%s.%s=%s", v->technique->id, knob->name,
             value);
}

static void set_choice(plan_variant *v, const strata_knob *knob, uint32_t choice) {
    set(v, knob, "%s", knob->choices[choice]);
    v->crossed &= is_named(knob, "mode");
    if (is_named(knob, "payload"))
        v->payload = choice;
    else
        v->exact &= !knob->trades_accuracy || (double)choice < knob->preset;
    if (is_named(knob, "mode"))
        v->orderly &= !knob->trades_accuracy; /* folds in another order */
}

static void set_number(collector *c, plan_variant *v, const strata_knob *knob, double value) {
    set(v, knob, "%.17g", value);
    if (is_count(knob)) {
        v->keeps = value;
        v->crossed &= is_named(knob, "k") || c->breadth != PLAN_BREADTH_EDGES;
        v->exact = promises_exact(c->technique, value, c->depth);
        if (v->order != STRATA_ORDER_APPROXIMATE)
            v->order = value == 0 ? STRATA_ORDER_EXACT : STRATA_ORDER_NEAREST;
        return;
    }
    v->crossed = 0;
    v->ends_early = knob->trades_accuracy != 0;
    v->exact &= !knob->trades_accuracy;
}

/* ---- values of a knob ------------------------------------------------------------------------ */

static uint32_t keep_allowed(const strata_knob *knob, const double *from, uint32_t count,
                             double *values) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i)
        if (from[i] >= knob->minimum && from[i] <= knob->maximum && from[i] != knob->preset)
            values[kept++] = from[i];
    return kept;
}

/* Of `k`: without bound, fewer than there are, one fewer, and as many. */
static uint32_t edges(const collector *c, const strata_knob *knob, double values[MAX_VALUES]) {
    const double counts[] = {0, 3, c->depth - 1.0, c->depth};
    const double range[] = {knob->minimum, knob->maximum};
    return is_named(knob, "k") ? keep_allowed(knob, counts, 4, values)
                               : keep_allowed(knob, range, 2, values);
}

/* Counts: 1, 2, 4, .. up to the first that is all, and 0 where that means all; shares: some. */
static uint32_t ladder(const collector *c, const strata_knob *knob, double values[MAX_VALUES]) {
    double steps[MAX_VALUES];
    uint32_t count = 0;
    if (!knob->trades_accuracy)
        return 0;
    if (knob->type != STRATA_KNOB_INT) {
        const double range = knob->maximum - knob->minimum;
        const double shares[] = {knob->minimum + range / 1024, knob->minimum + range / 256,
                                 knob->minimum + range / 32};
        return keep_allowed(knob, shares, 3, values);
    }
    steps[count++] = 0;
    for (double k = 1; count < MAX_VALUES; k *= 2) {
        steps[count++] = k;
        if (k >= c->depth)
            break;
    }
    return keep_allowed(knob, steps, count, values);
}

static uint32_t values_of(const collector *c, const strata_knob *knob, double values[MAX_VALUES]) {
    return c->breadth == PLAN_BREADTH_EDGES ? edges(c, knob, values) : ladder(c, knob, values);
}

/* ---- collecting ------------------------------------------------------------------------------ */

static int is_tried(const collector *c, const strata_knob *knob) {
    return c->breadth != PLAN_BREADTH_LADDER || knob->trades_accuracy || is_named(knob, "mode");
}

static void set_value(collector *c, plan_variant *v, const strata_knob *knob, double value) {
    if (knob->type == STRATA_KNOB_CHOICE)
        set_choice(v, knob, (uint32_t)value);
    else
        set_number(c, v, knob, value);
}

/* Records are another work in each of their forms: so many of them, laid out so, in each payload.
 */
static int shapes_records(const collector *c, const strata_knob *knob) {
    return c->breadth != PLAN_BREADTH_EDGES &&
           (is_count(knob) || (is_named(knob, "mode") && !knob->trades_accuracy));
}

/* With the knob at this value; where it shapes records, once more with each other payload. */
static int add_value(collector *c, const strata_knob *knob, double value) {
    const strata_knob *payload =
        shapes_records(c, knob) ? find_knob(c->technique, "payload") : NULL;
    plan_variant *added = add(c);
    if (!added)
        return 0;
    set_value(c, added, knob, value);
    for (uint32_t i = 0; payload && payload->choices && payload->choices[i]; ++i) {
        if ((double)i == payload->preset)
            continue;
        added = add(c);
        if (!added)
            return 0;
        set_value(c, added, knob, value);
        set_choice(added, payload, i);
    }
    return 1;
}

static int add_choices(collector *c, const strata_knob *knob) {
    int added = 1;
    for (uint32_t i = 0; knob->choices[i] && is_tried(c, knob) && added; ++i)
        added = (double)i == knob->preset || add_value(c, knob, i);
    return added;
}

static int add_numbers(collector *c, const strata_knob *knob) {
    double values[MAX_VALUES];
    const uint32_t count = values_of(c, knob, values);
    int added = 1;
    for (uint32_t i = 0; i < count && added; ++i)
        added = add_value(c, knob, values[i]);
    return added;
}

static int add_technique(collector *c) {
    if (!add(c))
        return 0;
    for (uint32_t i = 0; i < c->technique->knob_count; ++i) {
        const strata_knob *knob = c->technique->knobs[i];
        if (!(knob->type == STRATA_KNOB_CHOICE ? add_choices(c, knob) : add_numbers(c, knob)))
            return 0;
    }
    return 1;
}

strata_result plan_variants_collect(const modules *installed, const char *stage, uint32_t depth,
                                    int breadth, plan_variants *out, base_error *err) {
    out->count = 0;
    for (uint32_t m = 0; m < modules_count(installed); ++m) {
        const modules_note *note = modules_note_at(installed, m);
        for (uint32_t i = 0; i < note->technique_count; ++i) {
            collector c = {
                .out = out, .technique = &note->techniques[i], .depth = depth, .breadth = breadth};
            if (strcmp(c.technique->stage, stage) == 0 && !add_technique(&c))
                return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "variants: out of memory");
        }
    }
    return STRATA_OK;
}

static int is_preset(const plan_variant *v) {
    return !v->settings[0][0];
}

int plan_variants_meet(const plan_variant *capture, const plan_variant *resolve, int breadth) {
    if (breadth == PLAN_BREADTH_EDGES)
        return capture->crossed || resolve->crossed;
    if (capture->settings[1][0] && !resolve->orderly) /* what varies is the payload's error */
        return 0;
    return is_preset(capture) || is_preset(resolve);
}
