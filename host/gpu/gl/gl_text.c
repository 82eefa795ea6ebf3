/* SPDX-License-Identifier: MIT
 *
 * Programs whose fragments read the attachments that they replace. GL_EXT_shader_framebuffer_fetch
 * has no SPIR-V, and a program cannot mix SPIR-V with text, so both stages are written out as GLSL
 * by SPIRV-Cross: precise and invariant stay, bindings too. The outputs that are read become inout.
 */
#include "gpu/gl/gl_internal.h"

#include <stdlib.h>
#include <string.h>

#include <spirv_cross/spirv_cross_c.h>

/* "out vec4 strata_ordered_0" is declared inout; vertex stages have no such output. */
static void declare_inout(base_text *to, const char *text) {
    static const char *const outputs[] = {" out vec4 strata_ordered_",
                                          " out uvec4 strata_ordered_"};
    while (*text) {
        const char *next = NULL;
        for (size_t i = 0; i < BASE_COUNT(outputs); i++) {
            const char *found = strstr(text, outputs[i]);
            if (found && (!next || found < next))
                next = found;
        }
        const size_t length = next ? (size_t)(next - text) : strlen(text);
        base_text_append(to, text, length);
        text += length;
        if (next) {
            base_text_append(to, " in", 3);
            base_text_append(to, ++text, 3);
            text += 3;
        }
    }
}

static int write_glsl(spvc_context context, const uint32_t *spirv, size_t words, base_text *out) {
    const unsigned version = 450; /* what every driver takes that takes the extension */
    spvc_parsed_ir ir;
    spvc_compiler compiler;
    spvc_compiler_options options;
    const char *text = NULL;
    if (spvc_context_parse_spirv(context, spirv, words, &ir) != SPVC_SUCCESS ||
        spvc_context_create_compiler(context, SPVC_BACKEND_GLSL, ir,
                                     SPVC_CAPTURE_MODE_TAKE_OWNERSHIP, &compiler) != SPVC_SUCCESS ||
        spvc_compiler_create_compiler_options(compiler, &options) != SPVC_SUCCESS)
        return 0;
    spvc_compiler_options_set_uint(options, SPVC_COMPILER_OPTION_GLSL_VERSION, version);
    spvc_compiler_options_set_bool(options, SPVC_COMPILER_OPTION_GLSL_ES, SPVC_FALSE);
    spvc_compiler_require_extension(compiler, "GL_EXT_shader_framebuffer_fetch");
    if (spvc_compiler_install_compiler_options(compiler, options) != SPVC_SUCCESS ||
        spvc_compiler_compile(compiler, &text) != SPVC_SUCCESS)
        return 0;
    declare_inout(out, text);
    return !out->failed;
}

static GLuint compile(gl *g, GLenum stage, const char *text, const char *label, base_error *err) {
    GLint done = 0;
    GLuint shader = g->fn.CreateShader(stage);
    g->fn.ShaderSource(shader, 1, &text, NULL);
    g->fn.CompileShader(shader);
    g->fn.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (done)
        return shader;
    char log[300] = "";
    g->fn.GetShaderInfoLog(shader, sizeof log, NULL, log);
    g->fn.DeleteShader(shader);
    base_log(BASE_LOG_DEBUG, "%s", text);
    base_fail(err, STRATA_ERROR_SHADER, "gl: program %s: the driver refuses its text: %s", label,
              log);
    return 0;
}

static GLuint translate(gl *g, spvc_context context, const gpu_program_info *info, uint32_t index,
                        base_error *err) {
    static const GLenum stages[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    base_text text = {0};
    GLuint shader = 0;
    if (write_glsl(context, info->spirv[index], info->words[index], &text))
        shader = compile(g, stages[index], text.data, info->label, err);
    else
        base_fail(err, STRATA_ERROR_SHADER, "gl: program %s: no GLSL of its SPIR-V: %s",
                  info->label, spvc_context_get_last_error_string(context));
    base_text_free(&text);
    return shader;
}

GLuint gl_text_build(gl *g, const gpu_program_info *info, base_error *err) {
    GLuint shaders[2] = {0, 0}, program = 0;
    spvc_context context;
    if (spvc_context_create(&context) != SPVC_SUCCESS) {
        base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "gl: program %s: no memory", info->label);
        return 0;
    }
    shaders[0] = translate(g, context, info, 0, err);
    if (shaders[0])
        shaders[1] = translate(g, context, info, 1, err);
    if (shaders[1])
        program = gl_link(g, shaders, 2, info->label, err);
    else
        g->fn.DeleteShader(shaders[0]); /* ignores 0 */
    spvc_context_destroy(context);
    return program;
}
