/* SPDX-License-Identifier: MIT
 *
 * The modules that are installed: found by their ELF notes, planned with as data, opened only when
 * the plan chose one. A note holds what the module's C descriptor says except code and GLSL, so the
 * structs below have the descriptor's field names and share its element structs; the plan reads
 * them (and its tests write them by hand) without a shared object in sight.
 *
 *     scan (files are read, nothing is opened) -> notes -> plan -> open_technique, open_effect
 *
 * Texts and arrays belong to the `modules` they came from. One thread at a time.
 */
#ifndef STRATA_HOST_MODULES_H
#define STRATA_HOST_MODULES_H

#include "base/base.h"
#include "strata/technique.h"

/* Bounds on what a module may declare; more is refused when its note is read. */
#define MODULES_ID_MAX    63 /* characters of an id */
#define MODULES_ARRAY_MAX 64 /* techniques, effects, slots, knobs, choices, fields, needs */

typedef struct modules_note modules_note;

typedef struct modules_technique_note {
    const modules_note *module;
    const char *id;
    const char *title;
    const char *reference;
    const char *stage;
    const strata_slot_use *const *slots;
    uint32_t slot_count;
    uint32_t knob_count;
    const strata_knob *const *knobs;
    const strata_promises *promises;
    const strata_cost_model *cost;
    const char *const *needs;   /* NULL-terminated, or NULL */
    const char *const *prefers; /* NULL-terminated, or NULL */
} modules_technique_note;

/* How a technique uses this slot, as `use` says (0 = in any way); NULL: it does not. */
const strata_slot_use *modules_slot(const modules_technique_note *note, const char *slot,
                                    uint32_t use);

typedef struct modules_effect_note {
    const modules_note *module;
    const char *id;
    const char *title;
    const char *reference;
    uint32_t flags; /* STRATA_EFFECT_* */
    uint32_t transmittance_channels;
    const strata_field *const *payload;
    uint32_t field_count;
    uint32_t need_count;
    const strata_need *const *called_for_by;
    uint32_t priority;
} modules_effect_note;

struct modules_note {
    const char *path; /* of the shared object */
    const char *id;
    const char *title;
    const char *version;
    const char *licence;
    uint32_t abi_version, min_host_version;
    const modules_technique_note *techniques;
    uint32_t technique_count;
    uint32_t effect_count;
    const modules_effect_note *effects;
};

/* A file in the search path that looks like a module and cannot be used. */
typedef struct modules_refusal {
    const char *path;
    const char *reason; /* one line */
} modules_refusal;

typedef struct modules modules;

/* Reads the notes of every *.so in the folders of `path` (':'-separated; NULL = STRATA_MODULE_PATH,
 * else the folder "strata" beside this library). A file that cannot be used is listed as refused
 * and does not fail the scan; of two modules or offers with one id the first found counts. Fails
 * for want of memory, or with NOT_FOUND when a folder that `path` names cannot be read. */
strata_result modules_scan(const char *path, modules **out, base_error *err);

/* Closes what was opened; NULL is fine. Every instance of a technique must be destroyed before. */
void modules_free(modules *m);

/* Usable modules, sorted by id. Notes keep their address until modules_free. */
uint32_t modules_count(const modules *m);
const modules_note *modules_note_at(const modules *m, uint32_t index); /* NULL beyond the count */

/* By the id of the offer itself; NULL when no usable module has it. */
const modules_technique_note *modules_find_technique(const modules *m, const char *id);
const modules_effect_note *modules_find_effect(const modules *m, const char *id);

uint32_t modules_refused_count(const modules *m);
const modules_refusal *modules_refused_at(const modules *m, uint32_t index);

/* Opens the module that offers `id`, unless it is open, and checks it: negotiated version, one
 * descriptor equal to the note, every struct, pointer, id and range. *out lives until modules_free.
 * NOT_FOUND, VERSION, MODULE (the line holds dlerror's text, or what is wrong), OUT_OF_HOST_MEMORY.
 * A module that fails is refused from then on, so that a new plan does without it. */
strata_result modules_open_technique(modules *m, const char *id, const strata_technique **out,
                                     base_error *err);
strata_result modules_open_effect(modules *m, const char *id, const strata_effect **out,
                                  base_error *err);

/* Refuses a module that failed at work: it is no longer counted or found. It stays mapped until
 * modules_free. */
strata_result modules_refuse(modules *m, const char *module_id, const char *reason,
                             base_error *err);

/* The loader's log: ids of the modules that were opened, in order. */
const char *const *modules_opened(const modules *m, uint32_t *count);

#endif
