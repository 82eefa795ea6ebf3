/* SPDX-License-Identifier: MIT
 *
 * The OpenGL device: choosing it by index or name, its limits and features, what the driver
 * complains about, and the backend's table.
 */
#include "gpu/gl/gl_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef GL_GPU_MEMORY_INFO_DEDICATED_VIDMEM_NVX /* GL_NVX_gpu_memory_info; KiB */
#define GL_GPU_MEMORY_INFO_DEDICATED_VIDMEM_NVX 0x9047
#endif
#ifndef GL_SUBGROUP_SIZE_KHR /* GL_KHR_shader_subgroup */
#define GL_SUBGROUP_SIZE_KHR               0x9532
#define GL_SUBGROUP_SUPPORTED_STAGES_KHR   0x9533
#define GL_SUBGROUP_SUPPORTED_FEATURES_KHR 0x9534
#define GL_SUBGROUP_FEATURE_BALLOT_BIT_KHR 0x00000008
#endif

/* Synchronous: runs inside the call that is to blame. Remarks on performance are no defect, nor are
 * a compiler's on text that was generated (gl_text.c); what it refuses is seen by its status. */
static void APIENTRY message_arrived(GLenum source, GLenum type, GLuint id, GLenum severity,
                                     GLsizei length, const GLchar *text, const void *user) {
    gl *g = (gl *)(uintptr_t)user;
    (void)id, (void)length;
    int bad = type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR ||
              type == GL_DEBUG_TYPE_PORTABILITY || type == GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR ||
              (type != GL_DEBUG_TYPE_PERFORMANCE && source != GL_DEBUG_SOURCE_SHADER_COMPILER &&
               (severity == GL_DEBUG_SEVERITY_HIGH || severity == GL_DEBUG_SEVERITY_MEDIUM));
    if (!bad)
        base_log(BASE_LOG_DEBUG, "gl: %s", text);
    else if (g->message[0] == '\0')
        snprintf(g->message, sizeof g->message, "%s%s%s", g->where ? g->where : "",
                 g->where ? ": " : "", text);
}

strata_result gl_report(gl *g, strata_result result, const char *what, base_error *err) {
    GLenum code = GL_NO_ERROR, first = GL_NO_ERROR;
    for (uint32_t i = 0; i < 16 && (code = g->fn.GetError()) != GL_NO_ERROR; i++)
        if (first == GL_NO_ERROR || code == GL_OUT_OF_MEMORY || code == GL_CONTEXT_LOST)
            first = code;
    char message[sizeof g->message];
    memcpy(message, g->message, sizeof message);
    g->message[0] = '\0';
    if (first == GL_CONTEXT_LOST || g->fn.GetGraphicsResetStatus() != GL_NO_ERROR) {
        g->lost = 1;
        return base_fail(err, STRATA_ERROR_DEVICE_LOST, "gl: %s: the device was lost", what);
    }
    if (result != STRATA_OK)
        return result;
    if (first == GL_OUT_OF_MEMORY)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "gl: %s: out of device memory",
                         what);
    if (message[0] != '\0')
        return base_fail(err, STRATA_ERROR_INTERNAL, "gl: %s: the driver says: %s", what, message);
    if (first != GL_NO_ERROR)
        return base_fail(err, STRATA_ERROR_INTERNAL, "gl: %s: OpenGL error 0x%04x", what, first);
    return STRATA_OK;
}

static void device_text(const gl *g, char name[256], char driver[256]) {
    snprintf(name, 256, "%s", (const char *)g->fn.GetString(GL_RENDERER));
    snprintf(driver, 256, "%s", (const char *)g->fn.GetString(GL_VERSION));
}

static GLint integer_of(const gl *g, GLenum what) {
    GLint value = 0;
    g->fn.GetIntegerv(what, &value);
    return value;
}

static uint32_t groups_limit(const gl *g) {
    GLint least = INT32_MAX;
    for (GLuint axis = 0; axis < 3; axis++) {
        GLint value = 0;
        g->fn.GetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &value);
        least = value < least ? value : least;
    }
    return (uint32_t)least;
}

/* A power of two, in a mask's 32 bits. */
static uint32_t samples_limit(const gl *g) {
    static const GLenum limits[] = {GL_MAX_SAMPLES, GL_MAX_COLOR_TEXTURE_SAMPLES,
                                    GL_MAX_DEPTH_TEXTURE_SAMPLES};
    uint32_t samples = 32;
    for (size_t i = 0; i < BASE_COUNT(limits); i++)
        while (samples > 1 && (GLint)samples > integer_of(g, limits[i]))
            samples /= 2;
    return samples;
}

static void caps_fill(const gl *g, gpu_backend_caps *caps) {
    GLint64 range = 0;
    memset(caps, 0, sizeof *caps);
    device_text(g, caps->name, caps->driver);
    g->fn.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &range);
    caps->storage_range = (uint64_t)range;
    caps->texels = (uint64_t)integer_of(g, GL_MAX_TEXTURE_BUFFER_SIZE);
    caps->software = (uint32_t)gl_is_software(g);
    if (gl_has(g, "GL_NVX_gpu_memory_info"))
        caps->memory = (uint64_t)integer_of(g, GL_GPU_MEMORY_INFO_DEDICATED_VIDMEM_NVX) * 1024u;
    caps->image_size = (uint32_t)integer_of(g, GL_MAX_TEXTURE_SIZE);
    caps->groups = groups_limit(g);
    caps->samples = samples_limit(g);
    caps->storage_blocks = (uint32_t)integer_of(g, GL_MAX_COMPUTE_SHADER_STORAGE_BLOCKS);
    caps->subgroup = 1;
    if (gl_has(g, "GL_KHR_shader_subgroup")) {
        GLint stages = integer_of(g, GL_SUBGROUP_SUPPORTED_STAGES_KHR);
        GLint wanted = GL_FRAGMENT_SHADER_BIT | GL_COMPUTE_SHADER_BIT;
        caps->subgroup = (uint32_t)integer_of(g, GL_SUBGROUP_SIZE_KHR);
        caps->subgroup_ballot =
            (stages & wanted) == wanted && (integer_of(g, GL_SUBGROUP_SUPPORTED_FEATURES_KHR) &
                                            GL_SUBGROUP_FEATURE_BALLOT_BIT_KHR) != 0;
    }
    caps->int64 = gl_has(g, "GL_ARB_gpu_shader_int64") != 0;
    caps->int64_atomics = gl_has(g, "GL_NV_shader_atomic_int64") != 0;
    caps->fragment_interlock = gl_has(g, "GL_ARB_fragment_shader_interlock") &&
                               gl_has_spirv(g, "SPV_EXT_fragment_shader_interlock");
    caps->framebuffer_fetch =
        gl_has(g, "GL_EXT_shader_framebuffer_fetch") && gl_has(g, "GL_ARB_shader_draw_parameters");
    caps->stencil_export =
        gl_has(g, "GL_ARB_shader_stencil_export") &&
        (gl_has_spirv(g, "SPV_EXT_shader_stencil_export") || strstr(caps->driver, "Mesa") != NULL);
}

static strata_result state_init(gl *g, base_error *err) {
    const gl_functions *fn = &g->fn;
    if (g->check) {
        fn->Enable(GL_DEBUG_OUTPUT);
        fn->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        fn->DebugMessageCallback(message_arrived, g);
        fn->DebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, NULL, GL_TRUE);
    }
    g->limits[GPU_BINDING_UNIFORM] = integer_of(g, GL_MAX_UNIFORM_BUFFER_BINDINGS);
    g->limits[GPU_BINDING_STORAGE] = integer_of(g, GL_MAX_SHADER_STORAGE_BUFFER_BINDINGS);
    g->limits[GPU_BINDING_SAMPLED] = integer_of(g, GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS);
    g->limits[GPU_BINDING_STORAGE_IMAGE] = integer_of(g, GL_MAX_IMAGE_UNITS);
    g->ring_alignment = (uint32_t)integer_of(g, GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT);
    if (g->ring_alignment < 16)
        g->ring_alignment = 16;
    fn->CreateVertexArrays(1, &g->vertex_array);
    gl_state_set(g);
    return gl_report(g, STRATA_OK, "start-up", err);
}

/* Whether `wanted` (an index, a part of a name or NULL) means device `index` of that name. */
static int device_wanted(const char *wanted, uint32_t index, const char *name) {
    if (!wanted || wanted[0] == '\0')
        return 1;
    if (strspn(wanted, "0123456789") == strlen(wanted))
        return strtoul(wanted, NULL, 10) == index;
    return strstr(name, wanted) != NULL;
}

static void gl_close(void *self) {
    gl *g = self;
    if (!g)
        return;
    /* Where it cannot be made current (lost, or current elsewhere), its end frees what it holds. */
    if (g->entered > 0 || gl_enter(g, NULL) == STRATA_OK)
        gl_context_destroy(g);
    else
        eglDestroyContext(g->display, g->context);
    free(g->targets);
    free(g->samples);
    free(g->queries);
    free(g);
}

static strata_result gl_open(const gpu_open_info *info, void **self, gpu_backend_caps *caps,
                             base_error *err) {
    EGLDisplay displays[GPU_GL_MAX_DEVICES];
    uint32_t count = gl_displays(displays), index = 0;
    base_error first = {0};
    gl *g = base_calloc(1, sizeof *g);
    if (!g)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    g->check = info->check;
    for (uint32_t i = 0; i < count; i++) {
        char name[256], driver[256];
        if (gl_context_create(g, displays[i], &first) != STRATA_OK)
            continue;
        device_text(g, name, driver);
        if (device_wanted(info->device, index++, name))
            break;
        gl_context_destroy(g);
    }
    if (g->context == EGL_NO_CONTEXT) {
        free(g);
        if (index > 0)
            return base_fail(err, STRATA_ERROR_UNSUPPORTED, "no device '%s' among %u", info->device,
                             (unsigned)index);
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "%s",
                         first.result != STRATA_OK ? first.text : "EGL finds no device");
    }
    strata_result result = state_init(g, err);
    if (result != STRATA_OK) {
        gl_close(g);
        return result;
    }
    caps_fill(g, caps);
    gl_leave(g);
    *self = g;
    return STRATA_OK;
}

static void gl_enumerate(void (*found)(void *user, const gpu_device_info *info, uint32_t index),
                         void *user) {
    EGLDisplay displays[GPU_GL_MAX_DEVICES];
    uint32_t count = gl_displays(displays), index = 0;
    for (uint32_t i = 0; i < count; i++) {
        gl probe = {0};
        gpu_device_info info = {.backend = "gl"};
        if (gl_context_create(&probe, displays[i], NULL) != STRATA_OK)
            continue;
        device_text(&probe, info.name, info.driver);
        gl_context_destroy(&probe);
        found(user, &info, index++);
    }
}

static const char *gl_log(void *self) {
    (void)self;
    return NULL;
}

const gpu_backend gpu_backend_gl = {
    .name = "gl",
    .open = gl_open,
    .close = gl_close,
    .enumerate = gl_enumerate,
    .buffer_create = gl_buffer_create,
    .buffer_destroy = gl_buffer_destroy,
    .image_create = gl_image_create,
    .image_destroy = gl_image_destroy,
    .program_create = gl_program_create,
    .program_destroy = gl_program_destroy,
    .buffer_read = gl_buffer_read,
    .buffer_write = gl_buffer_write,
    .image_read = gl_image_read,
    .image_write = gl_image_write,
    .begin = gl_begin,
    .pass = gl_pass,
    .fill = gl_fill,
    .copy = gl_copy,
    .clear_image = gl_clear_image,
    .submit = gl_submit,
    .native_handle = gl_native_handle,
    .get_proc = gl_get_proc,
    .log = gl_log,
};
