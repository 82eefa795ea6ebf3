/* SPDX-License-Identifier: MIT
 *
 * The cost model and its fit to measured points; see costs.h.
 */
#include "plan/costs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- terms ----------------------------------------------------------------------------------- */

static int is_stage(const modules_technique_note *note, const char *stage) {
    return note->stage && strcmp(note->stage, stage) == 0;
}

int costs_count_knob(const modules_technique_note *note) {
    for (uint32_t i = 0; i < note->knob_count; i++)
        if (note->knobs[i]->trades_accuracy && note->knobs[i]->type == STRATA_KNOB_INT)
            return (int)i;
    return -1;
}

int costs_payload_knob(const modules_technique_note *note) {
    for (uint32_t i = 0; i < note->knob_count; i++)
        if (note->knobs[i]->type == STRATA_KNOB_CHOICE &&
            strcmp(note->knobs[i]->name, "payload") == 0)
            return (int)i;
    return -1;
}

/* A technique pays for what its slots give it to work on: triangles of the draws it touches,
 * fragments and covered pixels when those are transparent, else all pixels. What reads captured
 * fragments has those that were kept; what keeps the nearest is done after so many layers. */
void costs_terms(const modules_technique_note *note, const strata_scene_stats *stats,
                 double nearest, double terms[COSTS_TERMS]) {
    const int stream = is_stage(note, "stream"), capture = is_stage(note, "capture"),
              resolve = is_stage(note, "resolve");
    const int folds = capture || resolve || stream || is_stage(note, "clip");
    const double most = nearest > 0.0 ? nearest : HUGE_VAL;
    const double kept = stats->covered_pixels * fmin(most, stats->mean_depth);
    double fragments = folds ? stats->transparent_fragments : 0.0, mean = stats->mean_depth;
    double pixels = folds ? stats->covered_pixels : (double)stats->width * (double)stats->height;
    double triangles = 0.0, depth = stats->largest_depth;
    if (modules_slot(note, "draws.opaque/1", 0) || modules_slot(note, "draws.opaque.all/1", 0))
        triangles += (double)stats->opaque_triangles;
    if (modules_slot(note, "draws.transparent/1", 0) ||
        modules_slot(note, "draws.transparent.all/1", 0))
        triangles += (double)stats->transparent_triangles;
    if (resolve && nearest > 0.0) {
        fragments = fmin(fragments, kept);
        mean = fmin(mean, nearest);
    }
    if (resolve || capture || stream)
        depth = fmin(depth, most);
    const int holds = (capture || stream) && costs_count_knob(note) >= 0;
    const double all[COSTS_TERMS] = {
        [COSTS_FRAME] = 1.0,
        [COSTS_PIXEL] = pixels,
        [COSTS_FRAGMENT] = fragments,
        [COSTS_FRAGMENT_LOG2_DEPTH] = fragments * log2(1.0 + mean),
        [COSTS_TRIANGLE] = triangles,
        [COSTS_DEPTH] = depth,
        [COSTS_DEPTH_PIXEL] = depth * pixels,
        [COSTS_DEPTH_FRAGMENT] = depth * fragments,
        [COSTS_DEPTH_TRIANGLE] = depth * triangles,
        [COSTS_OBJECT] = modules_slot(note, "objects/1", 0) ? (double)stats->opaque_objects : 0.0,
        [COSTS_KEPT] = holds ? kept : 0.0,
    };
    memcpy(terms, all, sizeof all);
}

int costs_of_module(const modules_technique_note *note, double coefficients[COSTS_TERMS]) {
    const strata_cost_model *m = note->cost;
    if (!m)
        return 0;
    const double all[COSTS_TERMS] = {
        [COSTS_FRAME] = m->frame,
        [COSTS_PIXEL] = m->per_pixel,
        [COSTS_FRAGMENT] = m->per_fragment,
        [COSTS_FRAGMENT_LOG2_DEPTH] = m->per_fragment_log2_depth,
        [COSTS_TRIANGLE] = m->per_triangle,
        [COSTS_DEPTH] = m->per_depth,
        [COSTS_DEPTH_PIXEL] = m->per_depth_pixel,
        [COSTS_DEPTH_FRAGMENT] = m->per_depth_fragment,
        [COSTS_DEPTH_TRIANGLE] = m->per_depth_triangle,
        [COSTS_OBJECT] = m->per_object,
    };
    memcpy(coefficients, all, sizeof all);
    return 1;
}

int costs_is_unit(const modules_technique_note *note) {
    double coefficients[COSTS_TERMS];
    int is = costs_of_module(note, coefficients) && coefficients[COSTS_FRAGMENT] == 1.0;
    for (int i = 0; i < COSTS_TERMS; i++)
        is = is && (i == COSTS_FRAGMENT || coefficients[i] == 0.0);
    return is && note->promises && note->promises->order == STRATA_ORDER_APPROXIMATE;
}

const char *costs_payload_name(uint32_t payload) {
    static const char *const payloads[COSTS_PAYLOADS] = {"float", "half", "unorm8"};
    return payloads[payload];
}

void costs_name(const modules_technique_note *note, costs_form form, char name[COSTS_NAME]) {
    const int meets = modules_slot(note, "fragments/1", 0) != NULL,
              stores = meets || costs_payload_knob(note) >= 0;
    const int linked = meets && form.layout == STRATA_FRAGMENTS_LINKED,
              packed = stores && form.payload > 0 && form.payload < COSTS_PAYLOADS,
              clipped = form.clipped && modules_slot(note, "limit/1", STRATA_SLOT_CONSUMES) != NULL;
    snprintf(name, COSTS_NAME, "%.63s%s%s%s%s", note->id, linked ? ".linked" : "",
             packed ? "." : "", packed ? costs_payload_name(form.payload) : "",
             clipped ? ".clipped" : "");
}

static costs_technique *find(const costs *c, const char *name) {
    for (uint32_t i = 0; c && i < c->count; i++)
        if (strcmp(c->techniques[i].name, name) == 0)
            return &c->techniques[i];
    return NULL;
}

static const costs_technique *find_in(const costs *c, const modules_technique_note *note,
                                      costs_form form) {
    char name[COSTS_NAME];
    costs_name(note, form, name);
    return find(c, name);
}

static const costs_technique *find_near(const costs *c, const modules_technique_note *note,
                                        costs_form form) {
    const costs_technique *t = find_in(c, note, form);
    form.clipped = !form.clipped;
    if (!t || !t->fitted)
        t = find_in(c, note, form);
    return t && t->fitted ? t : find_in(c, note, (costs_form){0});
}

int costs_knows(const costs *c, const modules_technique_note *note, costs_form form) {
    const costs_technique *t = find_in(c, note, form);
    return t && t->fitted;
}

int costs_of(const costs *c, const modules_technique_note *note, costs_form form,
             double coefficients[COSTS_TERMS]) {
    const costs_technique *t = find_near(c, note, form);
    if (!t || !t->fitted)
        return costs_of_module(note, coefficients) ? 0 : -1;
    memcpy(coefficients, t->coefficients, sizeof t->coefficients);
    return (int)t->count;
}

double costs_sum(const double coefficients[COSTS_TERMS], const double terms[COSTS_TERMS]) {
    double sum = 0.0;
    for (int i = 0; i < COSTS_TERMS; i++)
        sum += coefficients[i] * terms[i];
    return sum;
}

/* The largest factor between two sets of terms, as a logarithm. */
static double distance(const double a[COSTS_TERMS], const double b[COSTS_TERMS]) {
    double most = 0.0;
    for (int i = 0; i < COSTS_TERMS; i++)
        if (a[i] != b[i])
            most = fmax(most, fabs(log(a[i] / b[i]))); /* infinite where one of them is 0 */
    return most;
}

/* By how much terms may differ until a point says half as much: a factor of 1.5. */
#define ALIKE 0.4

double costs_expect(const costs *c, const modules_technique_note *note, costs_form form,
                    const double coefficients[COSTS_TERMS], const double terms[COSTS_TERMS]) {
    const double sum = costs_sum(coefficients, terms);
    const costs_technique *t = find_near(c, note, form);
    const costs_point *next = NULL;
    double nearest = HUGE_VAL;
    for (uint32_t i = 0; t && t->fitted && i < t->count; i++) {
        const double d = distance(terms, t->points[i].terms);
        if (!next || d < nearest) {
            next = &t->points[i];
            nearest = d;
        }
    }
    const double there = next ? costs_sum(coefficients, next->terms) * c->ns * 1e-6 : 0.0;
    return there > 0.0 ? sum * (1.0 + exp2(-pow(nearest / ALIKE, 2.0)) * (next->ms / there - 1.0))
                       : sum;
}

/* ---- points ---------------------------------------------------------------------------------- */

#define MOST_FRAMES 16u /* that a mean goes back: drivers and machines change */

static costs_technique *add_technique(costs *c, const char *name) {
    if (c->count == COSTS_MOST_TECHNIQUES || strlen(name) >= sizeof c->techniques->name)
        return NULL;
    costs_technique *at = base_realloc(c->techniques, (size_t)c->count + 1, sizeof *at);
    if (!at)
        return NULL;
    c->techniques = at;
    at += c->count++;
    *at = (costs_technique){0};
    memcpy(at->name, name, strlen(name));
    return at;
}

static int same(const double a[COSTS_TERMS], const double b[COSTS_TERMS]) {
    for (int i = 0; i < COSTS_TERMS; i++)
        if (!(fabs(a[i] - b[i]) <= 1e-9 * fmax(a[i], b[i])))
            return 0;
    return 1;
}

int costs_add(costs *c, const char *name, const double terms[COSTS_TERMS], double ms) {
    int sound = isfinite(ms) && ms > 0.0;
    for (int i = 0; i < COSTS_TERMS; i++)
        sound = sound && isfinite(terms[i]) && terms[i] >= 0.0;
    costs_technique *t = sound ? find(c, name) : NULL;
    if (sound && !t)
        t = add_technique(c, name);
    if (!t)
        return 0;
    for (uint32_t i = 0; i < t->count; i++) {
        costs_point *p = &t->points[i];
        if (!same(p->terms, terms))
            continue;
        p->frames += p->frames < MOST_FRAMES;
        p->ms += (ms - p->ms) / p->frames;
        return 1;
    }
    if (t->count == COSTS_MOST_POINTS)
        memmove(t->points, t->points + 1, --t->count * sizeof *t->points);
    costs_point *p = &t->points[t->count++];
    *p = (costs_point){.ms = ms, .frames = 1};
    memcpy(p->terms, terms, sizeof p->terms);
    return 1;
}

int costs_copy(const costs *from, costs *to) {
    costs_technique *techniques = base_calloc((size_t)from->count + 1, sizeof *techniques);
    if (!techniques)
        return 0;
    if (from->count > 0)
        memcpy(techniques, from->techniques, from->count * sizeof *techniques);
    *to = *from;
    to->techniques = techniques;
    return 1;
}

void costs_free(costs *c) {
    free(c->techniques);
    *c = (costs){0};
}

/* ---- the fit --------------------------------------------------------------------------------- */

/* Weight of the module's coefficients, in points. */
#define PRIOR  1e-3
#define ROUNDS 20000

/* The scale in ms that makes coefficients explain the points best, in relative terms; 0: none. */
static double scale_of(const costs_technique *t, const double coefficients[COSTS_TERMS]) {
    double square = 0.0, sum = 0.0;
    for (uint32_t i = 0; i < t->count; i++) {
        const double a = costs_sum(coefficients, t->points[i].terms) / t->points[i].ms;
        square += a * a;
        sum += a;
    }
    const double scale = sum / square;
    return square > 0.0 && isfinite(scale) ? scale : 0.0;
}

/* Least squares under x >= 0, by coordinate descent on the normal equations: rows are the points
 * divided by their times, columns are scaled to length 1; then the pull towards the module's. */
static void fit_points(const costs_technique *t, const double prior[COSTS_TERMS],
                       double x[COSTS_TERMS]) {
    double length[COSTS_TERMS] = {0}, square[COSTS_TERMS][COSTS_TERMS] = {{0}},
           right[COSTS_TERMS] = {0}, y[COSTS_TERMS];
    for (int j = 0; j < COSTS_TERMS; j++) {
        for (uint32_t i = 0; i < t->count; i++)
            length[j] += pow(t->points[i].terms[j] / t->points[i].ms, 2.0);
        length[j] = sqrt(length[j]);
    }
    for (uint32_t i = 0; i < t->count; i++)
        for (int j = 0; j < COSTS_TERMS; j++) {
            const double a = t->points[i].terms[j] / t->points[i].ms;
            if (!(length[j] > 0.0))
                continue;
            right[j] += a / length[j];
            for (int k = 0; k < COSTS_TERMS; k++)
                if (length[k] > 0.0)
                    square[j][k] +=
                        a / length[j] * (t->points[i].terms[k] / t->points[i].ms / length[k]);
        }
    for (int j = 0; j < COSTS_TERMS; j++) {
        y[j] = prior[j] * length[j];
        square[j][j] += PRIOR;
        right[j] += PRIOR * y[j];
    }
    double moved = 1.0;
    for (int round = 0; round < ROUNDS && moved > 1e-12; round++) {
        moved = 0.0;
        for (int j = 0; j < COSTS_TERMS; j++) {
            double rest = right[j];
            for (int k = 0; k < COSTS_TERMS; k++)
                rest -= k == j ? 0.0 : square[j][k] * y[k];
            const double next = fmax(rest / square[j][j], 0.0);
            moved = fmax(moved, fabs(next - y[j]));
            y[j] = next;
        }
    }
    for (int j = 0; j < COSTS_TERMS; j++) /* no point says anything about a column of zeros */
        x[j] = length[j] > 0.0 ? y[j] / length[j] : prior[j];
}

static double residual_of(const costs_technique *t, const double x[COSTS_TERMS]) {
    double sum = 0.0;
    for (uint32_t i = 0; i < t->count; i++)
        sum += pow(costs_sum(x, t->points[i].terms) / t->points[i].ms - 1.0, 2.0);
    return sqrt(sum / t->count);
}

/* In ms; 1 when it is sound. */
static int fit_technique(costs_technique *t, const modules_technique_note *note) {
    double prior[COSTS_TERMS] = {0}, *x = t->coefficients;
    const double scale = costs_of_module(note, prior) ? scale_of(t, prior) : 0.0;
    for (int j = 0; j < COSTS_TERMS; j++)
        prior[j] *= scale;
    fit_points(t, prior, x);
    t->error = residual_of(t, x);
    int sound = isfinite(t->error);
    for (int j = 0; j < COSTS_TERMS; j++)
        sound = sound && isfinite(x[j]);
    return sound;
}

static const modules_technique_note *note_of(const modules_note *const *notes, uint32_t count,
                                             const char *name) {
    const size_t length = strcspn(name, ".");
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < notes[i]->technique_count; k++)
            if (strncmp(notes[i]->techniques[k].id, name, length) == 0 &&
                strlen(notes[i]->techniques[k].id) == length)
                return &notes[i]->techniques[k];
    return NULL;
}

static int ascending(const void *a, const void *b) {
    const double left = *(const double *)a, right = *(const double *)b;
    return left < right ? -1 : left > right;
}

/* In ms. */
static double unit_of(const costs *c, const modules_note *const *notes, uint32_t count) {
    double scales[COSTS_MOST_TECHNIQUES], coefficients[COSTS_TERMS];
    uint32_t known = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        const modules_technique_note *note = note_of(notes, count, c->techniques[i].name);
        if (!note || !costs_of_module(note, coefficients) || c->techniques[i].count == 0)
            continue;
        const double scale = scale_of(&c->techniques[i], coefficients);
        if (scale > 0.0 && costs_is_unit(note))
            return scale;
        if (scale > 0.0)
            scales[known++] = scale;
    }
    qsort(scales, known, sizeof *scales, ascending);
    return known == 0 ? 0.0 : 0.5 * (scales[(known - 1) / 2] + scales[known / 2]);
}

void costs_fit(costs *c, const modules_note *const *notes, uint32_t count) {
    const double unit = unit_of(c, notes, count);
    c->ns = unit * 1e6;
    for (uint32_t i = 0; i < c->count; i++) {
        costs_technique *t = &c->techniques[i];
        const modules_technique_note *note = note_of(notes, count, t->name);
        t->fitted = unit > 0.0 && note && t->count > 0 && (uint32_t)fit_technique(t, note);
        for (int j = 0; j < COSTS_TERMS && t->fitted; j++)
            t->coefficients[j] /= unit;
    }
}
