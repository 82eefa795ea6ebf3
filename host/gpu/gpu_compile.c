/* SPDX-License-Identifier: MIT
 *
 * GLSL to SPIR-V through glslang's C interface, for Vulkan or for OpenGL. All stages of a program
 * are linked together, so that varyings match by name or by location; bindings come out arbitrary
 * and are numbered by gpu_reflect.
 */
#include "gpu/gpu_internal.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <glslang/Include/glslang_c_interface.h>
#include <glslang/Public/resource_limits_c.h>
#include <glslang/build_info.h>

#define SPIRV_MAGIC 0x07230203u

static pthread_once_t initialised = PTHREAD_ONCE_INIT;

static void initialise(void) {
    glslang_initialize_process(); /* once a process; its tables live as long as it does */
}

uint32_t gpu_compiler_version(void) {
    return GLSLANG_VERSION_MAJOR * 10000u + GLSLANG_VERSION_MINOR * 100u + GLSLANG_VERSION_PATCH;
}

void gpu_spirv_free(gpu_spirv *spirv) {
    free(spirv->words[0]);
    free(spirv->words[1]);
    *spirv = (gpu_spirv){0};
}

/* A message of the linker goes over several lines, the names in question in the last. */
static strata_result fail_linking(const char *label, const char *message, base_error *err) {
    char line[384];
    const char *end = strstr(message, "\nERROR: ");
    size_t length = end ? (size_t)(end - message) : strlen(message), used = 0;
    for (size_t i = 0; i < length && used + 1 < sizeof line; i++) {
        int blank = message[i] == '\n' || message[i] == ' ';
        if (!blank || (used && line[used - 1] != ' '))
            line[used++] = blank ? ' ' : message[i];
    }
    while (used && line[used - 1] == ' ')
        used--;
    return base_fail(err, STRATA_ERROR_SHADER, "%s: %.*s", label, (int)used, line);
}

/* The first error of the log, "ERROR: SOURCE:LINE: text", as "path:line: text". */
static strata_result fail_from_log(const char *label, const gpu_source *source, const char *log,
                                   base_error *err) {
    const char *line = log ? strstr(log, "ERROR: ") : NULL;
    if (!line)
        return fail_linking(label, log && log[0] ? log : "the compiler gave no reason", err);
    line += strlen("ERROR: ");
    size_t length = strcspn(line, "\n");
    char *end = NULL;
    unsigned long number = strtoul(line, &end, 10);
    if (end == line || *end != ':' || !source || number >= source->path_count)
        return fail_linking(label, line, err);
    return base_fail(err, STRATA_ERROR_SHADER, "%s%.*s", source->paths[number],
                     (int)(length - (size_t)(end - line)), end);
}

static glslang_shader_t *parse(const char *label, const gpu_source *source, glslang_stage_t stage,
                               int vulkan_target, glslang_messages_t messages, base_error *err) {
    const glslang_input_t input = {
        .language = GLSLANG_SOURCE_GLSL,
        .stage = stage,
        .client = vulkan_target ? GLSLANG_CLIENT_VULKAN : GLSLANG_CLIENT_OPENGL,
        .client_version = vulkan_target ? GLSLANG_TARGET_VULKAN_1_3 : GLSLANG_TARGET_OPENGL_450,
        .target_language = GLSLANG_TARGET_SPV,
        .target_language_version = vulkan_target ? GLSLANG_TARGET_SPV_1_5 : GLSLANG_TARGET_SPV_1_0,
        .code = source->text.data,
        .default_version = 460,
        .default_profile = GLSLANG_CORE_PROFILE,
        .messages = messages,
        .resource = glslang_default_resource(),
    };
    glslang_shader_t *shader = glslang_shader_create(&input);
    if (!shader) {
        base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory to compile", label);
        return NULL;
    }
    glslang_shader_set_options(shader, GLSLANG_SHADER_AUTO_MAP_BINDINGS |
                                           GLSLANG_SHADER_AUTO_MAP_LOCATIONS);
    if (!glslang_shader_preprocess(shader, &input) || !glslang_shader_parse(shader, &input)) {
        const char *log = glslang_shader_get_info_log(shader);
        base_log(BASE_LOG_DEBUG, "%s", log);
        fail_from_log(label, source, log, err);
        glslang_shader_delete(shader);
        return NULL;
    }
    return shader;
}

/* Some releases of glslang append a program's second module to its first: skips what was there. */
static size_t skip_earlier(const uint32_t *words, size_t count, const uint32_t *earlier,
                           size_t earlier_count) {
    int appended = earlier_count && count > earlier_count && words[earlier_count] == SPIRV_MAGIC &&
                   memcmp(words, earlier, earlier_count * sizeof *words) == 0;
    return appended ? earlier_count : 0;
}

static strata_result generate(glslang_program_t *program, glslang_stage_t stage, const char *label,
                              gpu_spirv *out, int index, base_error *err) {
    glslang_program_SPIRV_generate(program, stage);
    size_t count = glslang_program_SPIRV_get_size(program);
    const uint32_t *words = glslang_program_SPIRV_get_ptr(program);
    size_t skipped = index ? skip_earlier(words, count, out->words[0], out->count[0]) : 0;
    count -= skipped;
    if (count == 0)
        return base_fail(err, STRATA_ERROR_SHADER, "%s: no SPIR-V", label);
    out->words[index] = base_calloc(count, sizeof *words);
    if (!out->words[index])
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", label);
    memcpy(out->words[index], words + skipped, count * sizeof *words);
    out->count[index] = count;
    return STRATA_OK;
}

strata_result gpu_compile(const char *label, uint32_t kind, int vulkan_target,
                          const gpu_source sources[2], gpu_spirv *out, base_error *err) {
    const int stage_count = kind == STRATA_PROGRAM_COMPUTE ? 1 : 2;
    const glslang_stage_t stages[2] = {kind == STRATA_PROGRAM_COMPUTE ? GLSLANG_STAGE_COMPUTE
                                                                      : GLSLANG_STAGE_VERTEX,
                                       GLSLANG_STAGE_FRAGMENT};
    glslang_messages_t messages = GLSLANG_MSG_SPV_RULES_BIT;
    if (vulkan_target)
        messages = (glslang_messages_t)(messages | GLSLANG_MSG_VULKAN_RULES_BIT);
    glslang_shader_t *shaders[2] = {NULL, NULL};
    strata_result result = STRATA_OK;

    pthread_once(&initialised, initialise);
    glslang_program_t *program = glslang_program_create();
    if (!program)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory to compile", label);
    for (int i = 0; i < stage_count; i++) {
        shaders[i] = parse(label, &sources[i], stages[i], vulkan_target, messages, err);
        if (!shaders[i]) {
            result = err ? err->result : STRATA_ERROR_SHADER;
            goto cleanup;
        }
        glslang_program_add_shader(program, shaders[i]);
    }
    if (!glslang_program_link(program, messages) || !glslang_program_map_io(program)) {
        result = fail_from_log(label, NULL, glslang_program_get_info_log(program), err);
        goto cleanup;
    }
    for (int i = 0; i < stage_count && result == STRATA_OK; i++)
        result = generate(program, stages[i], label, out, i, err);
cleanup:
    glslang_program_delete(program);
    for (int i = 0; i < stage_count; i++)
        if (shaders[i])
            glslang_shader_delete(shaders[i]);
    if (result != STRATA_OK)
        gpu_spirv_free(out);
    return result;
}
