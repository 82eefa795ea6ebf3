/* SPDX-License-Identifier: MIT
 *
 * JSON -> modules_note: the reverse of note_json.c. Wrong kinds, numbers out of range and long
 * arrays are refused with the member's path named; unknown members are ignored. Also the arena that
 * holds what a note points to.
 */
#include "modules/modules_internal.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

struct note_block {
    note_block *next;
    max_align_t data[];
};

void *note_alloc(note_arena *arena, size_t count, size_t size) {
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) ||
        __builtin_add_overflow(bytes, sizeof(note_block), &bytes))
        return NULL;
    note_block *block = base_calloc(bytes, 1);
    if (!block)
        return NULL;
    block->next = arena->blocks;
    arena->blocks = block;
    return block->data;
}

void note_arena_free(note_arena *arena) {
    while (arena->blocks) {
        note_block *next = arena->blocks->next;
        free(arena->blocks);
        arena->blocks = next;
    }
}

/* After a failure the readers below return zeros and NULLs, and the first failure stays in err, so
 * that a struct is filled in one expression and checked once. */
typedef struct json_reader {
    note_arena *arena;
    const char *path;  /* of the file */
    const char *place; /* of the object being read: "knob", "slot" ... */
    base_error *err;
    int failed;
} json_reader;

static void read_fail(json_reader *r, const char *key, const char *what) {
    r->failed = 1;
    base_fail(r->err, STRATA_ERROR_BAD_FILE, "%s: Strata note: %s: \"%s\" %s", r->path, r->place,
              key, what);
}

static void *read_alloc(json_reader *r, size_t count, size_t size) {
    void *data = note_alloc(r->arena, count, size);
    if (!data) {
        r->failed = 1;
        base_fail(r->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: out of memory", r->path);
    }
    return data;
}

static const char *read_text_value(json_reader *r, const json_t *value, const char *key) {
    if (!json_is_string(value)) {
        read_fail(r, key, "is not a text");
        return NULL;
    }
    size_t size = json_string_length(value) + 1;
    char *copy = read_alloc(r, size, 1);
    return copy ? memcpy(copy, json_string_value(value), size) : NULL;
}

/* NULL when absent. */
static const char *read_text(json_reader *r, const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return value ? read_text_value(r, value, key) : NULL;
}

static uint32_t read_u32(json_reader *r, const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    json_int_t number = value ? json_integer_value(value) : 0;
    if (value && (!json_is_integer(value) || number < 0 || number > (json_int_t)UINT32_MAX)) {
        read_fail(r, key, "is not a 32-bit count");
        return 0;
    }
    return (uint32_t)number;
}

static double read_real(json_reader *r, const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    if (value && !json_is_number(value))
        read_fail(r, key, "is not a number");
    return value ? json_number_value(value) : 0.0;
}

/* Elements of an array member; absent = none. */
static uint32_t read_count(json_reader *r, const json_t *object, const char *key) {
    const json_t *array = json_object_get(object, key);
    if (array && (!json_is_array(array) || json_array_size(array) > MODULES_ARRAY_MAX)) {
        read_fail(r, key, "is not an array of at most 64 elements");
        return 0;
    }
    return (uint32_t)json_array_size(array);
}

static const json_t *read_element(json_reader *r, const json_t *object, const char *key,
                                  uint32_t index) {
    const json_t *element = json_array_get(json_object_get(object, key), index);
    if (!json_is_object(element))
        read_fail(r, key, "holds something that is not an object");
    return element;
}

/* NULL-terminated; NULL when absent. */
static const char *const *read_texts(json_reader *r, const json_t *object, const char *key) {
    if (!json_object_get(object, key))
        return NULL;
    uint32_t count = read_count(r, object, key);
    const char **texts = read_alloc(r, (size_t)count + 1, sizeof *texts);
    for (uint32_t i = 0; texts && i < count; i++)
        texts[i] = read_text_value(r, json_array_get(json_object_get(object, key), i), key);
    return texts;
}

static const strata_slot_use *const *read_slots(json_reader *r, const json_t *object,
                                                uint32_t *count) {
    *count = read_count(r, object, "slots");
    const strata_slot_use **slots = read_alloc(r, *count, sizeof *slots);
    for (uint32_t i = 0; i < *count && !r->failed; i++) {
        const json_t *from = read_element(r, object, "slots", i);
        strata_slot_use *slot = read_alloc(r, 1, sizeof *slot);
        if (r->failed)
            break;
        r->place = "slot";
        *slot = (strata_slot_use){
            .struct_size = sizeof *slot,
            .use = read_u32(r, from, "use"),
            .slot = read_text(r, from, "slot"),
            .layouts = read_u32(r, from, "layouts"),
            .optional = read_u32(r, from, "optional"),
        };
        slots[i] = slot;
    }
    return slots;
}

static const strata_knob *const *read_knobs(json_reader *r, const json_t *object, uint32_t *count) {
    *count = read_count(r, object, "knobs");
    const strata_knob **knobs = read_alloc(r, *count, sizeof *knobs);
    for (uint32_t i = 0; i < *count && !r->failed; i++) {
        const json_t *from = read_element(r, object, "knobs", i);
        strata_knob *knob = read_alloc(r, 1, sizeof *knob);
        if (r->failed)
            break;
        r->place = "knob";
        *knob = (strata_knob){
            .struct_size = sizeof *knob,
            .type = read_u32(r, from, "type"),
            .name = read_text(r, from, "name"),
            .title = read_text(r, from, "title"),
            .unit = read_text(r, from, "unit"),
            .minimum = read_real(r, from, "minimum"),
            .maximum = read_real(r, from, "maximum"),
            .preset = read_real(r, from, "preset"),
            .choices = read_texts(r, from, "choices"),
            .trades_accuracy = read_u32(r, from, "trades_accuracy"),
        };
        knobs[i] = knob;
    }
    return knobs;
}

static const strata_promises *read_promises(json_reader *r, const json_t *object) {
    const json_t *from = json_object_get(object, "promises");
    strata_promises *promises = read_alloc(r, 1, sizeof *promises);
    if (!promises || !from)
        return NULL;
    r->place = "promises";
    *promises = (strata_promises){
        .struct_size = sizeof *promises,
        .order = read_u32(r, from, "order"),
        .determinism = read_u32(r, from, "determinism"),
        .largest_depth = read_u32(r, from, "largest_depth"),
        .memory = read_text(r, from, "memory"),
    };
    return promises;
}

static const strata_cost_model *read_cost(json_reader *r, const json_t *object) {
    const json_t *from = json_object_get(object, "cost");
    strata_cost_model *cost = read_alloc(r, 1, sizeof *cost);
    if (!cost || !from)
        return NULL;
    r->place = "cost";
    *cost = (strata_cost_model){
        .struct_size = sizeof *cost,
        .frame = read_real(r, from, "frame"),
        .per_pixel = read_real(r, from, "per_pixel"),
        .per_fragment = read_real(r, from, "per_fragment"),
        .per_fragment_log2_depth = read_real(r, from, "per_fragment_log2_depth"),
        .per_triangle = read_real(r, from, "per_triangle"),
        .per_depth = read_real(r, from, "per_depth"),
        .per_depth_pixel = read_real(r, from, "per_depth_pixel"),
        .per_depth_fragment = read_real(r, from, "per_depth_fragment"),
        .per_depth_triangle = read_real(r, from, "per_depth_triangle"),
        .per_object = read_real(r, from, "per_object"),
    };
    return cost;
}

static void read_technique(json_reader *r, const json_t *from, modules_technique_note *to) {
    r->place = "technique";
    to->id = read_text(r, from, "id");
    to->title = read_text(r, from, "title");
    to->reference = read_text(r, from, "reference");
    to->stage = read_text(r, from, "stage");
    to->needs = read_texts(r, from, "needs");
    to->prefers = read_texts(r, from, "prefers");
    to->slots = read_slots(r, from, &to->slot_count);
    to->knobs = read_knobs(r, from, &to->knob_count);
    to->promises = read_promises(r, from);
    to->cost = read_cost(r, from);
}

static const strata_field *const *read_payload(json_reader *r, const json_t *object,
                                               uint32_t *count) {
    *count = read_count(r, object, "payload");
    const strata_field **fields = read_alloc(r, *count, sizeof *fields);
    for (uint32_t i = 0; i < *count && !r->failed; i++) {
        const json_t *from = read_element(r, object, "payload", i);
        strata_field *field = read_alloc(r, 1, sizeof *field);
        if (r->failed)
            break;
        r->place = "field";
        *field = (strata_field){
            .struct_size = sizeof *field,
            .channels = read_u32(r, from, "channels"),
            .name = read_text(r, from, "name"),
            .exact = read_u32(r, from, "exact"),
        };
        fields[i] = field;
    }
    return fields;
}

static const strata_need *const *read_needs(json_reader *r, const json_t *object, uint32_t *count) {
    *count = read_count(r, object, "called_for_by");
    const strata_need **needs = read_alloc(r, *count, sizeof *needs);
    for (uint32_t i = 0; i < *count && !r->failed; i++) {
        const json_t *from = read_element(r, object, "called_for_by", i);
        strata_need *need = read_alloc(r, 1, sizeof *need);
        if (r->failed)
            break;
        r->place = "need";
        *need = (strata_need){
            .struct_size = sizeof *need,
            .fact = read_text(r, from, "fact"),
            .threshold = read_real(r, from, "threshold"),
        };
        needs[i] = need;
    }
    return needs;
}

static void read_effect(json_reader *r, const json_t *from, modules_effect_note *to) {
    r->place = "effect";
    to->id = read_text(r, from, "id");
    to->title = read_text(r, from, "title");
    to->reference = read_text(r, from, "reference");
    to->flags = read_u32(r, from, "flags");
    to->transmittance_channels = read_u32(r, from, "transmittance_channels");
    to->priority = read_u32(r, from, "priority");
    to->payload = read_payload(r, from, &to->field_count);
    to->called_for_by = read_needs(r, from, &to->need_count);
}

static void read_module(json_reader *r, const json_t *root, modules_note *out) {
    r->place = "module";
    out->id = read_text(r, root, "id");
    out->title = read_text(r, root, "title");
    out->version = read_text(r, root, "version");
    out->licence = read_text(r, root, "licence");
    out->abi_version = read_u32(r, root, "abi_version");
    out->min_host_version = read_u32(r, root, "min_host_version");
    out->technique_count = read_count(r, root, "techniques");
    out->effect_count = read_count(r, root, "effects");
    modules_technique_note *techniques = read_alloc(r, out->technique_count, sizeof *techniques);
    for (uint32_t i = 0; i < out->technique_count && !r->failed; i++) {
        techniques[i].module = out;
        read_technique(r, read_element(r, root, "techniques", i), &techniques[i]);
    }
    modules_effect_note *effects = read_alloc(r, out->effect_count, sizeof *effects);
    for (uint32_t i = 0; i < out->effect_count && !r->failed; i++) {
        effects[i].module = out;
        read_effect(r, read_element(r, root, "effects", i), &effects[i]);
    }
    out->techniques = techniques;
    out->effects = effects;
}

strata_result note_parse(const char *text, const char *path, note_arena *arena, modules_note *out,
                         base_error *err) {
    base_error local = {0};
    json_error_t where;
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: Strata note: %s at byte %d", path,
                         where.text, where.position);
    if (!json_is_object(root)) {
        json_decref(root);
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: Strata note: not an object", path);
    }
    *out = (modules_note){.path = path};
    json_reader reader = {.arena = arena, .path = path, .err = &local};
    read_module(&reader, root, out);
    json_decref(root);
    if (!reader.failed)
        note_check(out, &local);
    if (local.result == STRATA_ERROR_MODULE)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: Strata note: %s", path, local.text);
    return local.result == STRATA_OK ? STRATA_OK : base_fail(err, local.result, "%s", local.text);
}
