/* SPDX-License-Identifier: MIT
 *
 * The generated effect header, strata/effects.glsl: StrataPayload with the active effects' fields
 * and no others, its packing into the planes of fragments/1 as the plan laid it out, and the calls
 * into the effects' own GLSL. Stands between plan and fragments.
 */
#include "render/render.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *type_of(uint32_t channels) {
    static const char *const types[] = {"float", "vec2", "vec3", "vec4"};
    return types[channels - 1];
}

/* "payload.NAME" or "payload.NAME.x". */
static void channel_name(const plan_field *field, uint32_t channel, char *out, size_t size) {
    const char swizzle[] = {field->channels > 1 ? '.' : '\0', "xyzw"[channel], '\0'};
    snprintf(out, size, "payload.%s%s", field->name, swizzle);
}

static void add_channel(base_text *text, const plan_field *field, uint32_t channel) {
    char name[96];
    channel_name(field, channel, name, sizeof name);
    base_text_add(text, "%s", name);
}

static const char *encoder(uint32_t bits) {
    return bits == 32 ? "floatBitsToUint" : bits == 16 ? "strata_half" : "strata_unorm8";
}

static const char *decoder(uint32_t bits) {
    return bits == 32 ? "uintBitsToFloat" : bits == 16 ? "strata_from_half" : "strata_from_unorm8";
}

static void add_structs(base_text *text, const plan *p, int certify) {
    const plan_payload *payload = &p->payload;
    base_text_add(text, "#ifndef STRATA_EFFECTS_GLSL\n#define STRATA_EFFECTS_GLSL\n"
                        "#include \"strata/surface.glsl\"\n#include \"strata/pack.glsl\"\n");
    base_text_add(text, "#define STRATA_TRANSMITTANCE %s\n",
                  p->transmittance_channels == 3 ? "vec3" : "float");
    /* With a certificate what effects call StrataElement is an event, an element without errors. */
    base_text_add(text,
                  "struct %s {\n    vec4 color;\n    STRATA_TRANSMITTANCE transmittance;\n};\n",
                  certify ? "StrataEvent" : "StrataElement");
    if (certify)
        base_text_add(text, "struct StrataElement {\n    vec4 color;\n"
                            "    STRATA_TRANSMITTANCE transmittance;\n    vec4 color_error;\n"
                            "    STRATA_TRANSMITTANCE transmittance_error;\n};\n"
                            "#include \"strata/certificate.glsl\"\n"
                            "#include \"strata/error.glsl\"\n");
    base_text_add(text, "struct StrataPayload {\n");
    for (uint32_t i = 0; i < payload->field_count; ++i)
        base_text_add(text, "    %s %s;\n", type_of(payload->fields[i].channels),
                      payload->fields[i].name);
    base_text_add(text, "};\n%s", certify ? "#define StrataElement StrataEvent\n" : "");
    for (uint32_t i = 0; i < p->effect_count; ++i)
        if (p->effects[i].active)
            base_text_add(text, "#include \"effects/%s.glsl\"\n", p->effects[i].effect->id);
    base_text_add(text, "%s", certify ? "#undef StrataElement\n" : "");
}

/* StrataPayload of zeros. */
static void add_zeros(base_text *text, const plan_payload *payload) {
    base_text_add(text, "StrataPayload(");
    for (uint32_t i = 0; i < payload->field_count; ++i)
        base_text_add(text, "%s%s(0.0)", i ? ", " : "", type_of(payload->fields[i].channels));
    base_text_add(text, ")");
}

static int declares(const modules_effect_note *effect, const char *field) {
    for (uint32_t i = 0; i < effect->field_count; ++i)
        if (strcmp(effect->payload[i]->name, field) == 0)
            return 1;
    return 0;
}

/* NAME_within: an effect's element with its errors, from the payload's precision. Its constants are
 * the compiler's to fold. */
static void add_within(base_text *text, const plan *p, const modules_effect_note *effect) {
    static const char *const quanta[] = {"0.0", "strata_quantum_half(%s)",
                                         "strata_quantum_unorm8(%s)"};
    const plan_payload *payload = &p->payload;
    int exact = 1;
    base_text_add(text,
                  "StrataElement %s_within(StrataPayload payload, out StrataWithin within) {\n",
                  effect->id);
    if (!(effect->flags & STRATA_EFFECT_AFFINE)) {
        for (uint32_t f = 0; f < payload->field_count; ++f)
            exact &=
                !declares(effect, payload->fields[f].name) || payload->fields[f].at[0].bits == 32;
        base_text_add(text, "    return strata_spread_opaque(%s_event(payload), %s, within);\n}\n",
                      effect->id, exact ? "true" : "false");
        return;
    }
    base_text_add(text, "    StrataPayload one = ");
    add_zeros(text, payload);
    base_text_add(text,
                  ";\n    StrataEvent zero = %s_event(one);\n"
                  "    StrataSpread spread = strata_spread_begin(zero);\n",
                  effect->id);
    for (uint32_t f = 0; f < payload->field_count; ++f)
        for (uint32_t c = 0;
             declares(effect, payload->fields[f].name) && c < payload->fields[f].channels; ++c) {
            char name[96], quantum[160];
            channel_name(&payload->fields[f], c, name, sizeof name);
            const uint32_t bits = payload->fields[f].at[c].bits;
            snprintf(quantum, sizeof quantum, quanta[bits == 32 ? 0 : bits == 16 ? 1 : 2], name);
            base_text_add(text,
                          "    one%s = 1.0;\n"
                          "    strata_spread_add(spread, zero, %s_event(one), %s, %s);\n"
                          "    one%s = 0.0;\n",
                          strchr(name, '.'), effect->id, name, quantum, strchr(name, '.'));
        }
    base_text_add(text, "    return strata_spread_end(spread, %s_event(payload), within);\n}\n",
                  effect->id);
}

/* A payload beyond the range of its precision is cut off, which no rounding bounds. */
static void add_range_check(base_text *text, const plan_payload *payload) {
    const char *separator = "    if (!(";
    base_text_add(text, "#ifdef STRATA_STAGE_FRAGMENT\n");
    for (uint32_t f = 0; f < payload->field_count; ++f)
        for (uint32_t c = 0; c < payload->fields[f].channels; ++c) {
            char name[96];
            const uint32_t bits = payload->fields[f].at[c].bits;
            channel_name(&payload->fields[f], c, name, sizeof name);
            if (bits == 32)
                continue;
            base_text_add(text, "%sstrata_fits_%s(%s)", separator, bits == 16 ? "half" : "unorm8",
                          name);
            separator = " && ";
        }
    if (strcmp(separator, " && ") == 0)
        base_text_add(text,
                      "))\n        strata_uncertified(strata_pixel(uvec2(gl_FragCoord.xy)));\n");
    base_text_add(text, "#endif\n");
}

/* Whether alpha is what the transmittance leaves, whatever the effects. */
static int all_cover(const plan *p) {
    const uint32_t both = STRATA_EFFECT_AFFINE | STRATA_EFFECT_COVERS;
    for (uint32_t i = 0; i < p->effect_count; ++i)
        if (p->effects[i].active && (p->effects[i].effect->flags & both) != both)
            return 0;
    return 1;
}

/* emit and event: straight calls with one active effect, a choice by number with several. */
static void add_calls(base_text *text, const plan *p, int certify) {
    const plan_payload *payload = &p->payload;
    const int several = p->active_effects > 1;
    base_text_add(text, "#ifdef STRATA_PAYLOAD_WRITE\n");
    if (several)
        base_text_add(text, "layout(std430) readonly buffer StrataMaterialEffects { uint "
                            "strata_material_effect[]; };\n");
    base_text_add(text, "StrataPayload strata_emit(StrataSurface surface) {\n"
                        "    StrataPayload payload = ");
    add_zeros(text, payload);
    base_text_add(text, ";\n");
    if (several)
        base_text_add(text, "    uint effect = strata_material_effect[surface.material];\n"
                            "    payload.id = float(effect);\n");
    for (uint32_t i = 0; i < p->effect_count; ++i) {
        if (!p->effects[i].active)
            continue;
        if (several)
            base_text_add(text, "    if (effect == %uu)\n    ", p->effects[i].index);
        base_text_add(text, "    %s_emit(surface, payload);\n", p->effects[i].effect->id);
    }
    if (certify)
        add_range_check(text, payload);
    base_text_add(text, "    return payload;\n}\n#endif\n");
    for (uint32_t i = 0; i < p->effect_count && certify; ++i)
        if (p->effects[i].active)
            add_within(text, p, p->effects[i].effect);
    if (certify)
        base_text_add(text, "const bool STRATA_COVERS = %s;\n", all_cover(p) ? "true" : "false");
    base_text_add(text, certify ? "StrataElement strata_event_within(StrataPayload payload, out "
                                  "StrataWithin within) {\n"
                                : "StrataElement strata_event(StrataPayload payload) {\n");
    for (uint32_t i = 0; i < p->effect_count; ++i) {
        if (!p->effects[i].active)
            continue;
        if (several && p->effects[i].index + 1 < p->active_effects)
            base_text_add(text, "    if (payload.id == %u.0)\n    ", p->effects[i].index);
        base_text_add(text, "    return %s_%s;\n", p->effects[i].effect->id,
                      certify ? "within(payload, within)" : "event(payload)");
    }
    base_text_add(text, "}\n");
    if (certify)
        base_text_add(text, "StrataElement strata_event(StrataPayload payload) {\n"
                            "    StrataWithin within;\n"
                            "    return strata_event_within(payload, within);\n}\n");
}

/* STRATA_PAYLOAD_ACCESS: how a program that writes touches the planes (coherent, for one), in place
 * of what follows from reading and writing alone. */
static void add_planes(base_text *text, const plan_payload *payload) {
    base_text_add(text, "#ifdef STRATA_PAYLOAD_WRITE\n"
                        "#ifndef STRATA_PAYLOAD_ACCESS\n#ifdef STRATA_PAYLOAD_READ\n"
                        "#define STRATA_PAYLOAD_ACCESS\n"
                        "#else\n#define STRATA_PAYLOAD_ACCESS writeonly\n#endif\n#endif\n");
    for (uint32_t i = 0; i < payload->plane_count; ++i)
        base_text_add(text,
                      "layout(std430) STRATA_PAYLOAD_ACCESS buffer StrataPayload%u { %s "
                      "strata_payload%u[]; };\n",
                      i, payload->plane_strides[i] == 8 ? "STRATA_PAIR" : "uint", i);
    base_text_add(text, "#define STRATA_PAYLOAD_PAIR(plane, slot) "
                        "STRATA_FROM_PAIR(strata_payload##plane[slot])\n"
                        "#define STRATA_PAYLOAD_WORD(plane, slot) strata_payload##plane[slot]\n"
                        "#elif defined(STRATA_PAYLOAD_READ)\n"
                        "#define STRATA_PAYLOAD_PAIR(plane, slot) "
                        "STRATA_AT_UVEC2(StrataPayload##plane, slot)\n"
                        "#define STRATA_PAYLOAD_WORD(plane, slot) "
                        "STRATA_AT_UINT(StrataPayload##plane, slot)\n");
    for (uint32_t i = 0; i < payload->plane_count; ++i)
        base_text_add(text, "STRATA_READ(StrataPayload%u, %s)\n", i,
                      payload->plane_strides[i] == 8 ? "uvec2" : "uint");
    base_text_add(text, "#endif\n");
}

/* Payload to words and back. word = a | b << 8 | ... of the channels that lie in it. */
static void add_encode(base_text *text, const plan_payload *payload) {
    base_text_add(text,
                  "#define STRATA_PAYLOAD_WORDS %u\n"
                  "void strata_payload_encode(StrataPayload payload, out uint words[%u]) {\n",
                  payload->words, payload->words);
    for (uint32_t word = 0; word < payload->words; ++word) {
        const char *separator = "";
        base_text_add(text, "    words[%u] = ", word);
        for (uint32_t f = 0; f < payload->field_count; ++f)
            for (uint32_t c = 0; c < payload->fields[f].channels; ++c) {
                const plan_channel *at = &payload->fields[f].at[c];
                if (at->word != word)
                    continue;
                base_text_add(text, "%s(%s(", separator, encoder(at->bits));
                add_channel(text, &payload->fields[f], c);
                base_text_add(text, ") << %u)", at->bit);
                separator = " | ";
            }
        base_text_add(text, "%s;\n", *separator ? "" : "0u");
    }
    base_text_add(text, "}\n");
}

static void add_decode(base_text *text, const plan_payload *payload) {
    base_text_add(text,
                  "StrataPayload strata_payload_decode(uint words[%u]) {\n"
                  "    StrataPayload payload;\n",
                  payload->words);
    for (uint32_t f = 0; f < payload->field_count; ++f)
        for (uint32_t c = 0; c < payload->fields[f].channels; ++c) {
            const plan_channel *at = &payload->fields[f].at[c];
            base_text_add(text, "    ");
            add_channel(text, &payload->fields[f], c);
            base_text_add(text, " = %s(words[%u]", decoder(at->bits), at->word);
            if (at->bits < 32)
                base_text_add(text, " >> %u & 0x%xu", at->bit, (1u << at->bits) - 1u);
            base_text_add(text, ");\n");
        }
    base_text_add(text, "    return payload;\n}\n");
}

static void add_store(base_text *text, const plan_payload *payload) {
    uint32_t word = 0;
    base_text_add(text,
                  "void strata_payload_store(uint slot, StrataPayload payload) {\n"
                  "    uint words[%u];\n    strata_payload_encode(payload, words);\n",
                  payload->words);
    for (uint32_t i = 0; i < payload->plane_count; ++i) {
        if (payload->plane_strides[i] == 8)
            base_text_add(text,
                          "    strata_payload%u[slot] = "
                          "STRATA_TO_PAIR(uvec2(words[%u], words[%u]));\n",
                          i, word, word + 1);
        else
            base_text_add(text, "    strata_payload%u[slot] = words[%u];\n", i, word);
        word += payload->plane_strides[i] / 4;
    }
    base_text_add(text, "}\n");
}

static void add_load(base_text *text, const plan_payload *payload) {
    uint32_t word = 0;
    base_text_add(text, "StrataPayload strata_payload_load(uint slot) {\n    uint words[%u];\n",
                  payload->words);
    for (uint32_t i = 0; i < payload->plane_count; ++i) {
        if (payload->plane_strides[i] == 8)
            base_text_add(text,
                          "    uvec2 plane%u = STRATA_PAYLOAD_PAIR(%u, slot);\n"
                          "    words[%u] = plane%u.x;\n    words[%u] = plane%u.y;\n",
                          i, i, word, i, word + 1, i);
        else
            base_text_add(text, "    words[%u] = STRATA_PAYLOAD_WORD(%u, slot);\n", word, i);
        word += payload->plane_strides[i] / 4;
    }
    base_text_add(text, "    return strata_payload_decode(words);\n}\n");
}

/* Which effect emits for each material, read by strata_emit when there are several. */
static strata_result bind_materials(render_session *session, base_error *err) {
    const scene *sc = session->scene;
    uint32_t *index = base_calloc(sc->material_count, sizeof *index);
    strata_buffer buffer = {0};
    strata_result r;
    if (!index)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "material effects: out of memory");
    for (uint32_t i = 0; i < sc->material_count; ++i) {
        const plan_effect *effect = plan_material_effect(session->plan, &sc->materials[i]);
        index[i] = effect ? effect->index : 0;
    }
    r = gpu_buffer_create(session->scope,
                          &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                .label = "material effects",
                                                .size = (uint64_t)sc->material_count * 4,
                                                .data = index},
                          &buffer, err);
    if (r == STRATA_OK)
        r = gpu_set_global(session->owner->gpu, "StrataMaterialEffects",
                           &(strata_bind){.struct_size = sizeof(strata_bind),
                                          .name = "StrataMaterialEffects",
                                          .buffer = buffer},
                           err);
    free(index);
    return r;
}

static strata_result set_sources(render_session *session, base_error *err) {
    for (uint32_t i = 0; i < session->plan->effect_count; ++i) {
        const plan_effect *planned = &session->plan->effects[i];
        const strata_effect *effect = NULL;
        char name[96];
        if (!planned->active)
            continue;
        strata_result r =
            modules_open_effect(session->owner->modules, planned->effect->id, &effect, err);
        if (r == STRATA_OK) {
            snprintf(name, sizeof name, "effects/%s.glsl", planned->effect->id);
            r = gpu_set_include(session->owner->gpu, name, effect->glsl->text, err);
        }
        if (r != STRATA_OK)
            return r;
    }
    return STRATA_OK;
}

strata_result render_effects(render_session *session, base_error *err) {
    const plan *p = session->plan;
    gpu *g = session->owner->gpu;
    base_text text = {0};
    char layout[16], channels[16];
    if (!p->transparent)
        return gpu_set_include(g, "strata/effects.glsl", NULL, err);
    snprintf(layout, sizeof layout, "%u", p->layout);
    snprintf(channels, sizeof channels, "%u", p->transmittance_channels);
    add_structs(&text, p, (int)session->certify);
    add_calls(&text, p, (int)session->certify);
    add_encode(&text, &p->payload);
    add_decode(&text, &p->payload);
    add_planes(&text, &p->payload);
    base_text_add(&text, "#ifdef STRATA_PAYLOAD_WRITE\n");
    add_store(&text, &p->payload);
    base_text_add(&text, "#endif\n#ifdef STRATA_PAYLOAD_READ\n");
    add_load(&text, &p->payload);
    base_text_add(&text, "#endif\n#endif\n");

    strata_result r = text.failed ? base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY,
                                              "effect header: out of memory")
                                  : STRATA_OK;
    if (r == STRATA_OK)
        r = gpu_set_define(g, "STRATA_LAYOUT", layout, err);
    if (r == STRATA_OK)
        r = gpu_set_define(g, "STRATA_CHANNELS", channels, err);
    if (r == STRATA_OK)
        r = gpu_set_define(g, "STRATA_INT64", gpu_fact(g, "feature.int64") ? "1" : NULL, err);
    if (r == STRATA_OK)
        r = set_sources(session, err);
    if (r == STRATA_OK)
        r = gpu_set_include(g, "strata/effects.glsl", text.data, err);
    if (r == STRATA_OK && p->active_effects > 1)
        r = bind_materials(session, err);
    base_text_free(&text);
    return r;
}
