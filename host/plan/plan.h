/* SPDX-License-Identifier: MIT
 *
 * The plan: which effects are active, which techniques run, in which order and with which settings,
 * and why each other one was left out. A pure function of its input: no GPU, no file, no dlopen, no
 * globals. Third noun of scene -> demand -> plan -> frame -> fragments -> image.
 *
 * Modules are their notes (modules/modules.h): data, read from the files without opening them.
 */
#ifndef STRATA_HOST_PLAN_H
#define STRATA_HOST_PLAN_H

#include <jansson.h>

#include "modules/modules.h"
#include "plan/costs.h"
#include "plan/demand.h"

#define PLAN_MAX_FIELDS  16u
#define PLAN_MAX_PLANES  (STRATA_MAX_PLANES - 2u) /* of payload: beside keys and links */
#define PLAN_NO_COST     (-1.0)
#define PLAN_RAISE_EXACT 5u

/* ---- input ----------------------------------------------------------------------------------- */

/* A technique that may not be used: it failed before, with this reason. */
typedef struct plan_exclusion {
    const char *technique, *reason;
} plan_exclusion;

/* Everything is borrowed; the notes must outlive the plan. Zero = default. */
typedef struct plan_input {
    const demand *demand;
    const modules_note *const *modules;
    uint32_t module_count;
    uint32_t setting_count;
    const strata_scene_stats *stats;
    /* Facts of the device. NULL: no device is known yet; what techniques need is then taken as
     * given, and the plan says so. */
    uint64_t (*fact)(void *user, const char *id);
    void *user;
    const char *use;             /* "id,id" or NULL */
    const char *effects;         /* "auto" (or NULL), "none", "id,id" */
    const char *const *settings; /* "ID.KNOB=VALUE"; of a repeated one the last counts */
    const plan_exclusion *exclusions;
    uint32_t exclusion_count;
    uint32_t samples;        /* sub-pixels a pixel, 0 = 1 */
    uint32_t need_fragments; /* 1: fragments/1 with every fragment is asked for (deep output) */
    uint32_t raise;      /* times that the tolerance was missed; PLAN_RAISE_EXACT: the exact way */
    double tolerance;    /* largest certified error accepted; 0 = exact techniques */
    uint64_t memory;     /* bytes techniques may take, 0 = unknown */
    const costs *costs;  /* as measured on this device; NULL: the modules' own */
    double budget;       /* ms that a frame may take, 0 = any; not under a tolerance */
    double beside;       /* ms of that which go to other things than passes */
    double ns;           /* of a blended fragment, as frames before took it; 0 = as `costs` say */
    uint32_t least_late; /* 1: frames that keep the least were measured, and miss the budget */
    uint32_t late; /* bit i: frames that keep all at STRATA_PAYLOAD_ i were measured, and miss the
                      budget */
} plan_input;

/* ---- output ---------------------------------------------------------------------------------- */

typedef struct plan_effect {
    const modules_effect_note *effect;
    uint32_t called_for; /* 1: the scene calls for it */
    uint32_t active;     /* 1: in this frame */
    uint32_t forced;     /* 1: switched on or off by the user against the scene */
    uint32_t index;      /* of active ones: 0, 1, ... in the order of ids; the payload field "id" */
    char evidence[192];  /* "" when nothing calls for it */
    char reason[256];
} plan_effect;

typedef struct plan_technique {
    const modules_technique_note *technique;
    double *values;           /* settings.values */
    strata_settings settings; /* every knob resolved, in the order of the technique's knobs */
    double cost;              /* in blended fragments; PLAN_NO_COST when unknown */
    uint32_t points;          /* measured ones that it rests on; 0: the module's coefficients */
    char reason[256];
} plan_technique;

typedef struct plan_left_out {
    const modules_technique_note *technique;
    double cost; /* of the cheapest way to use it; PLAN_NO_COST when it was not compared */
    uint32_t points;
    char reason[256];
} plan_left_out;

/* Where one channel of a field lies in a record. */
typedef struct plan_channel {
    uint32_t word;  /* 32-bit word, counted over the planes in order */
    uint32_t plane; /* StrataPayload<plane> */
    uint32_t part;  /* word within that plane: 0 (x) or 1 (y) */
    uint32_t bit;   /* lowest bit within the word */
    uint32_t bits;  /* 32 (float), 16 (half) or 8 (unorm) */
} plan_channel;

typedef struct plan_field {
    char name[64];
    uint32_t channels; /* 1..4 */
    uint32_t exact;    /* 1: 32 bits whatever the payload's precision */
    plan_channel at[4];
} plan_field;

/* A record's payload: the union of the active effects' fields, plus "id" when there are several.
 * Fields stand in the order of the active effects and of their declarations; words are filled with
 * 32-bit channels first, then with the narrower ones, so that none straddles a word. */
typedef struct plan_payload {
    uint32_t precision; /* STRATA_PAYLOAD_* */
    uint32_t field_count;
    plan_field fields[PLAN_MAX_FIELDS];
    uint32_t words;
    uint32_t plane_count;
    uint32_t plane_strides[STRATA_MAX_PLANES]; /* bytes, 8 but for an odd last word's 4 */
} plan_payload;

typedef struct plan {
    plan_effect *effects; /* all installed, ordered by id */
    uint32_t effect_count, active_effects;
    plan_technique *techniques; /* in the order in which they run */
    uint32_t technique_count;
    plan_left_out *left_out; /* every other installed technique, ordered by stage, then id */
    uint32_t left_out_count;
    char **warnings;
    uint32_t warning_count;
    uint32_t transparent; /* 1: some technique folds transparent fragments; else the rest is zero */
    uint32_t captures;    /* 1: through fragments/1 */
    const modules_technique_note *image; /* fills image/1; NULL when a pixel has one sample */
    uint32_t layout;                     /* STRATA_FRAGMENTS_* */
    uint32_t nearest; /* k of what promises the nearest k of a pixel; 0 = all, or no such promise */
    uint32_t clipped; /* 1: a clip technique hides what lies behind them */
    uint32_t transmittance_channels; /* 1 or 3 */
    plan_payload payload;
    uint32_t bytes_per_fragment; /* of a record in fragments/1, 0 when nothing is captured */
    uint32_t expected_bands;     /* that the estimated fragments take in the memory and the storage
                                    range there is; 0 when nothing is captured */
    /* Under a budget what trades time for accuracy: a knob of this one, NULL when none does. */
    const modules_technique_note *turned;
    uint32_t turned_knob;
    double turned_least, turned_most;
    double turned_each;       /* what a step of the knob costs; 0: unknown */
    double turned_exact;      /* from there on an exact way is expected to cost no more; 0: never */
    double cost;              /* of all that runs, PLAN_NO_COST when unknown */
    double ms;                /* that it is expected to take; PLAN_NO_COST when unknown */
    char measured_on[256];    /* device that `points` are of, "" when nothing was measured */
    strata_scene_stats stats; /* as given */
    demand demand;            /* as given */
} plan;

/* Makes a plan. INVALID_ARGUMENT: the user asked for what does not exist or does not fit together;
 * the line lists what does. UNSUPPORTED: no technique installed can do what is required. */
strata_result plan_make(const plan_input *input, plan **out, base_error *err);
void plan_free(plan *p); /* NULL is fine */

/* The first half alone, for what must be known before the statistics: which materials of the scene
 * are drawn as transparent. out: one byte a material. Reads demand, modules, effects. */
strata_result plan_transparent_materials(const plan_input *input, const scene *s,
                                         unsigned char *out, base_error *err);

/* The active effect that emits for this material: of those that it calls for, the one of highest
 * priority (then of the first id); NULL: it is drawn as opaque. */
const plan_effect *plan_material_effect(const plan *p, const scene_material *material);

/* NULL when that technique does not run. */
const plan_technique *plan_find(const plan *p, const char *id);

/* In which its techniques hold fragments. */
costs_form plan_form(const plan *p);

/* The knob that is turned, and turning it: `nearest` and what is expected follow, the share of what
 * resolves counted as the holder's. */
double plan_turned(const plan *p); /* 0 when there is none */
void plan_turn(plan *p, double value);
/* Takes all of a later plan that runs the same techniques with the same settings for the same
 * effects. Those stay where they are, for others hold pointers to them; the later plan gets what is
 * replaced. */
void plan_expect(plan *p, plan *later);

/* Cost as a multiple of the floor, blending each transparent fragment once; PLAN_NO_COST when
 * unknown or when there are no fragments. */
double plan_floors(const plan *p, double cost);

/* Payload of these effects at this precision (payload.c). INVALID_ARGUMENT: two effects disagree
 * about a field; OVERFLOW: more fields, channels or planes than a record can have. */
strata_result plan_payload_make(const modules_effect_note *const *effects, uint32_t count,
                                uint32_t precision, plan_payload *out, base_error *err);

/* ---- as JSON (json.c); the shapes are in the guide. New references; NULL when out of memory. ---
 */
json_t *plan_json(const plan *p);         /* one object; scene, size and device are the caller's */
json_t *plan_json_effects(const plan *p); /* its "effects", also the account's */
json_t *plan_json_techniques(const plan *p); /* its "techniques", the account's "plan" */
json_t *plan_json_modules(const modules_note *const *notes, uint32_t count); /* list's "modules" */

#endif
