/* SPDX-License-Identifier: MIT
 *
 * A note as JSON: what strata-note puts into a module, and what the loader compares a descriptor
 * with. Member names are the field names of abi/strata/technique.h and effect.h; a NULL text is
 * left out. Built with jansson, whose numbers do not depend on the locale.
 */
#include "modules/modules_internal.h"

#include <jansson.h>

/* What went wrong on the way; the JSON tree itself is jansson's. */
typedef struct json_writer {
    base_error *err;
    int failed;
} json_writer;

static void json_fail(json_writer *w, strata_result result, const char *key) {
    w->failed = 1;
    base_fail(w->err, result,
              result == STRATA_ERROR_MODULE ? "\"%s\" is not UTF-8 text"
                                            : "out of memory at \"%s\"",
              key);
}

static void json_put(json_writer *w, json_t *object, const char *key, json_t *value) {
    if (json_object_set_new(object, key, value) != 0)
        json_fail(w, STRATA_ERROR_OUT_OF_HOST_MEMORY, key);
}

static void json_put_text(json_writer *w, json_t *object, const char *key, const char *text) {
    if (!text)
        return;
    json_t *value = json_string(text);
    if (value)
        json_put(w, object, key, value);
    else
        json_fail(w, STRATA_ERROR_MODULE, key);
}

static void json_put_u32(json_writer *w, json_t *object, const char *key, uint32_t value) {
    json_put(w, object, key, json_integer((json_int_t)value));
}

static void json_put_real(json_writer *w, json_t *object, const char *key, double value) {
    json_put(w, object, key, json_real(value));
}

/* A NULL-terminated list of texts; left out when NULL. */
static void json_put_texts(json_writer *w, json_t *object, const char *key,
                           const char *const *texts) {
    if (!texts)
        return;
    json_t *array = json_array();
    for (; *texts; texts++)
        if (json_array_append_new(array, json_string(*texts)) != 0)
            json_fail(w, STRATA_ERROR_MODULE, key);
    json_put(w, object, key, array);
}

static json_t *json_append_object(json_writer *w, json_t *array) {
    json_t *object = json_object();
    if (json_array_append_new(array, object) != 0) {
        json_fail(w, STRATA_ERROR_OUT_OF_HOST_MEMORY, "array");
        return NULL;
    }
    return object;
}

static json_t *json_knobs(json_writer *w, const modules_technique_note *technique) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < technique->knob_count; i++) {
        const strata_knob *knob = technique->knobs[i];
        json_t *object = json_append_object(w, array);
        json_put_u32(w, object, "type", knob->type);
        json_put_text(w, object, "name", knob->name);
        json_put_text(w, object, "title", knob->title);
        json_put_text(w, object, "unit", knob->unit);
        json_put_real(w, object, "minimum", knob->minimum);
        json_put_real(w, object, "maximum", knob->maximum);
        json_put_real(w, object, "preset", knob->preset);
        json_put_texts(w, object, "choices", knob->choices);
        json_put_u32(w, object, "trades_accuracy", knob->trades_accuracy);
    }
    return array;
}

static json_t *json_slots(json_writer *w, const modules_technique_note *technique) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < technique->slot_count; i++) {
        const strata_slot_use *slot = technique->slots[i];
        json_t *object = json_append_object(w, array);
        json_put_u32(w, object, "use", slot->use);
        json_put_text(w, object, "slot", slot->slot);
        json_put_u32(w, object, "layouts", slot->layouts);
        json_put_u32(w, object, "optional", slot->optional);
    }
    return array;
}

static json_t *json_promises(json_writer *w, const strata_promises *promises) {
    json_t *object = json_object();
    json_put_u32(w, object, "order", promises->order);
    json_put_u32(w, object, "determinism", promises->determinism);
    json_put_u32(w, object, "largest_depth", promises->largest_depth);
    json_put_text(w, object, "memory", promises->memory);
    return object;
}

static json_t *json_cost(json_writer *w, const strata_cost_model *cost) {
    json_t *object = json_object();
    json_put_real(w, object, "frame", cost->frame);
    json_put_real(w, object, "per_pixel", cost->per_pixel);
    json_put_real(w, object, "per_fragment", cost->per_fragment);
    json_put_real(w, object, "per_fragment_log2_depth", cost->per_fragment_log2_depth);
    json_put_real(w, object, "per_triangle", cost->per_triangle);
    json_put_real(w, object, "per_depth", cost->per_depth);
    json_put_real(w, object, "per_depth_pixel", cost->per_depth_pixel);
    json_put_real(w, object, "per_depth_fragment", cost->per_depth_fragment);
    json_put_real(w, object, "per_depth_triangle", cost->per_depth_triangle);
    json_put_real(w, object, "per_object", cost->per_object);
    return object;
}

static void json_technique(json_writer *w, json_t *object,
                           const modules_technique_note *technique) {
    json_put_text(w, object, "id", technique->id);
    json_put_text(w, object, "title", technique->title);
    json_put_text(w, object, "reference", technique->reference);
    json_put_text(w, object, "stage", technique->stage);
    json_put(w, object, "slots", json_slots(w, technique));
    json_put(w, object, "knobs", json_knobs(w, technique));
    json_put(w, object, "promises", json_promises(w, technique->promises));
    json_put(w, object, "cost", json_cost(w, technique->cost));
    json_put_texts(w, object, "needs", technique->needs);
    json_put_texts(w, object, "prefers", technique->prefers);
}

static void json_effect(json_writer *w, json_t *object, const modules_effect_note *effect) {
    json_put_text(w, object, "id", effect->id);
    json_put_text(w, object, "title", effect->title);
    json_put_text(w, object, "reference", effect->reference);
    json_put_u32(w, object, "flags", effect->flags);
    json_put_u32(w, object, "transmittance_channels", effect->transmittance_channels);
    json_t *payload = json_array();
    for (uint32_t i = 0; i < effect->field_count; i++) {
        json_t *field = json_append_object(w, payload);
        json_put_u32(w, field, "channels", effect->payload[i]->channels);
        json_put_text(w, field, "name", effect->payload[i]->name);
        json_put_u32(w, field, "exact", effect->payload[i]->exact);
    }
    json_put(w, object, "payload", payload);
    json_t *needs = json_array();
    for (uint32_t i = 0; i < effect->need_count; i++) {
        json_t *need = json_append_object(w, needs);
        json_put_text(w, need, "fact", effect->called_for_by[i]->fact);
        json_put_real(w, need, "threshold", effect->called_for_by[i]->threshold);
    }
    json_put(w, object, "called_for_by", needs);
    json_put_u32(w, object, "priority", effect->priority);
}

char *note_json(const modules_note *note, base_error *err) {
    json_writer w = {.err = err};
    json_t *root = json_object();
    json_put_text(&w, root, "id", note->id);
    json_put_text(&w, root, "title", note->title);
    json_put_text(&w, root, "version", note->version);
    json_put_text(&w, root, "licence", note->licence);
    json_put_u32(&w, root, "abi_version", note->abi_version);
    json_put_u32(&w, root, "min_host_version", note->min_host_version);
    json_t *techniques = json_array();
    for (uint32_t i = 0; i < note->technique_count; i++)
        json_technique(&w, json_append_object(&w, techniques), &note->techniques[i]);
    json_put(&w, root, "techniques", techniques);
    json_t *effects = json_array();
    for (uint32_t i = 0; i < note->effect_count; i++)
        json_effect(&w, json_append_object(&w, effects), &note->effects[i]);
    json_put(&w, root, "effects", effects);
    char *text = w.failed ? NULL : json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(17));
    if (!text)
        base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory for a module's note");
    json_decref(root);
    return text;
}
