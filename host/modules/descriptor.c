/* SPDX-License-Identifier: MIT
 *
 * Descriptor -> modules_note: walks a module's constant structs once, checks every struct_size,
 * pointer and tail on the way, and hands out a note that points into them. What the values mean is
 * checked by note_check, as for a note that was read from a file.
 */
#include "modules/modules_internal.h"

#include <string.h>

#define STRUCT_SIZE_MAX 4096u /* beyond any struct of this ABI: a wild number */

/* `known` is the struct's size in ABI 1.0, the least there is. A longer one comes from a later
 * minor; what this host does not know of it must be zero. */
static strata_result check_struct(const char *owner, const char *what, const void *data,
                                  uint32_t known, base_error *err) {
    if (!data)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: %s is NULL", owner, what);
    uint32_t size;
    memcpy(&size, data, sizeof size);
    if (size < known || size > STRUCT_SIZE_MAX)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: %s has struct_size %u, expected %u", owner,
                         what, size, known);
    const unsigned char *bytes = data;
    for (uint32_t i = known; i < size; i++)
        if (bytes[i])
            return base_fail(err, STRATA_ERROR_VERSION,
                             "%s: %s uses a member at byte %u that this host does not know", owner,
                             what, i);
    return STRATA_OK;
}

/* An array of `count` pointers to structs. The cast is from `const X *const *` to a common type;
 * only pointers are read through it. */
static strata_result check_array(const char *owner, const char *what, const void *array,
                                 uint32_t count, uint32_t known, base_error *err) {
    if (count > MODULES_ARRAY_MAX)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: %s: %u elements, at most %d", owner, what,
                         count, MODULES_ARRAY_MAX);
    if (count && !array)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: %s is NULL", owner, what);
    for (uint32_t i = 0; i < count; i++) {
        const void *element;
        memcpy(&element, (const char *)array + i * sizeof element, sizeof element);
        strata_result result = check_struct(owner, what, element, known, err);
        if (result != STRATA_OK)
            return result;
    }
    return STRATA_OK;
}

static strata_result read_technique(const strata_technique *from, const modules_note *module,
                                    modules_technique_note *to, base_error *err) {
    const char *owner = from->id ? from->id : "technique";
    strata_result result =
        check_array(owner, "slots", from->slots, from->slot_count, sizeof(strata_slot_use), err);
    if (result == STRATA_OK)
        result =
            check_array(owner, "knobs", from->knobs, from->knob_count, sizeof(strata_knob), err);
    if (result == STRATA_OK)
        result = check_struct(owner, "promises", from->promises, sizeof(strata_promises), err);
    if (result == STRATA_OK)
        result = check_struct(owner, "cost", from->cost, sizeof(strata_cost_model), err);
    if (result != STRATA_OK)
        return result;
    const char *missing = !from->create    ? "create"
                          : !from->prepare ? "prepare"
                          : !from->record  ? "record"
                          : !from->destroy ? "destroy"
                                           : NULL;
    if (missing)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: %s is NULL", owner, missing);
    *to = (modules_technique_note){
        .module = module,
        .id = from->id,
        .title = from->title,
        .reference = from->reference,
        .stage = from->stage,
        .slots = from->slots,
        .slot_count = from->slot_count,
        .knob_count = from->knob_count,
        .knobs = from->knobs,
        .promises = from->promises,
        .cost = from->cost,
        .needs = from->needs,
        .prefers = from->prefers,
    };
    return STRATA_OK;
}

static strata_result read_effect(const strata_effect *from, const modules_note *module,
                                 modules_effect_note *to, base_error *err) {
    const char *owner = from->id ? from->id : "effect";
    strata_result result =
        check_array(owner, "payload", from->payload, from->field_count, sizeof(strata_field), err);
    if (result == STRATA_OK)
        result = check_array(owner, "called_for_by", from->called_for_by, from->need_count,
                             sizeof(strata_need), err);
    if (result != STRATA_OK)
        return result;
    if (!from->glsl || !from->glsl->text || !from->glsl->path)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: glsl, its text or its path is NULL", owner);
    *to = (modules_effect_note){
        .module = module,
        .id = from->id,
        .title = from->title,
        .reference = from->reference,
        .flags = from->flags,
        .transmittance_channels = from->transmittance_channels,
        .payload = from->payload,
        .field_count = from->field_count,
        .need_count = from->need_count,
        .called_for_by = from->called_for_by,
        .priority = from->priority,
    };
    return STRATA_OK;
}

static strata_result read_offers(const strata_module *module, note_arena *arena, modules_note *out,
                                 base_error *err) {
    const char *owner = module->id ? module->id : "module";
    strata_result result = check_array(owner, "techniques", module->techniques,
                                       module->technique_count, sizeof(strata_technique), err);
    if (result == STRATA_OK)
        result = check_array(owner, "effects", module->effects, module->effect_count,
                             sizeof(strata_effect), err);
    if (result != STRATA_OK)
        return result;
    modules_technique_note *techniques =
        note_alloc(arena, module->technique_count, sizeof *techniques);
    modules_effect_note *effects = note_alloc(arena, module->effect_count, sizeof *effects);
    if (!techniques || !effects)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: out of memory", owner);
    for (uint32_t i = 0; result == STRATA_OK && i < module->technique_count; i++)
        result = read_technique(module->techniques[i], out, &techniques[i], err);
    for (uint32_t i = 0; result == STRATA_OK && i < module->effect_count; i++)
        result = read_effect(module->effects[i], out, &effects[i], err);
    out->techniques = techniques;
    out->technique_count = module->technique_count;
    out->effects = effects;
    out->effect_count = module->effect_count;
    return result;
}

strata_result descriptor_note(const strata_module *module, const char *path, note_arena *arena,
                              modules_note *out, base_error *err) {
    strata_result result =
        check_struct("module", STRATA_MODULE_SYMBOL, module, sizeof(strata_module), err);
    if (result != STRATA_OK)
        return result;
    result =
        note_check_version(module->abi_version, module->min_host_version, STRATA_ABI_VERSION, err);
    if (result != STRATA_OK)
        return result;
    if (module->flags)
        return base_fail(err, STRATA_ERROR_MODULE, "%s: unknown flags 0x%x",
                         module->id ? module->id : "module", module->flags);
    *out = (modules_note){
        .path = path,
        .id = module->id,
        .title = module->title,
        .version = module->version,
        .licence = module->licence,
        .abi_version = module->abi_version,
        .min_host_version = module->min_host_version,
    };
    result = read_offers(module, arena, out, err);
    return result == STRATA_OK ? note_check(out, err) : result;
}
