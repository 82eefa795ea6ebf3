/* SPDX-License-Identifier: MIT
 *
 * Settings of techniques: every knob at its preset, then what the user set as ID.KNOB=VALUE,
 * checked against the knob's type, range and choices.
 */
#define _POSIX_C_SOURCE 200809L
#include "plan/plan_internal.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_CHOICES 64u

typedef struct assignment {
    char id[64], knob[64];
    const char *value; /* the rest of the setting */
    const char *text;  /* the whole, for messages */
} assignment;

static strata_result parse(const char *text, assignment *out, base_error *err) {
    const char *equals = strchr(text, '=');
    const char *dot = strchr(text, '.');
    *out = (assignment){.text = text};
    if (!equals || !dot || dot > equals || dot == text || dot + 1 == equals || !equals[1] ||
        (size_t)(dot - text) >= sizeof out->id || (size_t)(equals - dot) > sizeof out->knob)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "--set '%.100s': expected ID.KNOB=VALUE", text);
    memcpy(out->id, text, (size_t)(dot - text));
    memcpy(out->knob, dot + 1, (size_t)(equals - dot - 1));
    out->value = equals + 1;
    return STRATA_OK;
}

int plan_knob(const modules_technique_note *note, const char *name) {
    for (uint32_t i = 0; i < note->knob_count; i++)
        if (strcmp(note->knobs[i]->name, name) == 0)
            return (int)i;
    return -1;
}

static strata_result unknown_knob(const plan_candidate *c, const assignment *a, base_error *err) {
    const char *names[MODULES_ARRAY_MAX];
    char near[96], all[256];
    uint32_t count = 0;
    for (; count < c->note->knob_count && count < MODULES_ARRAY_MAX; count++)
        names[count] = c->note->knobs[count]->name;
    plan_suggest(a->knob, names, count, near, sizeof near);
    plan_join(names, count, all, sizeof all);
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                     "--set '%.100s': %s has no knob '%s'%s; its knobs: %s", a->text, a->id,
                     a->knob, near, all);
}

static strata_result set_choice(const strata_knob *knob, const assignment *a, double *value,
                                base_error *err) {
    char near[96], all[256];
    uint32_t count = 0;
    for (; knob->choices && knob->choices[count] && count < MAX_CHOICES; count++) {
        if (strcmp(knob->choices[count], a->value) == 0) {
            *value = (double)count;
            return STRATA_OK;
        }
    }
    plan_suggest(a->value, knob->choices, count, near, sizeof near);
    plan_join(knob->choices, count, all, sizeof all);
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                     "--set '%.100s': no such choice%s; there are: %s", a->text, near, all);
}

/* A finite decimal number with a point, whatever the process's locale says of commas. */
static int parse_number(const char *text, double *value) {
    char *end;
    for (const char *c = text; *c; c++)
        if (!strchr("0123456789+-.eE", *c))
            return 0;
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0)
        return 0;
    locale_t before = uselocale(plain);
    *value = strtod(text, &end);
    uselocale(before);
    freelocale(plain);
    return end != text && !*end && isfinite(*value);
}

static strata_result set_number(const strata_knob *knob, const assignment *a, double *value,
                                base_error *err) {
    double number = 0.0;
    int whole = knob->type == STRATA_KNOB_INT;
    int fine = parse_number(a->value, &number) && number >= knob->minimum &&
               number <= knob->maximum && (!whole || floor(number) == number);
    if (fine) {
        *value = number;
        return STRATA_OK;
    }
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                     "--set '%.100s': expected a %snumber from %.15g to %.15g%s%s", a->text,
                     whole ? "whole " : "", knob->minimum, knob->maximum, knob->unit ? " " : "",
                     knob->unit ? knob->unit : "");
}

static strata_result apply(plan_work *w, const char *text) {
    assignment a;
    strata_result result = parse(text, &a, w->err);
    if (result != STRATA_OK)
        return result;
    plan_candidate *c = plan_candidate_find(w, a.id);
    if (!c)
        return plan_unknown_technique(w, "--set", a.id);
    int index = plan_knob(c->note, a.knob);
    if (index < 0)
        return unknown_knob(c, &a, w->err);
    const strata_knob *knob = c->note->knobs[index];
    c->set_knobs |= (uint64_t)1 << index;
    return knob->type == STRATA_KNOB_CHOICE ? set_choice(knob, &a, &c->values[index], w->err)
                                            : set_number(knob, &a, &c->values[index], w->err);
}

strata_result plan_resolve_settings(plan_work *w) {
    strata_result result = STRATA_OK;
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        c->values = base_calloc(c->note->knob_count, sizeof *c->values);
        if (!c->values)
            return base_fail(w->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
        for (uint32_t k = 0; k < c->note->knob_count; k++)
            c->values[k] = c->note->knobs[k]->preset;
    }
    for (uint32_t i = 0; i < w->in->setting_count && result == STRATA_OK; i++)
        result = apply(w, w->in->settings[i]);
    return result;
}
