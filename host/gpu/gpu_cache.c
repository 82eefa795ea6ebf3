/* SPDX-License-Identifier: MIT
 *
 * The SPIR-V cache on disk: one file a program, named by two hashes of the expanded text, the
 * target and the compiler's version; holds the rewritten SPIR-V and its reflection. A file that
 * does not check out in every respect is as good as none. Failures to write are not errors.
 */
#include "gpu/gpu_internal.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CACHE_FORMAT  6u /* counts changes of what is stored and of how SPIR-V is rewritten */
#define LARGEST_ENTRY ((size_t)64 << 20)

typedef struct entry_header {
    char magic[8];
    uint32_t format, binding_bytes;
    uint64_t keys[2], checksum; /* of all that follows */
    uint64_t words[2];
    gpu_reflection reflection;
} entry_header;

void gpu_cache_keys(const gpu *g, const gpu_program_state *program, uint64_t keys[2]) {
    const uint32_t facts[] = {CACHE_FORMAT, gpu_compiler_version(), program->kind,
                              g->caps.vulkan_target != 0};
    for (uint64_t i = 0; i < 2; i++) {
        keys[i] = base_hash(0, &i, sizeof i);
        keys[i] = base_hash(keys[i], facts, sizeof facts);
        for (int k = 0; k < 2; k++) {
            const base_text *text = &program->sources[k].text;
            uint64_t length = text->length + i; /* the second hash starts elsewhere */
            keys[i] = base_hash(keys[i], &length, sizeof length);
            if (text->data)
                keys[i] = base_hash(keys[i], text->data, text->length);
        }
    }
}

static int make_path(const gpu *g, const uint64_t keys[2], char *path, size_t size) {
    int length = snprintf(path, size, "%s/spirv/%016" PRIx64 "%016" PRIx64 ".spv", g->cache_dir,
                          keys[0], keys[1]);
    return length > 0 && (size_t)length < size;
}

/* Everything but the checksum was read by someone who may have written it: believe nothing. */
static int header_is_sound(const entry_header *header, size_t size, const uint64_t keys[2]) {
    const uint64_t most = LARGEST_ENTRY / sizeof(uint32_t);
    return memcmp(header->magic, "STRSPIRV", 8) == 0 && header->format == CACHE_FORMAT &&
           header->binding_bytes == sizeof(gpu_binding) && header->keys[0] == keys[0] &&
           header->keys[1] == keys[1] && header->words[0] > 0 && header->words[0] <= most &&
           header->words[1] <= most &&
           size == sizeof *header + (header->words[0] + header->words[1]) * sizeof(uint32_t) &&
           header->reflection.binding_count <= GPU_MAX_BINDINGS;
}

static uint64_t checksum(const entry_header *header, const void *words0, const void *words1) {
    uint64_t sum = base_hash(0, header->words, sizeof header->words);
    sum = base_hash(sum, &header->reflection, sizeof header->reflection);
    sum = base_hash(sum, words0, (size_t)header->words[0] * sizeof(uint32_t));
    return base_hash(sum, words1, (size_t)header->words[1] * sizeof(uint32_t));
}

static int copy_words(const unsigned char *from, uint64_t count, uint32_t **words, size_t *out) {
    *words = base_calloc((size_t)count + 1, sizeof **words);
    if (!*words)
        return 0;
    memcpy(*words, from, (size_t)count * sizeof **words);
    *out = (size_t)count;
    return 1;
}

int gpu_cache_load(const gpu *g, const gpu_program_state *program, gpu_spirv *spirv,
                   gpu_reflection *reflection) {
    char path[4096];
    const uint64_t *keys = program->keys;
    unsigned char *data = NULL;
    size_t size = 0;
    base_error ignored = {0};
    entry_header header;
    int loaded = 0;
    if (!g->cache_dir)
        return 0;
    if (!make_path(g, keys, path, sizeof path) ||
        base_file_read(path, LARGEST_ENTRY, &data, &size, &ignored) != STRATA_OK)
        return 0;
    if (size < sizeof header)
        goto cleanup;
    memcpy(&header, data, sizeof header);
    if (!header_is_sound(&header, size, keys))
        goto cleanup;
    const unsigned char *first = data + sizeof header;
    const unsigned char *second = first + header.words[0] * sizeof(uint32_t);
    if (header.checksum != checksum(&header, first, second))
        goto cleanup;
    loaded = copy_words(first, header.words[0], &spirv->words[0], &spirv->count[0]) &&
             (!header.words[1] ||
              copy_words(second, header.words[1], &spirv->words[1], &spirv->count[1]));
    *reflection = header.reflection;
    if (!loaded)
        gpu_spirv_free(spirv);
cleanup:
    free(data);
    return loaded;
}

void gpu_cache_store(const gpu *g, const gpu_program_state *program, const gpu_spirv *spirv,
                     const gpu_reflection *reflection) {
    char path[4096], folder[4096];
    base_output out;
    base_error ignored = {0};
    entry_header header;
    if (!g->cache_dir)
        return;
    memset(&header, 0, sizeof header); /* padding too is hashed and written */
    memcpy(header.magic, "STRSPIRV", 8);
    header.format = CACHE_FORMAT;
    header.binding_bytes = sizeof(gpu_binding);
    memcpy(header.keys, program->keys, sizeof header.keys);
    header.words[0] = spirv->count[0];
    header.words[1] = spirv->count[1];
    memcpy(&header.reflection, reflection, sizeof header.reflection);
    header.checksum = checksum(&header, spirv->words[0], spirv->words[1]);
    int length = snprintf(folder, sizeof folder, "%s/spirv", g->cache_dir);
    if (length < 0 || (size_t)length >= sizeof folder ||
        !make_path(g, header.keys, path, sizeof path) ||
        base_make_folders(folder, &ignored) != STRATA_OK ||
        base_output_open(&out, path, &ignored) != STRATA_OK)
        return;
    if (base_output_write(&out, &header, sizeof header, &ignored) == STRATA_OK &&
        base_output_write(&out, spirv->words[0], spirv->count[0] * 4, &ignored) == STRATA_OK &&
        base_output_write(&out, spirv->words[1], spirv->count[1] * 4, &ignored) == STRATA_OK)
        base_output_commit(&out, &ignored);
    else
        base_output_abort(&out);
}
