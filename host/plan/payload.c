/* SPDX-License-Identifier: MIT
 *
 * The payload of a fragment record: the fields that the active effects declare, packed into 32-bit
 * words and those into planes of at most 8 bytes. The generated GLSL of host/render follows it.
 */
#include "plan/plan_internal.h"

#include <stdio.h>
#include <string.h>

static uint32_t channel_bits(uint32_t precision, uint32_t exact) {
    if (exact || precision == STRATA_PAYLOAD_FLOAT)
        return 32;
    return precision == STRATA_PAYLOAD_HALF ? 16 : 8;
}

static strata_result add_field(plan_payload *p, const char *effect, const strata_field *field,
                               base_error *err) {
    for (uint32_t i = 0; i < p->field_count; i++) {
        const plan_field *known = &p->fields[i];
        if (strcmp(known->name, field->name) != 0)
            continue;
        if (known->channels == field->channels && known->exact == (field->exact != 0))
            return STRATA_OK;
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "the effect %s declares the payload field '%s' differently from another "
                         "active effect",
                         effect, field->name);
    }
    plan_field *added = &p->fields[p->field_count];
    if (p->field_count >= PLAN_MAX_FIELDS)
        return base_fail(err, STRATA_ERROR_OVERFLOW,
                         "the effect %s: a record holds at most %u payload fields", effect,
                         PLAN_MAX_FIELDS);
    if (field->channels < 1 || field->channels > 4 || strlen(field->name) >= sizeof added->name)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "the effect %s: the payload field '%.64s' is malformed", effect,
                         field->name);
    *added = (plan_field){.channels = field->channels, .exact = field->exact != 0};
    memcpy(added->name, field->name, strlen(field->name) + 1);
    p->field_count++;
    return STRATA_OK;
}

/* Places all channels of one width; *bit counts from the start of the payload. */
static void place(plan_payload *p, uint32_t bits, uint32_t *bit) {
    for (uint32_t i = 0; i < p->field_count; i++) {
        plan_field *field = &p->fields[i];
        if (channel_bits(p->precision, field->exact) != bits)
            continue;
        for (uint32_t k = 0; k < field->channels; k++) {
            uint32_t word = *bit / 32;
            field->at[k] = (plan_channel){
                .word = word,
                .plane = word / 2,
                .part = word % 2,
                .bit = *bit % 32,
                .bits = bits,
            };
            *bit += bits;
        }
    }
}

strata_result plan_payload_make(const modules_effect_note *const *effects, uint32_t count,
                                uint32_t precision, plan_payload *out, base_error *err) {
    static const strata_field id = {
        .struct_size = sizeof id, .channels = 1, .name = "id", .exact = 1};
    uint32_t bit = 0;
    *out = (plan_payload){.precision = precision};
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t k = 0; k < effects[i]->field_count; k++) {
            const strata_field *field = effects[i]->payload[k];
            if (strcmp(field->name, "id") == 0)
                return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                                 "the effect %s: the payload field 'id' is the host's",
                                 effects[i]->id);
            strata_result result = add_field(out, effects[i]->id, field, err);
            if (result != STRATA_OK)
                return result;
        }
    }
    if (count > 1) {
        strata_result result = add_field(out, effects[0]->id, &id, err);
        if (result != STRATA_OK)
            return result;
    }
    place(out, 32, &bit);
    if (channel_bits(precision, 0) < 32)
        place(out, channel_bits(precision, 0), &bit);
    out->words = (bit + 31) / 32;
    out->plane_count = (out->words + 1) / 2;
    if (out->plane_count > PLAN_MAX_PLANES)
        return base_fail(err, STRATA_ERROR_OVERFLOW,
                         "the active effects need %u bytes of payload a fragment; a record holds "
                         "%u",
                         out->words * 4, PLAN_MAX_PLANES * 8);
    for (uint32_t i = 0; i < out->plane_count; i++)
        out->plane_strides[i] = i * 2 + 1 < out->words ? 8 : 4;
    return STRATA_OK;
}
