/* SPDX-License-Identifier: MIT
 *
 * Handles, scopes and the storage behind them: what a scope's end destroys, what history keeps for
 * the next one, and who holds how many bytes. A handle is the number of a slot that is never used
 * again.
 */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- owners and scopes ---------------------------------------------------------------------- */

gpu_owner *gpu_owner_find(const gpu *g, const char *name) {
    for (gpu_owner *owner = g->owners; owner; owner = owner->next)
        if (strncmp(owner->name, name, sizeof owner->name - 1) == 0)
            return owner;
    return NULL;
}

gpu_scope *gpu_scope_create(gpu *g, const char *owner_name) {
    gpu_scope *scope = base_calloc(1, sizeof *scope);
    gpu_owner *owner = gpu_owner_find(g, owner_name);
    if (scope && !owner) {
        owner = base_calloc(1, sizeof *owner);
        if (owner) {
            snprintf(owner->name, sizeof owner->name, "%s", owner_name);
            owner->next = g->owners;
            g->owners = owner;
        }
    }
    if (!scope || !owner) {
        free(scope);
        return NULL;
    }
    owner->scopes++;
    *scope = (gpu_scope){.device = g, .owner = owner, .next = g->scopes};
    if (g->scopes)
        g->scopes->previous = scope;
    g->scopes = scope;
    return scope;
}

/* ---- slots: taken again and again, while ids are never --------------------------------------- */

#define SLOT_BITS       20u
#define SLOTS           (1u << SLOT_BITS)
#define LAST_GENERATION (UINT32_MAX >> SLOT_BITS)

/* The object's new id, 0: no memory. */
static uint32_t take_slot(gpu *g, gpu_object *object) {
    uint32_t number = g->free_slot;
    if (number) {
        gpu_slot *slot = &g->slots[number - 1];
        g->free_slot = slot->next_free;
        slot->generation++;
    } else {
        gpu_slot *slots = base_grow(g->slots, &g->slot_capacity, g->slot_count, sizeof *slots);
        g->slots = slots ? slots : g->slots;
        if (!slots || g->slot_count + 1 == SLOTS)
            return 0;
        slots[g->slot_count++] = (gpu_slot){0};
        number = (uint32_t)g->slot_count;
    }
    g->slots[number - 1].object = object;
    return g->slots[number - 1].generation << SLOT_BITS | number;
}

/* A slot that has run out of generations is not used again. */
static void release_slot(gpu *g, uint32_t id) {
    const uint32_t number = id & (SLOTS - 1);
    gpu_slot *slot = &g->slots[number - 1];
    slot->object = NULL;
    if (slot->generation < LAST_GENERATION) {
        slot->next_free = g->free_slot;
        g->free_slot = number;
    }
}

static void end_object(gpu *g, gpu_object *object) {
    switch (object->kind) {
    case GPU_BUFFER:
        gpu_storage_release(g, object->buffer.storage);
        break;
    case GPU_IMAGE:
        gpu_storage_release(g, object->image.storage);
        break;
    case GPU_PROGRAM:
        gpu_program_release(g, object->program);
        break;
    case GPU_POOL: /* its planes are buffers of the same scope */
    case GPU_DRAWS:
        break;
    }
    release_slot(g, object->id);
    free(object);
}

void gpu_scope_end(gpu_scope *scope) {
    if (!scope)
        return;
    gpu *g = scope->device;
    gpu_owner *owner = scope->owner;
    if (g->open) /* recorded commands may still name what dies now */
        gpu_flush(g);
    while (scope->objects) {
        gpu_object *object = scope->objects;
        scope->objects = object->next;
        end_object(g, object);
    }
    owner->scopes--;
    while (owner->scopes == 0 && owner->history) {
        gpu_history *history = owner->history;
        owner->history = history->next;
        gpu_storage_release(g, history->storage);
        free(history);
    }
    if (scope->previous)
        scope->previous->next = scope->next;
    else
        g->scopes = scope->next;
    if (scope->next)
        scope->next->previous = scope->previous;
    free(scope);
}

/* ---- handles -------------------------------------------------------------------------------- */

strata_result gpu_creation(gpu *g, const char *label, base_error *err) {
    g->last_code = GPU_ERROR_NONE;
    if (g->lost)
        return gpu_fail(g, err, GPU_ERROR_LOST, "%s", label ? label : "");
    g->creations++;
    if (g->inject == GPU_INJECT_ALLOCATION && g->creations == g->inject_at)
        return gpu_fail(g, err, GPU_ERROR_MEMORY, "%s (injected)", label ? label : "");
    return STRATA_OK;
}

gpu_object *gpu_object_new(gpu_scope *scope, gpu_kind kind, const char *label) {
    gpu_object *object = base_calloc(1, sizeof *object);
    if (!object)
        return NULL;
    object->id = take_slot(scope->device, object);
    if (!object->id) {
        free(object);
        return NULL;
    }
    object->kind = kind;
    object->scope = scope;
    object->next = scope->objects;
    scope->objects = object;
    snprintf(object->label, sizeof object->label, "%s", label ? label : "");
    return object;
}

void gpu_object_drop(gpu *g, gpu_object *object) {
    object->scope->objects = object->next;
    end_object(g, object);
}

gpu_object *gpu_object_find(const gpu *g, uint32_t id, gpu_kind kind, gpu_code *code) {
    *code = GPU_ERROR_HANDLE_UNKNOWN;
    const uint32_t number = id & (SLOTS - 1);
    if (number == 0 || number > g->slot_count || id >> SLOT_BITS > g->slots[number - 1].generation)
        return NULL;
    const gpu_slot *slot = &g->slots[number - 1];
    gpu_object *object = id >> SLOT_BITS == slot->generation ? slot->object : NULL;
    if (!object)
        *code = GPU_ERROR_HANDLE_DEAD;
    return object && object->kind == kind ? object : NULL;
}

/* ---- storage -------------------------------------------------------------------------------- */

static gpu_storage *storage_new(gpu_owner *owner, uint64_t bytes, uint32_t is_image) {
    gpu_storage *storage = base_calloc(1, sizeof *storage);
    if (storage)
        *storage =
            (gpu_storage){.references = 1, .owner = owner, .bytes = bytes, .is_image = is_image};
    return storage;
}

static void storage_account(gpu *g, gpu_storage *storage) {
    gpu_owner *owner = storage->owner;
    owner->bytes += storage->bytes;
    if (owner->bytes > owner->peak)
        owner->peak = owner->bytes;
    g->bytes += storage->bytes;
    if (g->bytes > g->peak)
        g->peak = g->bytes;
    gpu_hazards_uploaded(storage);
}

strata_result gpu_storage_buffer(gpu *g, gpu_owner *owner, const strata_buffer_desc *desc,
                                 gpu_storage **out, base_error *err) {
    gpu_storage *storage = storage_new(owner, desc->size, 0);
    if (!storage)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", desc->label);
    strata_result result =
        gpu_backend_result(g, err, g->backend->buffer_create(g->self, desc, &storage->native, err));
    if (result != STRATA_OK) {
        free(storage);
        return result;
    }
    storage_account(g, storage);
    *out = storage;
    return STRATA_OK;
}

static uint64_t image_bytes(const strata_image_desc *desc) {
    return (uint64_t)desc->width * desc->height * (desc->layers ? desc->layers : 1) *
           desc->samples * gpu_format_bytes(desc->format);
}

static strata_result storage_image(gpu *g, gpu_owner *owner, const strata_image_desc *desc,
                                   gpu_storage **out, base_error *err) {
    gpu_storage *storage = storage_new(owner, image_bytes(desc), 1);
    if (!storage)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", desc->label);
    strata_result result =
        gpu_backend_result(g, err, g->backend->image_create(g->self, desc, &storage->native, err));
    if (result != STRATA_OK) {
        free(storage);
        return result;
    }
    storage_account(g, storage);
    *out = storage;
    return STRATA_OK;
}

void gpu_storage_release(gpu *g, gpu_storage *storage) {
    if (!storage || --storage->references)
        return;
    if (storage->is_image)
        g->backend->image_destroy(g->self, storage->native);
    else
        g->backend->buffer_destroy(g->self, storage->native);
    storage->owner->bytes -= storage->bytes;
    g->bytes -= storage->bytes;
    free(storage);
}

/* ---- history -------------------------------------------------------------------------------- */

static gpu_history *history_find(gpu_owner *owner, const char *name) {
    for (gpu_history *history = owner->history; history; history = history->next)
        if (strcmp(history->name, name) == 0)
            return history;
    return NULL;
}

/* Remembers storage under the description's name; replaces what did not fit. */
static strata_result history_keep(gpu *g, gpu_owner *owner, const char *name,
                                  const gpu_history *description, gpu_storage *storage,
                                  base_error *err) {
    gpu_history *history = history_find(owner, name);
    if (!history) {
        history = base_calloc(1, sizeof *history);
        if (!history)
            return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", name);
        history->next = owner->history;
        owner->history = history;
    } else {
        gpu_storage_release(g, history->storage);
    }
    gpu_history *next = history->next;
    *history = *description;
    history->next = next;
    snprintf(history->name, sizeof history->name, "%s", name);
    history->storage = storage;
    storage->references++;
    return STRATA_OK;
}

static gpu_storage *history_reuse(gpu_owner *owner, const char *name,
                                  const gpu_history *description, uint64_t bytes,
                                  uint32_t is_image) {
    gpu_history *history = history_find(owner, name);
    if (!history || history->storage->is_image != is_image || history->storage->bytes != bytes ||
        history->format != description->format || history->width != description->width ||
        history->height != description->height || history->layers != description->layers ||
        history->samples != description->samples)
        return NULL;
    history->storage->references++;
    return history->storage;
}

/* ---- buffers -------------------------------------------------------------------------------- */

static strata_result check_label(gpu *g, const char *label, const char *history, base_error *err) {
    if (!label || !label[0])
        return gpu_fail(g, err, GPU_ERROR_LABEL_MISSING, "an object without a label");
    if (history && (!history[0] || strlen(history) >= sizeof((gpu_history *)0)->name))
        return gpu_fail(g, err, GPU_ERROR_VALUE, "%s: the name of its history", label);
    return STRATA_OK;
}

strata_result gpu_buffer_create(gpu_scope *scope, const strata_buffer_desc *given,
                                strata_buffer *out, base_error *err) {
    gpu *g = scope->device;
    gpu_owner *owner = scope->owner;
    strata_buffer_desc desc;
    *out = (strata_buffer){0};
    strata_result result = gpu_creation(g, "a buffer", err);
    if (result == STRATA_OK)
        result = gpu_take(g, err, given, &desc, sizeof desc, "strata_buffer_desc");
    if (result == STRATA_OK)
        result = check_label(g, desc.label, desc.history, err);
    if (result != STRATA_OK)
        return result;
    if (desc.size == 0 || desc.size % 4)
        return gpu_fail(g, err, GPU_ERROR_BUFFER_SIZE, "%s: buffer '%s' of %llu bytes", owner->name,
                        desc.label, (unsigned long long)desc.size);

    gpu_object *object = gpu_object_new(scope, GPU_BUFFER, desc.label);
    if (!object)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", desc.label);
    const gpu_history none = {0};
    gpu_storage *storage =
        desc.history ? history_reuse(owner, desc.history, &none, desc.size, 0) : NULL;
    if (!storage) {
        result = gpu_storage_buffer(g, owner, &desc, &storage, err);
        if (result == STRATA_OK && desc.history)
            result = history_keep(g, owner, desc.history, &none, storage, err);
    }
    object->buffer = (gpu_buffer_state){.storage = storage, .size = desc.size};
    if (result != STRATA_OK) {
        gpu_object_drop(g, object);
        return result;
    }
    out->id = object->id;
    return STRATA_OK;
}

/* ---- images --------------------------------------------------------------------------------- */

uint32_t gpu_format_bytes(uint32_t format) {
    static const uint32_t bytes[] = {
        [STRATA_FORMAT_RGBA32F] = 16,   [STRATA_FORMAT_RGBA16F] = 8,  [STRATA_FORMAT_RGBA8] = 4,
        [STRATA_FORMAT_RGBA8_SRGB] = 4, [STRATA_FORMAT_R32F] = 4,     [STRATA_FORMAT_R32U] = 4,
        [STRATA_FORMAT_RG32U] = 8,      [STRATA_FORMAT_RGBA32U] = 16, [STRATA_FORMAT_D32F] = 4,
        [STRATA_FORMAT_D32F_S8] = 8,
    };
    return format < BASE_COUNT(bytes) ? bytes[format] : 0;
}

static strata_result check_image(gpu *g, const gpu_owner *owner, const strata_image_desc *desc,
                                 base_error *err) {
    strata_result result = check_label(g, desc->label, desc->history, err);
    if (result != STRATA_OK)
        return result;
    if (!gpu_format_bytes(desc->format))
        return gpu_fail(g, err, GPU_ERROR_IMAGE_FORMAT, "%s: image '%s' of format %u", owner->name,
                        desc->label, desc->format);
    if (desc->width == 0 || desc->height == 0 || desc->width > g->caps.image_size ||
        desc->height > g->caps.image_size || desc->layers > 2048)
        return gpu_fail(g, err, GPU_ERROR_IMAGE_SIZE, "%s: image '%s' of %ux%u, %u layers",
                        owner->name, desc->label, desc->width, desc->height, desc->layers);
    if (desc->samples > g->caps.samples || (desc->samples & (desc->samples - 1)) ||
        (desc->samples > 1 && (desc->layers || gpu_format_is_integer(desc->format) ||
                               desc->format == STRATA_FORMAT_RGBA8_SRGB)))
        return gpu_fail(g, err, GPU_ERROR_IMAGE_SAMPLES,
                        "%s: image '%s' of %u samples, %u layers, format %u; the most samples are "
                        "%u",
                        owner->name, desc->label, desc->samples, desc->layers, desc->format,
                        g->caps.samples);
    return STRATA_OK;
}

strata_result gpu_image_create(gpu_scope *scope, const strata_image_desc *given, strata_image *out,
                               base_error *err) {
    gpu *g = scope->device;
    gpu_owner *owner = scope->owner;
    strata_image_desc desc;
    *out = (strata_image){0};
    strata_result result = gpu_creation(g, "an image", err);
    if (result == STRATA_OK)
        result = gpu_take(g, err, given, &desc, sizeof desc, "strata_image_desc");
    if (result != STRATA_OK)
        return result;
    desc.samples = desc.samples ? desc.samples : 1;
    result = check_image(g, owner, &desc, err);
    if (result != STRATA_OK)
        return result;

    gpu_object *object = gpu_object_new(scope, GPU_IMAGE, desc.label);
    if (!object)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", desc.label);
    const gpu_history shape = {.format = desc.format,
                               .width = desc.width,
                               .height = desc.height,
                               .layers = desc.layers,
                               .samples = desc.samples};
    gpu_storage *storage =
        desc.history ? history_reuse(owner, desc.history, &shape, image_bytes(&desc), 1) : NULL;
    if (!storage) {
        result = storage_image(g, owner, &desc, &storage, err);
        if (result == STRATA_OK && desc.history)
            result = history_keep(g, owner, desc.history, &shape, storage, err);
    }
    object->image = (gpu_image_state){.storage = storage,
                                      .format = desc.format,
                                      .width = desc.width,
                                      .height = desc.height,
                                      .layers = desc.layers,
                                      .samples = desc.samples};
    if (result != STRATA_OK) {
        gpu_object_drop(g, object);
        return result;
    }
    out->id = object->id;
    return STRATA_OK;
}

strata_result gpu_image_size(const gpu *g, strata_image image, uint32_t *width, uint32_t *height) {
    gpu_code code;
    const gpu_object *object = gpu_object_find(g, image.id, GPU_IMAGE, &code);
    *width = object ? object->image.width : 0;
    *height = object ? object->image.height : 0;
    return object ? STRATA_OK : STRATA_ERROR_INVALID_ARGUMENT;
}

/* ---- draws ---------------------------------------------------------------------------------- */

/* All draws have a count: Mesa 22.3 (lavapipe and llvmpipe) goes on with the count of an earlier
 * draw in those that have none. */
static strata_result make_count(gpu_scope *scope, uint32_t capacity, strata_buffer *out,
                                base_error *err) {
    return gpu_buffer_create(scope,
                             &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                   .label = "draw count",
                                                   .size = sizeof capacity,
                                                   .data = &capacity},
                             out, err);
}

strata_result gpu_draws_create(gpu_scope *scope, const gpu_draws_desc *desc, strata_draws *out,
                               base_error *err) {
    gpu *g = scope->device;
    gpu_code code;
    *out = (strata_draws){0};
    g->last_code = GPU_ERROR_NONE;
    if (g->lost)
        return gpu_fail(g, err, GPU_ERROR_LOST, "draws");
    const gpu_object *commands = gpu_object_find(g, desc->commands.id, GPU_BUFFER, &code);
    if (!commands)
        return gpu_fail(g, err, code, "commands of draws");
    if (!gpu_object_find(g, desc->indices.id, GPU_BUFFER, &code))
        return gpu_fail(g, err, code, "indices of draws");
    if (desc->count.id && !gpu_object_find(g, desc->count.id, GPU_BUFFER, &code))
        return gpu_fail(g, err, code, "count of draws");
    if ((uint64_t)desc->capacity * 20 > commands->buffer.size)
        return gpu_fail(g, err, GPU_ERROR_BUFFER_RANGE, "%u commands in '%s'", desc->capacity,
                        commands->label);
    strata_buffer count = desc->count;
    strata_result result = count.id ? STRATA_OK : make_count(scope, desc->capacity, &count, err);
    if (result != STRATA_OK)
        return result;
    gpu_object *object = gpu_object_new(scope, GPU_DRAWS, "draws");
    if (!object)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for draws");
    object->draws = (gpu_draws_state){.commands = desc->commands,
                                      .count = count,
                                      .indices = desc->indices,
                                      .capacity = desc->capacity,
                                      .counted = desc->count.id != 0};
    out->id = object->id;
    return STRATA_OK;
}

/* ---- bytes ---------------------------------------------------------------------------------- */

uint64_t gpu_bytes(const gpu *g, const char *name) {
    if (!name)
        return g->bytes;
    const gpu_owner *owner = gpu_owner_find(g, name);
    return owner ? owner->bytes : 0;
}

uint64_t gpu_bytes_peak(const gpu *g, const char *name) {
    if (!name)
        return g->peak;
    const gpu_owner *owner = gpu_owner_find(g, name);
    return owner ? owner->peak : 0;
}
