/* SPDX-License-Identifier: MIT
 *
 * Native passes on real devices: a callback's own OpenGL or Vulkan calls between passes of the
 * host, with exact results; OpenGL state left in ruins, which the passes after must not notice;
 * and a callback's error, which fails the frame by the pass's name.
 */
#define VK_NO_PROTOTYPES
#include "gpu/rig.h"

#include <GL/glcorearb.h>
#include <stdlib.h>
#include <vulkan/vulkan.h>

#define SIZE  16u
#define WORDS (SIZE * SIZE)

static const char *const produce = "layout(local_size_x = 64) in;\n"
                                   "layout(std430) writeonly buffer Source { uint source[]; };\n"
                                   "void main() {\n"
                                   "    uint i = gl_GlobalInvocationID.x;\n"
                                   "    source[i] = i * 747796405u + 7u;\n"
                                   "}\n";
static const char *const consume = "layout(std430) readonly buffer Target { uint target[]; };\n"
                                   "layout(location = 0) out uvec4 color;\n"
                                   "void main() {\n"
                                   "    uvec2 at = uvec2(gl_FragCoord.xy);\n"
                                   "    color = uvec4(target[at.y * 16u + at.x], at, 1u);\n"
                                   "}\n";

static const char *const flat = "STRATA_PARAMS { vec4 color; } params;\n"
                                "layout(location = 0) out vec4 color;\n"
                                "void main() { color = params.color; }\n";

static int open_gl(void **state) {
    *state = rig_open("gl");
    return 0;
}

static int open_vulkan(void **state) {
    *state = rig_open("vulkan");
    return 0;
}

static int close_rig(void **state) {
    if (*state)
        rig_close(*state);
    return 0;
}

static rig *rig_of(void **state) {
    if (!*state)
        skip();
    rig_clear(*state);
    return *state;
}

/* ---- compute -> native copy and fill -> draw
 * ------------------------------------------------------------------------- */

typedef void (*any_function)(void);

static any_function find(rig *r, const char *name) {
    void *address = gpu_native_proc(r->g, name);
    any_function function;
    assert_non_null(address);
    memcpy(&function, &address, sizeof function);
    return function;
}

#define FN(type, name) ((type)find(r, name))

typedef struct chain {
    rig *r;
    strata_buffer source, target;
    strata_image color;
    void (*wreck)(rig *r, uint32_t framebuffer); /* or NULL */
    unsigned calls;
} chain;

static void transfer_gl(void *user, uint64_t framebuffer) {
    chain *c = user;
    rig *r = c->r;
    const uint32_t constant = 0xabcd1234u;
    const GLuint source = (GLuint)gpu_native_buffer(r->g, c->source),
                 target = (GLuint)gpu_native_buffer(r->g, c->target);
    c->calls++;
    FN(PFNGLCOPYNAMEDBUFFERSUBDATAPROC, "glCopyNamedBufferSubData")
    (source, target, 0, 0, WORDS * 2);
    FN(PFNGLCLEARNAMEDBUFFERSUBDATAPROC, "glClearNamedBufferSubData")
    (target, GL_R32UI, WORDS * 2, WORDS * 2, GL_RED_INTEGER, GL_UNSIGNED_INT, &constant);
    if (c->wreck)
        c->wreck(r, (uint32_t)framebuffer);
}

static void transfer_vulkan(void *user, uint64_t handle) {
    chain *c = user;
    rig *r = c->r;
    const VkCommandBuffer commands = (VkCommandBuffer)(uintptr_t)handle;
    const VkBuffer source = (VkBuffer)gpu_native_buffer(r->g, c->source),
                   target = (VkBuffer)gpu_native_buffer(r->g, c->target);
    const VkBufferCopy half = {.size = WORDS * 2};
    c->calls++;
    FN(PFN_vkCmdCopyBuffer, "vkCmdCopyBuffer")(commands, source, target, 1, &half);
    FN(PFN_vkCmdFillBuffer, "vkCmdFillBuffer")
    (commands, target, WORDS * 2, WORDS * 2, 0xabcd1234u);
}

static chain chain_make(rig *r) {
    return (chain){.r = r,
                   .source = rig_buffer(r, "source", WORDS * 4, NULL),
                   .target = rig_buffer(r, "target", WORDS * 4, NULL),
                   .color = rig_image(r, "color", STRATA_FORMAT_RGBA32U, SIZE, SIZE, 0)};
}

static void chain_record(chain *c) {
    rig *r = c->r;
    const strata_bind source = rig_bind_buffer("Source", c->source),
                      target = rig_bind_buffer("Target", c->target);
    const strata_bind both[] = {source, target};
    const strata_attachment color = {.struct_size = sizeof color, .image = c->color};
    rig_pass(r, (strata_pass){.program = rig_program(r, STRATA_PROGRAM_COMPUTE, produce),
                              .groups = {WORDS / 64},
                              .binds = &source,
                              .bind_count = 1});
    const strata_pass native = {
        .struct_size = sizeof native, .label = "native", .binds = both, .bind_count = 2};
    gpu_pass_native(r->g, "test", &native, strcmp(r->backend, "gl") ? transfer_vulkan : transfer_gl,
                    c);
    rig_pass(r, (strata_pass){.program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, consume),
                              .binds = &target,
                              .bind_count = 1,
                              .color = &color,
                              .color_count = 1});
}

static void chain_check(chain *c) {
    uint32_t texels[WORDS][4];
    rig_submit(c->r);
    assert_int_equal(c->calls, 1);
    rig_texels(c->r, c->color, 0, texels, sizeof texels);
    for (uint32_t i = 0; i < WORDS; i++) {
        assert_int_equal(texels[i][0], i < WORDS / 2 ? i * 747796405u + 7u : 0xabcd1234u);
        assert_int_equal(texels[i][1], i % SIZE);
        assert_int_equal(texels[i][2], i / SIZE);
    }
}

static void between_passes(void **state) {
    chain c = chain_make(rig_of(state));
    gpu_begin(c.r->g, SIZE, SIZE);
    chain_record(&c);
    chain_check(&c);
}

/* Timed passes too, whether by queries or by the clock. */
static void while_timed(void **state) {
    rig *r = rig_of(state);
    rig timed = {.backend = r->backend};
    base_error err = {0};
    const gpu_open_info info = {.backend = r->backend, .check = 1, .profile = 1};
    uint32_t count = 0;
    assert_int_equal(gpu_open(&info, &timed.g, &err), STRATA_OK);
    timed.scope = gpu_scope_create(timed.g, "test");
    chain c = chain_make(&timed);
    gpu_begin(timed.g, SIZE, SIZE);
    chain_record(&c);
    chain_check(&c);
    const gpu_timing *timings = gpu_timings(timed.g, &count);
    assert_int_equal(count, 3);
    assert_string_equal(timings[1].label, "native");
    assert_true(timings[1].gpu_ms >= 0);
    gpu_close(timed.g);
}

/* ---- objects
 * --------------------------------------------------------------------------------------------------------
 */

static strata_pool make_pool(rig *r) {
    const strata_pool_desc desc = {.struct_size = sizeof desc,
                                   .label = "pool",
                                   .plane_count = 2,
                                   .counter_name = "Counter",
                                   .plane_names = {"Keys", "Data"},
                                   .plane_strides = {8, 4},
                                   .expected = 64};
    strata_pool pool;
    base_error err = {0};
    assert_int_equal(gpu_pool_create(r->scope, &desc, &pool, &err), STRATA_OK);
    return pool;
}

static void handles(void **state) {
    rig *r = rig_of(state);
    const int is_vulkan = strcmp(r->backend, "vulkan") == 0;
    const strata_buffer buffer = rig_buffer(r, "buffer", 64, NULL);
    const strata_image image = rig_image(r, "image", STRATA_FORMAT_R32F, 4, 4, 0);
    const strata_pool pool = make_pool(r);
    assert_true(gpu_native_buffer(r->g, buffer) != 0);
    assert_true(gpu_native_image(r->g, image, GPU_NATIVE_IMAGE) != 0);
    assert_int_equal(gpu_native_image(r->g, image, GPU_NATIVE_VIEW) != 0, is_vulkan);
    for (gpu_native_kind kind = GPU_NATIVE_INSTANCE; kind < GPU_NATIVE_BUFFER; kind++)
        assert_int_equal(gpu_native_object(r->g, kind) != 0, is_vulkan);
    const uint64_t first = gpu_native_pool(r->g, pool, 0), second = gpu_native_pool(r->g, pool, 1),
                   counter = gpu_native_pool(r->g, pool, 2);
    assert_true(first && second && counter && first != second && second != counter);
    assert_int_equal(gpu_native_pool(r->g, pool, 3), 0);
    assert_int_equal(gpu_native_buffer(r->g, (strata_buffer){9999}), 0);
    assert_int_equal(gpu_native_buffer(r->g, (strata_buffer){image.id}), 0);
    assert_int_equal(gpu_native_image(r->g, (strata_image){0}, GPU_NATIVE_IMAGE), 0);
    assert_int_equal(gpu_native_image(r->g, image, GPU_NATIVE_BUFFER), 0);
    assert_int_equal(gpu_native_pool(r->g, (strata_pool){9999}, 0), 0);
    assert_non_null(gpu_native_proc(r->g, is_vulkan ? "vkCmdCopyBuffer" : "glFinish"));
}

/* ---- OpenGL: state and errors
 * --------------------------------------------------------------------------------------- */

static void wreck(rig *r, uint32_t framebuffer) {
    static const GLenum on[] = {GL_RASTERIZER_DISCARD, GL_DEPTH_TEST,       GL_STENCIL_TEST,
                                GL_CULL_FACE,          GL_COLOR_LOGIC_OP,   GL_BLEND,
                                GL_PRIMITIVE_RESTART,  GL_FRAMEBUFFER_SRGB, GL_CLIP_DISTANCE0};
    GLuint sampler = 0, pixels = 0;
    for (size_t i = 0; i < BASE_COUNT(on); i++)
        FN(PFNGLENABLEPROC, "glEnable")(on[i]);
    FN(PFNGLDISABLEPROC, "glDisable")(GL_SCISSOR_TEST);
    FN(PFNGLCLIPCONTROLPROC, "glClipControl")(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    FN(PFNGLFRONTFACEPROC, "glFrontFace")(GL_CW);
    FN(PFNGLPROVOKINGVERTEXPROC, "glProvokingVertex")(GL_LAST_VERTEX_CONVENTION);
    FN(PFNGLPOLYGONMODEPROC, "glPolygonMode")(GL_FRONT_AND_BACK, GL_POINT);
    FN(PFNGLDEPTHRANGEFPROC, "glDepthRangef")(1.0f, 0.0f);
    FN(PFNGLDEPTHMASKPROC, "glDepthMask")(GL_FALSE);
    FN(PFNGLCOLORMASKPROC, "glColorMask")(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    FN(PFNGLVIEWPORTPROC, "glViewport")(3, 3, 1, 1);
    FN(PFNGLSCISSORPROC, "glScissor")(0, 0, 1, 1);
    FN(PFNGLPIXELSTOREIPROC, "glPixelStorei")(GL_PACK_ALIGNMENT, 8);
    FN(PFNGLPIXELSTOREIPROC, "glPixelStorei")(GL_PACK_ROW_LENGTH, 100);
    FN(PFNGLPIXELSTOREIPROC, "glPixelStorei")(GL_PACK_SKIP_ROWS, 3);
    FN(PFNGLCREATESAMPLERSPROC, "glCreateSamplers")(1, &sampler);
    FN(PFNGLBINDSAMPLERPROC, "glBindSampler")(0, sampler);
    FN(PFNGLCREATEBUFFERSPROC, "glCreateBuffers")(1, &pixels);
    FN(PFNGLBINDBUFFERPROC, "glBindBuffer")(GL_PIXEL_PACK_BUFFER, pixels);
    FN(PFNGLUSEPROGRAMPROC, "glUseProgram")(0);
    FN(PFNGLBINDVERTEXARRAYPROC, "glBindVertexArray")(0);
    FN(PFNGLBINDFRAMEBUFFERPROC, "glBindFramebuffer")(GL_FRAMEBUFFER, framebuffer);
}

static void wreck_only(void *user, uint64_t framebuffer) {
    wreck(user, (uint32_t)framebuffer);
}

static void state_in_ruins(void **state) {
    chain c = chain_make(rig_of(state));
    c.wreck = wreck;
    gpu_begin(c.r->g, SIZE, SIZE);
    chain_record(&c);
    chain_check(&c);

    rig *r = c.r; /* culling knows front from back, depth its range, and the rectangle cuts */
    float texels[WORDS][4], depths[WORDS];
    const float one[4] = {1, 1, 1, 1};
    const strata_image cut = rig_image(r, "cut", STRATA_FORMAT_RGBA32F, SIZE, SIZE, 0),
                       deep = rig_image(r, "depth", STRATA_FORMAT_D32F, SIZE, SIZE, 0);
    const strata_attachment color = {.struct_size = sizeof color, .image = cut};
    const strata_attachment depth = {
        .struct_size = sizeof depth, .image = deep, .load = STRATA_LOAD_CLEAR, .clear = {0.25f}};
    const strata_pass own = {.struct_size = sizeof own, .label = "native"};
    const strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, flat);
    gpu_begin(r->g, SIZE, SIZE);
    gpu_rectangle(r->g, 4, 2, 8, 8);
    gpu_pass_native(r->g, "test", &own, wreck_only, r);
    rig_pass(r, (strata_pass){.program = program,
                              .params = one,
                              .params_size = 16,
                              .color = &color,
                              .color_count = 1,
                              .depth = &depth,
                              .depth_write = 1,
                              .cull = 1});
    rig_submit(r);
    rig_texels(r, deep, 0, depths, sizeof depths);
    rig_texels(r, cut, 0, texels, sizeof texels);
    for (uint32_t i = 0; i < WORDS; i++) {
        const int inside = i % SIZE >= 4 && i % SIZE < 12 && i / SIZE >= 2 && i / SIZE < 10;
        assert_true(texels[i][0] == (inside ? 1.0f : 0.0f));
        assert_true(depths[i] == (inside ? 0.0f : 0.25f)); /* the far plane */
    }
}

static void draw_gl(void *user, uint64_t framebuffer) {
    rig *r = user;
    const float blue[4] = {0, 0, 1, 1};
    GLint bound = 0;
    assert_true(framebuffer != 0);
    FN(PFNGLCLEARNAMEDFRAMEBUFFERFVPROC, "glClearNamedFramebufferfv")
    ((GLuint)framebuffer, GL_COLOR, 0, blue);
    FN(PFNGLGETINTEGERVPROC, "glGetIntegerv")(GL_MAJOR_VERSION, &bound);
    assert_in_range(bound, 4, 9);
}

/* The framebuffer is the pass's; what the attachment asks to load is the callback's own matter. */
static void framebuffer_of_the_pass(void **state) {
    rig *r = rig_of(state);
    float texels[WORDS][4];
    strata_image image = rig_image(r, "image", STRATA_FORMAT_RGBA32F, SIZE, SIZE, 0);
    strata_attachment color = {
        .struct_size = sizeof color, .image = image, .load = STRATA_LOAD_CLEAR, .clear = {1}};
    strata_pass pass = {
        .struct_size = sizeof pass, .label = "native", .color = &color, .color_count = 1};
    for (uint32_t rows = 4; rows <= SIZE; rows += SIZE - 4) {
        gpu_begin(r->g, SIZE, SIZE);
        gpu_rectangle(r->g, 0, 0, SIZE, rows);
        gpu_pass_native(r->g, "test", &pass, wreck_only, r);
        gpu_pass_native(r->g, "test", &pass, draw_gl, r);
        rig_submit(r);
        rig_texels(r, image, 0, texels, sizeof texels);
        for (uint32_t i = 0; i < WORDS; i++)
            assert_true(texels[i][0] == 0 && texels[i][2] == (i < rows * SIZE ? 1.0f : 0.0f));
    }
    pass.whole_frame = 1;
    image = rig_image(r, "image", STRATA_FORMAT_RGBA32F, SIZE, SIZE, 0);
    color.image = image;
    gpu_rectangle(r->g, 0, 0, 1, 1);
    gpu_pass_native(r->g, "test", &pass, draw_gl, r);
    rig_submit(r);
    rig_texels(r, image, 0, texels, sizeof texels);
    for (uint32_t i = 0; i < WORDS; i++)
        assert_true(texels[i][2] == 1);
}

static void mistake_gl(void *user, uint64_t framebuffer) {
    rig *r = user;
    (void)framebuffer;
    FN(PFNGLENABLEPROC, "glEnable")(0xffffu);
}

/* With the driver's validation, and without it. */
static void error_names_the_pass(void **state) {
    const strata_pass pass = {.struct_size = sizeof pass, .label = "mistaken"};
    base_error err = {0};
    rig *checked = rig_of(state), unchecked = {.backend = "gl"};
    assert_int_equal(gpu_open(&(gpu_open_info){.backend = "gl"}, &unchecked.g, &err), STRATA_OK);
    unchecked.scope = gpu_scope_create(unchecked.g, "test");
    for (int i = 0; i < 2; i++) {
        rig *r = i ? checked : &unchecked;
        gpu_begin(r->g, SIZE, SIZE);
        gpu_pass_native(r->g, "test", &pass, mistake_gl, r);
        assert_int_equal(gpu_submit(r->g, &err), STRATA_ERROR_INTERNAL);
        assert_non_null(strstr(err.text, "mistaken"));
        chain c = chain_make(r); /* and the next frame is as good as ever */
        gpu_begin(r->g, SIZE, SIZE);
        chain_record(&c);
        chain_check(&c);
    }
    gpu_close(unchecked.g);
}

int main(void) {
    const struct CMUnitTest both[] = {
        cmocka_unit_test(between_passes),
        cmocka_unit_test(while_timed),
        cmocka_unit_test(handles),
    };
    const struct CMUnitTest gl[] = {
        cmocka_unit_test(state_in_ruins),
        cmocka_unit_test(framebuffer_of_the_pass),
        cmocka_unit_test(error_names_the_pass),
    };
    return cmocka_run_group_tests_name("vulkan", both, open_vulkan, close_rig) +
           cmocka_run_group_tests_name("gl", both, open_gl, close_rig) +
           cmocka_run_group_tests_name("gl alone", gl, open_gl, close_rig);
}
