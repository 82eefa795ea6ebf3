/* SPDX-License-Identifier: MIT
 *
 * What techniques cost: the modules' coefficients (strata_cost_model), and in their place those
 * that were fitted to times measured on a device. Points are kept for each device in the cache; the
 * fit is a pure function of points and notes, and the plan a pure function of the fit.
 *
 * The unit is blending one fragment. A technique's cost is the sum of its coefficients times its
 * terms, what a frame gives it to work on; `ns` says how long the unit takes.
 */
#ifndef STRATA_HOST_COSTS_H
#define STRATA_HOST_COSTS_H

#include "modules/modules.h"
#include "strata/scene.h"

#define COSTS_MOST_POINTS     48u /* of a technique; the oldest goes */
#define COSTS_MOST_TECHNIQUES 256u
#define COSTS_NAME            96u /* bytes of a costs_name */

/* Those of strata_cost_model in its order, and one more. */
typedef enum costs_term {
    COSTS_FRAME,
    COSTS_PIXEL,
    COSTS_FRAGMENT,
    COSTS_FRAGMENT_LOG2_DEPTH,
    COSTS_TRIANGLE,
    COSTS_DEPTH,
    COSTS_DEPTH_PIXEL,
    COSTS_DEPTH_FRAGMENT,
    COSTS_DEPTH_TRIANGLE,
    COSTS_OBJECT,
    COSTS_KEPT, /* fragments kept by what keeps the nearest; modules say nothing of it */
    COSTS_TERMS
} costs_term;

typedef struct costs_point {
    double terms[COSTS_TERMS];
    double ms;       /* of the device, a mean */
    uint32_t frames; /* that were measured */
} costs_point;

typedef struct costs_technique {
    char name[COSTS_NAME]; /* see costs_name */
    costs_point points[COSTS_MOST_POINTS];
    uint32_t count;
    uint32_t fitted;                  /* 1: `coefficients` stand in for the module's */
    double coefficients[COSTS_TERMS]; /* all >= 0 */
    double error;                     /* root mean square of the points' relative residuals */
} costs_technique;

typedef struct costs {
    char device[256]; /* that it was measured on */
    costs_technique *techniques;
    uint32_t count;
    double ns; /* of a blended fragment; 0: unknown */
} costs;

/* How fragments come to what keeps them, and are held between that and what folds them: another
 * work. Zero is the form of the modules' coefficients. */
typedef struct costs_form {
    uint32_t layout;  /* STRATA_FRAGMENTS_* of fragments/1 */
    uint32_t payload; /* STRATA_PAYLOAD_* of a record */
    uint32_t clipped; /* 1: what lies behind the nearest was hidden before */
} costs_form;

#define COSTS_CLIPPED  2u
#define COSTS_LAYOUTS  2u
#define COSTS_PAYLOADS 3u

const char *
costs_payload_name(uint32_t payload); /* "float", "half", "unorm8"; below COSTS_PAYLOADS */

/* ---- terms ----------------------------------------------------------------------------------- */

/* What a technique of this note works on in a frame. `nearest`: fragments a pixel that the frame's
 * holder (the capture or stream) keeps, 0 = all. */
void costs_terms(const modules_technique_note *note, const strata_scene_stats *stats,
                 double nearest, double terms[COSTS_TERMS]);

/* The module's own; 0: it has none. */
int costs_of_module(const modules_technique_note *note, double coefficients[COSTS_TERMS]);

/* Whether it is the unit itself: one for each fragment, and nothing else. Such a one is a measure,
 * not a way to make pictures. */
int costs_is_unit(const modules_technique_note *note);

/* What it is measured as: its id, "abuffer", and what of the form touches it and is not the
 * modules': "abuffer.linked.half". */
void costs_name(const modules_technique_note *note, costs_form form, char name[COSTS_NAME]);

/* Those to plan with: measured where there are any (c may be NULL), in this form, clipped
 * or not, or else in the modules'. Returns the number of points that they rest on, 0 for the
 * module's, -1 when there are none at all. */
int costs_of(const costs *c, const modules_technique_note *note, costs_form form,
             double coefficients[COSTS_TERMS]);

/* Whether it was measured in this very form. */
int costs_knows(const costs *c, const modules_technique_note *note, costs_form form);

/* Coefficients times terms; and, where the technique was measured on terms like these, as much more
 * or less as it took there than the coefficients say: all of it for the same terms. */
double costs_expect(const costs *c, const modules_technique_note *note, costs_form form,
                    const double coefficients[COSTS_TERMS], const double terms[COSTS_TERMS]);
double costs_sum(const double coefficients[COSTS_TERMS], const double terms[COSTS_TERMS]);

/* The knob that says how many fragments a pixel keep their place: an INT that trades accuracy.
 * Index or -1. */
int costs_count_knob(const modules_technique_note *note);

/* The knob that says in which precision it stores payloads, a CHOICE of STRATA_PAYLOAD_* that is
 * named `payload`. Index or -1. */
int costs_payload_knob(const modules_technique_note *note);

/* ---- points ---------------------------------------------------------------------------------- */

/* Takes a measurement of what costs_name says; equal terms share a point. 0: it is no measurement,
 * or there is no room. */
int costs_add(costs *c, const char *name, const double terms[COSTS_TERMS], double ms);

/* Fits all techniques of which there are notes, and the unit: that of the technique which is the
 * unit, else of the scale that the modules' coefficients have in the median. Coefficients are not
 * negative; the sum of squared relative residuals is least, and where few points leave them open
 * they stay near the module's, scaled alike. */
void costs_fit(costs *c, const modules_note *const *notes, uint32_t count);

void costs_free(costs *c);                    /* what it holds */
int costs_copy(const costs *from, costs *to); /* *to was empty; 0: out of memory */

/* ---- files (costs_file.c) -------------------------------------------------------------------- */

/* Points of this device as the folder has them; empty where there are none. What does not check out
 * is ignored as a whole, with a line in the log. *c is the caller's. OUT_OF_HOST_MEMORY. */
strata_result costs_load(const char *folder, const char *device, costs *c, base_error *err);
/* Beside, then renamed. IO. */
strata_result costs_save(const char *folder, const costs *c, base_error *err);

#endif
