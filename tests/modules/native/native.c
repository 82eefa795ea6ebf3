/* SPDX-License-Identifier: MIT
 *
 * A technique for the tests of the native extensions: compute -> native pass -> draw. Where neither
 * extension is there, or the knob `path` says portable, the host's own copies and fills stand in
 * for the native pass; the picture is the same.
 */
#include "native.h"

#include <stddef.h>

#include "native_glsl.h"

enum { PATH_NATIVE, PATH_PORTABLE };
enum { FAULT_NONE, FAULT_PREPARE, FAULT_LABEL, FAULT_CALLBACK, FAULT_CALL };

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *out) {
    (void)stats, (void)settings;
    out->bytes_per_pixel = 8;
    return STRATA_OK;
}

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    native *n = state;
    n->gpu = gpu;
    n->gl = host->extension(host->self, STRATA_EXT_GL);
    n->vulkan = host->extension(host->self, STRATA_EXT_VULKAN);
    if (host->extension(host->self, "strata.nothing/1") || (n->gl && n->vulkan))
        return STRATA_ERROR_MODULE;
    if (n->gl && (n->gl->struct_size < sizeof *n->gl || !n->gl->get_proc("glCopyBufferSubData")))
        return STRATA_ERROR_MODULE;
    if (n->vulkan &&
        (n->vulkan->struct_size < sizeof *n->vulkan || !n->vulkan->instance(gpu->self) ||
         !n->vulkan->physical_device(gpu->self) || !n->vulkan->device(gpu->self) ||
         n->vulkan->buffer_handle(gpu->self, (strata_buffer){0})))
        return STRATA_ERROR_MODULE;
    return STRATA_OK;
}

static void run(native *n, void *frame_self, const strata_pass *pass) {
    if (n->gl)
        native_pass_gl(n, frame_self, pass);
    else
        native_pass_vulkan(n, frame_self, pass);
}

static strata_result make_buffers(native *n) {
    const strata_buffer_desc source = {
        .struct_size = sizeof source, .label = "source", .size = n->bytes};
    const strata_buffer_desc target = {
        .struct_size = sizeof target, .label = "target", .size = n->bytes};
    const strata_pool_desc pool = {.struct_size = sizeof pool,
                                   .label = "pool",
                                   .plane_count = 1,
                                   .counter_name = "PoolCounter",
                                   .plane_names = {"PoolValues"},
                                   .plane_strides = {4},
                                   .expected = 1024};
    strata_result r = n->gpu->buffer_create(n->gpu->self, &source, &n->source);
    if (r == STRATA_OK)
        r = n->gpu->buffer_create(n->gpu->self, &target, &n->target);
    return r == STRATA_OK ? n->gpu->pool_create(n->gpu->self, &pool, &n->pool) : r;
}

static strata_result make_programs(native *n) {
    const strata_program_desc produce = {.struct_size = sizeof produce,
                                         .kind = STRATA_PROGRAM_COMPUTE,
                                         .label = "produce",
                                         .source = &produce_comp_glsl};
    const strata_program_desc consume = {
        .struct_size = sizeof consume, .label = "consume", .source = &consume_frag_glsl};
    strata_result r = n->gpu->program_create(n->gpu->self, &produce, &n->produce);
    return r == STRATA_OK ? n->gpu->program_create(n->gpu->self, &consume, &n->consume) : r;
}

static strata_result prepare(void *state, const strata_view *view) {
    native *n = state;
    n->portable = view->settings->values[0] > 0 || (!n->gl && !n->vulkan);
    n->fault = (uint32_t)view->settings->values[1];
    n->mistake = n->fault == FAULT_CALL;
    n->width = view->width;
    n->bytes = (uint64_t)view->width * view->height * 4;
    n->color = view->image(view->self, "color/1");
    if (n->bytes % 8)
        return STRATA_ERROR_INVALID_ARGUMENT;
    strata_result r = make_buffers(n);
    if (r == STRATA_OK)
        r = make_programs(n);
    if (r == STRATA_OK && n->fault == FAULT_PREPARE && !n->portable) {
        run(n, view->self, &(strata_pass){.struct_size = sizeof(strata_pass), .label = "early"});
        return n->gpu->error(n->gpu->self)[0] ? STRATA_ERROR_INVALID_STATE : STRATA_ERROR_MODULE;
    }
    return r;
}

static void record_transfer(native *n, const strata_frame *frame) {
    const strata_bind binds[] = {
        {.struct_size = sizeof binds[0], .name = "source", .buffer = n->source},
        {.struct_size = sizeof binds[0], .name = "target", .buffer = n->target},
        {.struct_size = sizeof binds[0], .pool = n->pool}};
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = n->fault == FAULT_LABEL ? NULL : "transfer",
                              .binds = binds,
                              .bind_count = 3};
    if (!n->portable && n->fault == FAULT_CALLBACK && n->gl) {
        n->gl->pass(frame->self, &pass, NULL, n);
    } else if (!n->portable && n->fault == FAULT_CALLBACK) {
        n->vulkan->pass(frame->self, &pass, NULL, n);
    } else if (!n->portable) {
        run(n, frame->self, &pass);
    } else {
        frame->copy(frame->self, n->target, 0, n->source, 0, n->bytes / 2);
        frame->fill(frame->self, n->target, n->bytes / 2, n->bytes / 2, NATIVE_QUARTER);
    }
}

static void record(void *state, const strata_frame *frame) {
    native *n = state;
    const strata_bind source = {
        .struct_size = sizeof source, .name = "Source", .buffer = n->source};
    const strata_bind shown[] = {
        {.struct_size = sizeof shown[0], .name = "Target", .buffer = n->target},
        {.struct_size = sizeof shown[0], .pool = n->pool}};
    const strata_attachment color = {.struct_size = sizeof color, .image = n->color};
    strata_pass produce = {.struct_size = sizeof produce,
                           .label = "produce",
                           .program = n->produce,
                           .binds = &source,
                           .bind_count = 1};
    strata_groups(n->bytes / 4, produce.groups);
    frame->pass(frame->self, &produce);
    record_transfer(n, frame);
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "consume",
                                            .program = n->consume,
                                            .params = &n->width,
                                            .params_size = 4,
                                            .binds = shown,
                                            .bind_count = 2,
                                            .color = &color,
                                            .color_count = 1});
}

static void destroy(void *state) {
    (void)state;
}

static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use *const slots[] = {&color_use};
static const char *const paths[] = {"native", "portable", NULL};
static const strata_knob path = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "path",
                                 .title = "who transfers",
                                 .choices = paths};
static const char *const faults[] = {"none", "prepare", "label", "callback", "call", NULL};
static const strata_knob fault = {.struct_size = sizeof(strata_knob),
                                  .type = STRATA_KNOB_CHOICE,
                                  .name = "fault",
                                  .title = "what goes wrong",
                                  .choices = faults};
static const strata_knob *const knobs[] = {&path, &fault};
static const strata_promises promises = {.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_APPROXIMATE,
                                         .memory = "8 pixels"};
static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model), .frame = 1e9};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(native),
    .id = "native",
    .title = "A test pattern through native calls",
    .stage = "stream",
    .slots = slots,
    .slot_count = 1,
    .knob_count = 2,
    .knobs = knobs,
    .promises = &promises,
    .cost = &cost,
    .estimate = estimate,
    .create = create,
    .prepare = prepare,
    .record = record,
    .destroy = destroy,
};
static const strata_technique *const techniques[] = {&technique};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "native",
    .title = "Native extensions, for tests",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
