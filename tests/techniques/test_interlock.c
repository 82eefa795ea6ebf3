/* SPDX-License-Identifier: MIT
 *
 * Programs with a section of the fragment interlock (strata/interlock.glsl), where no device has
 * one: all that kplus and kbuffer make of it, for Vulkan and for OpenGL, is SPIR-V that the Khronos
 * validator accepts, enters and leaves the section once, in order of primitives, and shares storage
 * that is coherent. That the code in the section is right, their own tests show.
 */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>
#include <spirv-tools/libspirv.h>
#include <spirv_cross/spirv.h>

#include "gpu/gpu_internal.h"
#include "render/render.h"

enum { FIRST_WORD = 5 };

static uint32_t sections; /* programs with one, since they were counted */

/* ---- one program ----------------------------------------------------------------------------- */

static void validate(const gpu_program_info *info, int stage, int vulkan_target) {
    spv_context context = spvContextCreate(vulkan_target ? SPV_ENV_VULKAN_1_3 : SPV_ENV_OPENGL_4_5);
    spv_diagnostic diagnostic = NULL;
    if (spvValidateBinary(context, info->spirv[stage], info->words[stage], &diagnostic) !=
        SPV_SUCCESS)
        fail_msg("%s, stage %d: %s", info->label, stage,
                 diagnostic ? diagnostic->error : "refused");
    spvDiagnosticDestroy(diagnostic);
    spvContextDestroy(context);
}

/* The instruction `op` of the fragment stage with this word at `place`, or NULL. */
static const uint32_t *find(const gpu_program_info *info, uint32_t op, uint32_t place,
                            uint32_t word) {
    const uint32_t *words = info->spirv[1];
    for (size_t at = FIRST_WORD; at < info->words[1]; at += words[at] >> 16)
        if ((words[at] & 0xffff) == op && words[at + place] == word)
            return &words[at];
    return NULL;
}

/* What the fragments of a pixel leave each other. */
static int is_shared(const char *name) {
    static const char *const shared[] = {"Cells", "Nodes", "State", "StrataKeys"};
    for (size_t i = 0; i < BASE_COUNT(shared); ++i)
        if (strcmp(name, shared[i]) == 0)
            return 1;
    return strncmp(name, "StrataPayload", 13) == 0 && name[13] >= '0' && name[13] <= '9';
}

static int is_coherent(const gpu_program_info *info, uint32_t type) {
    const uint32_t *words = info->spirv[1];
    for (size_t at = FIRST_WORD; at < info->words[1]; at += words[at] >> 16)
        if ((words[at] & 0xffff) == SpvOpMemberDecorate && words[at + 1] == type &&
            words[at + 3] == SpvDecorationCoherent)
            return 1;
    return 0;
}

/* How many storage blocks the stage shares; all are coherent. */
static uint32_t count_shared(const gpu_program_info *info) {
    const uint32_t *words = info->spirv[1];
    uint32_t count = 0;
    for (size_t at = FIRST_WORD; at < info->words[1]; at += words[at] >> 16) {
        if ((words[at] & 0xffff) != SpvOpVariable)
            continue;
        const uint32_t *pointer = find(info, SpvOpTypePointer, 1, words[at + 1]),
                       *name = pointer ? find(info, SpvOpName, 1, pointer[3]) : NULL;
        if (!name || !is_shared((const char *)&name[2]))
            continue;
        if (!is_coherent(info, pointer[3]))
            fail_msg("%s: %s is not coherent", info->label, (const char *)&name[2]);
        ++count;
    }
    return count;
}

static void check_program(const gpu_program_info *info, int vulkan_target) {
    const uint32_t *words = info->spirv[1];
    uint32_t begins = 0, ends = 0, ordered = 0;
    for (size_t at = FIRST_WORD; at < info->words[1]; at += words[at] >> 16) {
        const uint32_t op = words[at] & 0xffff;
        begins += op == SpvOpBeginInvocationInterlockEXT;
        ends += op == SpvOpEndInvocationInterlockEXT;
        ordered +=
            op == SpvOpExecutionMode && words[at + 2] == SpvExecutionModePixelInterlockOrderedEXT;
        if (ends > begins)
            fail_msg("%s: the section is left before it is entered", info->label);
    }
    if (begins + ends + ordered == 0)
        return;
    if (begins != 1 || ends != 1 || ordered != 1)
        fail_msg("%s: %u times entered, %u left, %u modes", info->label, begins, ends, ordered);
    assert_true(count_shared(info) > 0);
    validate(info, 0, vulkan_target);
    validate(info, 1, vulkan_target);
    ++sections;
}

/* ---- a device of either kind ----------------------------------------------------------------- */

static strata_result look_vulkan(void *self, const gpu_program_info *info, void **native,
                                 base_error *err) {
    check_program(info, 1);
    return gpu_backend_null.program_create(self, info, native, err);
}

static strata_result look_gl(void *self, const gpu_program_info *info, void **native,
                             base_error *err) {
    check_program(info, 0);
    return gpu_backend_null.program_create(self, info, native, err);
}

/* The null backend, which takes SPIR-V of that kind and has an interlock. */
static strata *open_device(gpu_backend *looking, int vulkan_target, int int64) {
    const strata_open_options open = {.struct_size = sizeof open,
                                      .backend = "null",
                                      .inject =
                                          "claims:selftest.interlock,lacks:ordered_attachments"};
    strata *s = NULL;
    base_error err = {0};
    assert_int_equal(strata_open(&open, &s), STRATA_OK);
    assert_int_equal(render_device(s, &err), STRATA_OK);
    *looking = gpu_backend_null;
    looking->program_create = vulkan_target ? look_vulkan : look_gl;
    s->gpu->backend = looking;
    s->gpu->caps.vulkan_target = (uint32_t)vulkan_target;
    s->gpu->caps.fragment_interlock = 1;
    s->gpu->caps.int64 = (uint32_t)int64;
    memset(s->gpu->selftests, 0, sizeof s->gpu->selftests);
    return s;
}

/* ---- the techniques -------------------------------------------------------------------------- */

typedef struct row {
    const char *use;
    const char *settings[5];
} row;

static const row rows[] = {
    {"kplus,ppc", {"kplus.exclusion=interlock", "kplus.structure=array"}},
    {"kplus,ppc", {"kplus.exclusion=interlock", "kplus.structure=heap", "kplus.payload=half"}},
    {"kplus,ppc", {"kplus.exclusion=interlock", "kplus.structure=array", "kplus.memory=exact"}},
    {"kplus,ppc",
     {"kplus.exclusion=interlock", "kplus.structure=heap", "kplus.memory=exact",
      "kplus.payload=unorm8"}},
    {"kplus,ppc", {"kplus.exclusion=auto"}},
    {"kbuffer", {"kbuffer.k=1"}},
    {"kbuffer", {"kbuffer.k=16", "kbuffer.payload=unorm8"}},
};

static void check_row(const row *r, const char *path, uint32_t outputs, int device) {
    gpu_backend looking;
    strata_scene *sc = NULL;
    strata_render_options options = {.struct_size = sizeof options,
                                     .width = 16,
                                     .height = 16,
                                     .use = r->use,
                                     .settings = r->settings,
                                     .outputs = outputs};
    while (r->settings[options.setting_count])
        ++options.setting_count;
    strata *s = open_device(&looking, device & 1, device >> 1);
    sections = 0;
    if (strata_scene_load(s, path, &sc) != STRATA_OK || strata_render(s, sc, &options) < 0)
        fail_msg("%s, %s %s: %s", path, r->use, r->settings[0], strata_error(s));
    if (sections != 1)
        fail_msg("%s, %s %s: %u programs with a section", path, r->use, r->settings[0], sections);
    strata_close(s);
}

static void every_section_is_sound(void **state) {
    static const char *const paths[] = {"scene:soup?small=30&medium=3", "scene:glass"};
    static const uint32_t outputs[] = {0, STRATA_OUTPUT_BOUND};
    (void)state;
    for (int device = 0; device < 4; ++device)
        for (size_t p = 0; p < BASE_COUNT(paths); ++p)
            for (size_t o = 0; o < BASE_COUNT(outputs); ++o)
                for (size_t i = 0; i < BASE_COUNT(rows); ++i)
                    check_row(&rows[i], paths[p], outputs[o], device);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_section_is_sound)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
