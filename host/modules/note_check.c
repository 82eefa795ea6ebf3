/* SPDX-License-Identifier: MIT
 *
 * What must hold of a module's declarations wherever they come from: syntax of ids, ranges of
 * numbers, no duplicates, a version both sides can live with. The plan relies on it.
 */
#include "modules/modules_internal.h"

#include <math.h>
#include <string.h>

#define TEXT_MAX 4096 /* bytes of a title, a reference, a formula */
#define LAYOUTS  (1u << STRATA_FRAGMENTS_CONTIGUOUS | 1u << STRATA_FRAGMENTS_LINKED)
#define FLAGS    (STRATA_EFFECT_SEQUENTIAL | STRATA_EFFECT_AFFINE | STRATA_EFFECT_COVERS)

static int is_lower(char c) {
    return c >= 'a' && c <= 'z';
}

static int is_digit(char c) {
    return c >= '0' && c <= '9';
}

/* [a-z][a-z0-9_]* and the characters of `more`, at most MODULES_ID_MAX of them. */
static int is_id(const char *text, size_t length, const char *more) {
    if (length == 0 || length > MODULES_ID_MAX || !is_lower(text[0]))
        return 0;
    for (size_t i = 1; i < length; i++)
        if (!is_lower(text[i]) && !is_digit(text[i]) && text[i] != '_' && !strchr(more, text[i]))
            return 0;
    return 1;
}

/* NAME/VERSION, "color/1". */
static int is_slot(const char *text) {
    const char *slash = strchr(text, '/');
    if (!slash || !is_id(text, (size_t)(slash - text), ".") || strlen(slash) > 6 || !slash[1])
        return 0;
    for (const char *c = slash + 1; *c; c++)
        if (!is_digit(*c))
            return 0;
    return 1;
}

/* A field's name in GLSL. */
static int is_glsl_name(const char *text) {
    size_t length = strlen(text);
    if (length == 0 || length > MODULES_ID_MAX || is_digit(text[0]) ||
        strncmp(text, "gl_", 3) == 0 || strstr(text, "__"))
        return 0;
    for (const char *c = text; *c; c++)
        if (!is_lower(*c) && !(*c >= 'A' && *c <= 'Z') && !is_digit(*c) && *c != '_')
            return 0;
    return 1;
}

static strata_result check_id(const char *what, const char *id, const char *more, base_error *err) {
    if (id && is_id(id, strlen(id), more))
        return STRATA_OK;
    return base_fail(err, STRATA_ERROR_MODULE,
                     "%s: \"%.80s\" is not an id (a-z, then a-z, 0-9, _, at most %d characters)",
                     what, id ? id : "", MODULES_ID_MAX);
}

static strata_result check_text(const char *owner, const char *what, const char *text, int required,
                                base_error *err) {
    if (!text)
        return required ? base_fail(err, STRATA_ERROR_MODULE, "%s: %s is missing", owner, what)
                        : STRATA_OK;
    return strlen(text) <= TEXT_MAX
               ? STRATA_OK
               : base_fail(err, STRATA_ERROR_MODULE, "%s: %s is longer than %d bytes", owner, what,
                           TEXT_MAX);
}

static strata_result check_count(const char *owner, const char *what, uint32_t count,
                                 base_error *err) {
    return count <= MODULES_ARRAY_MAX
               ? STRATA_OK
               : base_fail(err, STRATA_ERROR_MODULE, "%s: %s is %u, at most %d", owner, what, count,
                           MODULES_ARRAY_MAX);
}

static strata_result check_choices(const char *owner, const strata_knob *knob, base_error *err) {
    uint32_t count = 0;
    for (const char *const *choice = knob->choices; choice && *choice; choice++, count++) {
        if (count == MODULES_ARRAY_MAX)
            return check_count(owner, "the number of choices", count + 1, err);
        if (check_id(owner, *choice, "-", err) != STRATA_OK)
            return STRATA_ERROR_MODULE;
        for (uint32_t i = 0; i < count; i++)
            if (strcmp(knob->choices[i], *choice) == 0)
                return base_fail(err, STRATA_ERROR_MODULE, "%s: knob %s has two choices \"%s\"",
                                 owner, knob->name, *choice);
    }
    if (count == 0 || !(knob->preset >= 0.0 && knob->preset < (double)count) ||
        knob->preset != floor(knob->preset))
        return base_fail(err, STRATA_ERROR_MODULE,
                         "%s: knob %s needs choices, and the index of one as its preset", owner,
                         knob->name);
    return STRATA_OK;
}

static strata_result check_knob(const char *owner, const strata_knob *knob, base_error *err) {
    if (check_id(owner, knob->name, "", err) != STRATA_OK ||
        check_text(owner, "title of a knob", knob->title, 1, err) != STRATA_OK ||
        check_text(owner, "unit of a knob", knob->unit, 0, err) != STRATA_OK)
        return STRATA_ERROR_MODULE;
    if (knob->type > STRATA_KNOB_CHOICE)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: knob %s has the unknown type %u", owner,
                         knob->name, knob->type);
    if (!isfinite(knob->minimum) || !isfinite(knob->maximum) || !isfinite(knob->preset))
        return base_fail(err, STRATA_ERROR_MODULE, "%s: knob %s has a number that is not finite",
                         owner, knob->name);
    if (knob->trades_accuracy > 1)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: knob %s: trades_accuracy is 0 or 1", owner,
                         knob->name);
    if (knob->type == STRATA_KNOB_CHOICE)
        return check_choices(owner, knob, err);
    if (!(knob->minimum <= knob->preset && knob->preset <= knob->maximum))
        return base_fail(err, STRATA_ERROR_MODULE,
                         "%s: knob %s: the preset %g is not within [%g, %g]", owner, knob->name,
                         knob->preset, knob->minimum, knob->maximum);
    if (knob->type == STRATA_KNOB_INT &&
        (knob->minimum != floor(knob->minimum) || knob->maximum != floor(knob->maximum) ||
         knob->preset != floor(knob->preset) || fabs(knob->minimum) > 0x1p53 ||
         fabs(knob->maximum) > 0x1p53))
        return base_fail(err, STRATA_ERROR_MODULE,
                         "%s: knob %s is an integer, its limits and preset are not", owner,
                         knob->name);
    return STRATA_OK;
}

static strata_result check_slot(const char *owner, const strata_slot_use *slot, base_error *err) {
    if (!slot->slot || !is_slot(slot->slot))
        return base_fail(err, STRATA_ERROR_MODULE, "%s: \"%.80s\" is not a slot (NAME/VERSION)",
                         owner, slot->slot ? slot->slot : "");
    if (slot->use < STRATA_SLOT_CONSUMES || slot->use > STRATA_SLOT_UPDATES)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: slot %s has the unknown use %u", owner,
                         slot->slot, slot->use);
    const int fragments = strcmp(slot->slot, "fragments/1") == 0;
    if (fragments && slot->layouts == 0)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: slot %s names no layout", owner,
                         slot->slot);
    if (slot->layouts & ~(fragments ? LAYOUTS : 0u))
        return base_fail(err, STRATA_ERROR_MODULE, "%s: slot %s names the unknown layouts 0x%x",
                         owner, slot->slot, slot->layouts);
    if (slot->optional > 1)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: slot %s: optional is 0 or 1", owner,
                         slot->slot);
    return STRATA_OK;
}

/* Ids of facts, features and self-tests: "selftest.ordered_rmw". */
static strata_result check_facts(const char *owner, const char *const *facts, base_error *err) {
    uint32_t count = 0;
    for (; facts && *facts; facts++) {
        if (check_count(owner, "the number of facts", ++count, err) != STRATA_OK ||
            check_id(owner, *facts, ".", err) != STRATA_OK)
            return STRATA_ERROR_MODULE;
    }
    return STRATA_OK;
}

static strata_result check_promises(const char *owner, const strata_promises *promises,
                                    const strata_cost_model *cost, base_error *err) {
    if (!promises || !cost)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: %s is missing", owner,
                         promises ? "cost" : "promises");
    if (promises->order > STRATA_ORDER_APPROXIMATE ||
        promises->determinism > STRATA_DETERMINISM_BOUNDED)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: an unknown promise", owner);
    const double values[] = {cost->frame,
                             cost->per_pixel,
                             cost->per_fragment,
                             cost->per_fragment_log2_depth,
                             cost->per_triangle,
                             cost->per_depth,
                             cost->per_depth_pixel,
                             cost->per_depth_fragment,
                             cost->per_depth_triangle,
                             cost->per_object};
    for (size_t i = 0; i < BASE_COUNT(values); i++)
        if (!isfinite(values[i]) || values[i] < 0.0)
            return base_fail(err, STRATA_ERROR_MODULE, "%s: a cost is negative or not finite",
                             owner);
    return check_text(owner, "memory", promises->memory, 0, err);
}

/* What accounts and settings call the host's own. */
static strata_result check_reserved_id(const char *id, base_error *err) {
    static const char *const reserved[] = {"host", "scene", "frame"};
    for (size_t i = 0; i < BASE_COUNT(reserved); i++)
        if (strcmp(id, reserved[i]) == 0)
            return base_fail(err, STRATA_ERROR_MODULE, "%s: no technique may have this id", id);
    return STRATA_OK;
}

/* Knobs that the host sets, as technique.h has them: the choices are numbers of the ABI. */
static strata_result check_reserved_knob(const modules_technique_note *t, const strata_knob *knob,
                                         base_error *err) {
    static const char *const layouts[] = {"contiguous", "linked", NULL}, *const payloads[] = {
                                                                             "float", "half",
                                                                             "unorm8", NULL};
    const int is_layout = strcmp(knob->name, "mode") == 0 && strcmp(t->stage, "capture") == 0;
    const char *const *choices = is_layout                            ? layouts
                                 : strcmp(knob->name, "payload") == 0 ? payloads
                                                                      : NULL;
    if (!choices)
        return STRATA_OK;
    uint32_t same = 0;
    while (knob->type == STRATA_KNOB_CHOICE && choices[same] && knob->choices[same] &&
           strcmp(choices[same], knob->choices[same]) == 0)
        same++;
    if (same == 0 || knob->choices[same])
        return base_fail(err, STRATA_ERROR_MODULE, "%s: knob %s is a choice of %s, %s%s%s", t->id,
                         knob->name, choices[0], choices[1], choices[2] ? ", " : "",
                         choices[2] ? choices[2] : "");
    return STRATA_OK;
}

static strata_result check_technique(const modules_technique_note *t, base_error *err) {
    static const char *const stages[] = {"draws",   "surface", "clip",   "capture",
                                         "resolve", "stream",  "filter", "certificate"};
    if (check_id("technique", t->id, "", err) != STRATA_OK ||
        check_reserved_id(t->id, err) != STRATA_OK ||
        check_text(t->id, "title", t->title, 1, err) != STRATA_OK ||
        check_text(t->id, "reference", t->reference, 0, err) != STRATA_OK ||
        check_text(t->id, "stage", t->stage, 1, err) != STRATA_OK ||
        check_count(t->id, "slot_count", t->slot_count, err) != STRATA_OK ||
        check_count(t->id, "knob_count", t->knob_count, err) != STRATA_OK ||
        check_promises(t->id, t->promises, t->cost, err) != STRATA_OK ||
        check_facts(t->id, t->needs, err) != STRATA_OK ||
        check_facts(t->id, t->prefers, err) != STRATA_OK)
        return STRATA_ERROR_MODULE;
    size_t stage = 0;
    while (stage < BASE_COUNT(stages) && strcmp(stages[stage], t->stage) != 0)
        stage++;
    if (stage == BASE_COUNT(stages))
        return base_fail(err, STRATA_ERROR_MODULE, "%s: unknown stage \"%.80s\"", t->id, t->stage);
    for (uint32_t i = 0; i < t->slot_count; i++) {
        if (check_slot(t->id, t->slots[i], err) != STRATA_OK)
            return STRATA_ERROR_MODULE;
        for (uint32_t j = 0; j < i; j++)
            if (strcmp(t->slots[i]->slot, t->slots[j]->slot) == 0)
                return base_fail(err, STRATA_ERROR_MODULE, "%s: names slot %s twice", t->id,
                                 t->slots[i]->slot);
    }
    for (uint32_t i = 0; i < t->knob_count; i++) {
        if (check_knob(t->id, t->knobs[i], err) != STRATA_OK ||
            check_reserved_knob(t, t->knobs[i], err) != STRATA_OK)
            return STRATA_ERROR_MODULE;
        for (uint32_t j = 0; j < i; j++)
            if (strcmp(t->knobs[i]->name, t->knobs[j]->name) == 0)
                return base_fail(err, STRATA_ERROR_MODULE, "%s: has two knobs %s", t->id,
                                 t->knobs[i]->name);
    }
    return STRATA_OK;
}

static strata_result check_payload(const modules_effect_note *e, base_error *err) {
    for (uint32_t i = 0; i < e->field_count; i++) {
        const strata_field *field = e->payload[i];
        if (!field->name || !is_glsl_name(field->name))
            return base_fail(err, STRATA_ERROR_MODULE, "%s: field \"%.80s\" is not a GLSL name",
                             e->id, field->name ? field->name : "");
        if (field->channels < 1 || field->channels > 4 || field->exact > 1)
            return base_fail(err, STRATA_ERROR_MODULE,
                             "%s: field %s: channels are 1..4, exact is 0 or 1", e->id,
                             field->name);
        for (uint32_t j = 0; j < i; j++)
            if (strcmp(e->payload[j]->name, field->name) == 0)
                return base_fail(err, STRATA_ERROR_MODULE, "%s: has two fields %s", e->id,
                                 field->name);
    }
    return STRATA_OK;
}

static strata_result check_effect(const modules_effect_note *e, base_error *err) {
    if (check_id("effect", e->id, "", err) != STRATA_OK ||
        check_text(e->id, "title", e->title, 1, err) != STRATA_OK ||
        check_text(e->id, "reference", e->reference, 0, err) != STRATA_OK ||
        check_count(e->id, "field_count", e->field_count, err) != STRATA_OK ||
        check_count(e->id, "need_count", e->need_count, err) != STRATA_OK ||
        check_payload(e, err) != STRATA_OK)
        return STRATA_ERROR_MODULE;
    if (e->flags & ~FLAGS)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: unknown flags 0x%x", e->id, e->flags);
    if (e->transmittance_channels != 1 && e->transmittance_channels != 3)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: transmittance_channels is 1 or 3, not %u",
                         e->id, e->transmittance_channels);
    for (uint32_t i = 0; i < e->need_count; i++) {
        if (check_id(e->id, e->called_for_by[i]->fact, ".", err) != STRATA_OK)
            return STRATA_ERROR_MODULE;
        if (!isfinite(e->called_for_by[i]->threshold))
            return base_fail(err, STRATA_ERROR_MODULE, "%s: the threshold of %s is not finite",
                             e->id, e->called_for_by[i]->fact);
    }
    return STRATA_OK;
}

strata_result note_check(const modules_note *note, base_error *err) {
    if (check_id("module", note->id, ".-", err) != STRATA_OK ||
        check_text(note->id, "title", note->title, 1, err) != STRATA_OK ||
        check_text(note->id, "version", note->version, 1, err) != STRATA_OK ||
        check_text(note->id, "licence", note->licence, 1, err) != STRATA_OK ||
        check_count(note->id, "technique_count", note->technique_count, err) != STRATA_OK ||
        check_count(note->id, "effect_count", note->effect_count, err) != STRATA_OK)
        return STRATA_ERROR_MODULE;
    if (note->technique_count + note->effect_count == 0)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: offers no technique and no effect",
                         note->id);
    for (uint32_t i = 0; i < note->technique_count; i++) {
        if (check_technique(&note->techniques[i], err) != STRATA_OK)
            return STRATA_ERROR_MODULE;
        for (uint32_t j = 0; j < i; j++)
            if (strcmp(note->techniques[j].id, note->techniques[i].id) == 0)
                return base_fail(err, STRATA_ERROR_MODULE, "%s: has two techniques %s", note->id,
                                 note->techniques[i].id);
    }
    for (uint32_t i = 0; i < note->effect_count; i++) {
        if (check_effect(&note->effects[i], err) != STRATA_OK)
            return STRATA_ERROR_MODULE;
        for (uint32_t j = 0; j < i; j++)
            if (strcmp(note->effects[j].id, note->effects[i].id) == 0)
                return base_fail(err, STRATA_ERROR_MODULE, "%s: has two effects %s", note->id,
                                 note->effects[i].id);
    }
    return STRATA_OK;
}

strata_result note_check_version(uint32_t abi, uint32_t min_host, uint32_t host, base_error *err) {
    if (STRATA_VERSION_MAJOR(abi) != STRATA_VERSION_MAJOR(host))
        return base_fail(err, STRATA_ERROR_VERSION,
                         "built for ABI %u.%u, and this host speaks %u.%u",
                         STRATA_VERSION_MAJOR(abi), STRATA_VERSION_MINOR(abi),
                         STRATA_VERSION_MAJOR(host), STRATA_VERSION_MINOR(host));
    if (min_host > abi)
        return base_fail(err, STRATA_ERROR_VERSION,
                         "asks for a host of at least ABI %u.%u, but was built for %u.%u",
                         STRATA_VERSION_MAJOR(min_host), STRATA_VERSION_MINOR(min_host),
                         STRATA_VERSION_MAJOR(abi), STRATA_VERSION_MINOR(abi));
    if (min_host > host)
        return base_fail(err, STRATA_ERROR_VERSION,
                         "asks for a host of at least ABI %u.%u, and this one speaks %u.%u",
                         STRATA_VERSION_MAJOR(min_host), STRATA_VERSION_MINOR(min_host),
                         STRATA_VERSION_MAJOR(host), STRATA_VERSION_MINOR(host));
    return STRATA_OK;
}
