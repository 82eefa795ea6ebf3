/* SPDX-License-Identifier: MIT
 *
 * Rewrites a SPIR-V module's resources: writes the bindings and locations that the host chose and
 * takes out the buffers, images and blocks that the shader declares (in a shared header, say) but
 * never uses, so that neither driver limits nor layouts see them. Word format: SPIR-V
 * specification, 2.3.
 */
#include "gpu/gpu_internal.h"

#include <stdlib.h>
#include <string.h>

#include <spirv_cross/spirv.h>

#define HEADER_WORDS 5u

typedef struct module {
    const uint32_t *words;
    size_t count;
    uint32_t bound;       /* ids are below this */
    uint8_t *is_resource; /* by id: 1, 2 when it gets a number, 3 when a location, too */
    uint8_t *is_used;
    uint32_t *out;
    size_t out_count;
} module;

static uint32_t opcode(uint32_t word) {
    return word & 0xffffu;
}

static uint32_t length_of(uint32_t word) {
    return word >> 16;
}

static int is_resource_class(uint32_t storage_class) {
    return storage_class == SpvStorageClassUniformConstant ||
           storage_class == SpvStorageClassUniform ||
           storage_class == SpvStorageClassStorageBuffer ||
           storage_class == SpvStorageClassPushConstant;
}

static int is_annotation(uint32_t op) {
    return op == SpvOpDecorate || op == SpvOpMemberDecorate || op == SpvOpDecorateId ||
           op == SpvOpDecorateString || op == SpvOpMemberDecorateString;
}

/* The sections before the types hold nothing but names of and remarks on variables. */
static int is_type_or_later(uint32_t op) {
    return op >= SpvOpTypeVoid && op != SpvOpDecorate && op != SpvOpMemberDecorate &&
           op != SpvOpDecorationGroup && op != SpvOpGroupDecorate &&
           op != SpvOpGroupMemberDecorate && !is_annotation(op) && op != SpvOpModuleProcessed &&
           op != SpvOpExecutionModeId && op != SpvOpLine && op != SpvOpNoLine;
}

/* Walks once: which ids are resource variables, and which of them any code refers to. */
static int scan(module *m) {
    int code = 0;
    for (size_t at = HEADER_WORDS; at < m->count;) {
        uint32_t op = opcode(m->words[at]), length = length_of(m->words[at]);
        if (length == 0 || length > m->count - at)
            return 0;
        if (op == SpvOpVariable && length >= 4 && !code) {
            uint32_t id = m->words[at + 2];
            if (id < m->bound && is_resource_class(m->words[at + 3]))
                m->is_resource[id] = 1;
        }
        code |= op == SpvOpFunction;
        for (uint32_t i = 1; code && i < length; i++)
            if (m->words[at + i] < m->bound)
                m->is_used[m->words[at + i]] = 1; /* a literal may keep one too many */
        at += length;
    }
    return 1;
}

static int is_gone(const module *m, uint32_t id) {
    return id < m->bound && m->is_resource[id] && !m->is_used[id];
}

static void put(module *m, const uint32_t *words, size_t count) {
    memcpy(m->out + m->out_count, words, count * sizeof *words);
    m->out_count += count;
}

/* OpEntryPoint: model, function, name, then the interface, from which what is gone goes. */
static void put_entry_point(module *m, const uint32_t *words, uint32_t length) {
    uint32_t name_end = 3;
    size_t start = m->out_count;
    while (name_end < length) {
        uint32_t word = words[name_end++];
        if (!(word & 0xffu) || !(word & 0xff00u) || !(word & 0xff0000u) || !(word & 0xff000000u))
            break;
    }
    put(m, words, name_end);
    for (uint32_t i = name_end; i < length; i++)
        if (!is_gone(m, words[i]))
            put(m, &words[i], 1);
    m->out[start] = (uint32_t)(m->out_count - start) << 16 | SpvOpEntryPoint;
}

static void put_bindings(module *m, const gpu_spirv_binding *bindings, uint32_t binding_count,
                         int sets) {
    for (uint32_t i = 0; i < binding_count; i++) {
        const uint32_t binding[] = {4u << 16 | SpvOpDecorate, bindings[i].id, SpvDecorationBinding,
                                    bindings[i].number};
        const uint32_t set[] = {4u << 16 | SpvOpDecorate, bindings[i].id,
                                SpvDecorationDescriptorSet, 0};
        const uint32_t location[] = {4u << 16 | SpvOpDecorate, bindings[i].id,
                                     SpvDecorationLocation, bindings[i].location};
        put(m, binding, 4);
        if (sets)
            put(m, set, 4);
        if (bindings[i].location != GPU_NO_LOCATION)
            put(m, location, 4);
    }
}

/* Whether the instruction stays as it is. */
static int keeps(const module *m, const uint32_t *words, uint32_t op, uint32_t length) {
    if (op == SpvOpName && length >= 2)
        return !is_gone(m, words[1]);
    if (op == SpvOpVariable && length >= 4)
        return !is_gone(m, words[2]);
    if (op == SpvOpDecorate && length >= 3) {
        const int given = words[1] < m->bound ? m->is_resource[words[1]] : 0;
        const int is_place =
            words[2] == SpvDecorationBinding || words[2] == SpvDecorationDescriptorSet;
        return !is_gone(m, words[1]) && !(is_place && given >= 2) &&
               !(words[2] == SpvDecorationLocation && given == 3);
    }
    return 1;
}

strata_result gpu_spirv_rewrite(uint32_t **words, size_t *count, const gpu_spirv_binding *bindings,
                                uint32_t binding_count, int sets, base_error *err) {
    module m = {.words = *words, .count = *count};
    strata_result result = STRATA_OK;
    int placed = 0;
    m.bound = *count > HEADER_WORDS ? (*words)[3] : 0;
    if (m.bound == 0 || m.bound > 1u << 24)
        return base_fail(err, STRATA_ERROR_SHADER, "the SPIR-V module is malformed");
    m.is_resource = base_calloc(m.bound, 1);
    m.is_used = base_calloc(m.bound, 1);
    m.out = base_calloc(*count + (size_t)binding_count * 12, sizeof *m.out);
    if (!m.is_resource || !m.is_used || !m.out) {
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for SPIR-V");
        goto cleanup;
    }
    if (!scan(&m)) {
        result = base_fail(err, STRATA_ERROR_SHADER, "the SPIR-V module is malformed");
        goto cleanup;
    }
    for (uint32_t i = 0; i < binding_count; i++)
        if (bindings[i].id < m.bound)
            m.is_resource[bindings[i].id] = bindings[i].location != GPU_NO_LOCATION ? 3 : 2;
    put(&m, m.words, HEADER_WORDS);
    for (size_t at = HEADER_WORDS; at < m.count;) {
        uint32_t op = opcode(m.words[at]), length = length_of(m.words[at]);
        if (!placed && (is_annotation(op) || is_type_or_later(op))) {
            put_bindings(&m, bindings, binding_count, sets);
            placed = 1;
        }
        if (op == SpvOpEntryPoint)
            put_entry_point(&m, m.words + at, length);
        else if (keeps(&m, m.words + at, op, length))
            put(&m, m.words + at, length);
        at += length;
    }
    free(*words);
    *words = m.out;
    *count = m.out_count;
    m.out = NULL;
cleanup:
    free(m.is_resource);
    free(m.is_used);
    free(m.out);
    return result;
}
