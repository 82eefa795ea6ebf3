/* SPDX-License-Identifier: MIT
 *
 * Notes of made-up modules for tests of the plan: one module for each technique or effect, chosen
 * by a list of ids.
 */
#ifndef STRATA_TESTS_PLAN_FIXTURE_H
#define STRATA_TESTS_PLAN_FIXTURE_H

#include "plan/plan.h"

#define KIT_MOST 40u

typedef struct kit {
    modules_note notes[KIT_MOST];
    const modules_note *list[KIT_MOST];
    uint32_t count;
} kit;

/* "surface abuffer ppc over": the modules of these ids, in this order. An unknown id aborts. */
void kit_make(kit *k, const char *ids);

/* The usual lot. */
#define ALL                                                                                        \
    "surface hiz facesort occupancy abuffer stencil kplus ppc fpc peel kbuffer wboit filter over " \
    "transmission"

/* What a scene holds, in letters: o opaque, b BLEND, t transmission, e two emissive, f one, u
 * unlit; d for a depth of 300 instead of 10, h for a mean depth of a hundred, n for fragments that
 * hide nearly all that is behind them, g for such as hide little, l for four lights; c for a
 * thousand opaque objects of which half are hidden or outside, v for as many that are seen.
 * Whatever is transparent has 1,000 fragments. */
void kit_scene(const char *letters, demand *d, strata_scene_stats *stats);

/* Of a made kit; an unknown id fails the test. */
const modules_technique_note *kit_technique(const kit *k, const char *id);

/* Statistics of scenes in which nothing is proportional to anything else. */
strata_scene_stats kit_sizes(uint32_t i);

/* Points of a technique as if a fragment took 20 ns and its coefficients were these. Noise: up to
 * so large a share, up and down. */
void kit_measure(const kit *k, costs *c, const char *id, costs_form form,
                 const double x[COSTS_TERMS], uint32_t points, double noise);

/* What is asked of a plan: rows of tables begin with FOR(installed, scene). */
typedef struct request {
    const char *installed, *scene, *use, *effects;
    const char *settings[3];
    const char *device; /* NULL = everything; "?" = no device known */
    double tolerance;
    uint32_t samples, deep, raise;
    const costs *costs;
    double budget, beside, ns; /* in ms; of a fragment */
    uint32_t late, least_late;
} request;

#define FOR(modules, letters) .installed = (modules), .scene = (letters)

/* Result and line as plan_make gives them; *d and *k must outlive the plan. */
strata_result ask(const request *r, kit *k, demand *d, plan **out, base_error *err);

/* The same; a failure fails the test. */
plan *get(const request *r, kit *k, demand *d);

/* Ids of the techniques in their order, in one static text. */
const char *order_of(const plan *p);

/* Of a technique that runs or not, or of an effect. */
const char *reason_of(const plan *p, const char *id);

const modules_effect_note *kit_effect(const char *id);

#endif
