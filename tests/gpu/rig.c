/* SPDX-License-Identifier: MIT
 *
 * Devices, objects and remembered results for the GPU tests; see rig.h.
 */
#include "gpu/rig.h"

#include <stdio.h>
#include <stdlib.h>

#define OWNER "test"

/* ---- device ------------------------------------------------------------------------------ */

rig *rig_open(const char *backend) {
    const gpu_open_info info = {.backend = backend, .check = 1};
    base_error err = {0};
    rig *r = calloc(1, sizeof *r);
    if (!r)
        return NULL;
    r->backend = backend;
    if (gpu_open(&info, &r->g, &err) != STRATA_OK) {
        printf("skipped: %s\n", err.text);
        free(r);
        return NULL;
    }
    r->scope = gpu_scope_create(r->g, OWNER);
    return r;
}

void rig_close(rig *r) {
    gpu_close(r->g);
    free(r);
}

void rig_clear(rig *r) {
    gpu_scope_end(r->scope);
    r->scope = gpu_scope_create(r->g, OWNER);
    assert_non_null(r->scope);
}

static void succeed(const rig *r, strata_result result, const base_error *err) {
    if (result != STRATA_OK)
        fail_msg("%s: %s (%d)", r->backend, err->text, result);
}

/* ---- objects ----------------------------------------------------------------------------- */

strata_buffer rig_buffer(rig *r, const char *label, uint64_t size, const void *data) {
    const strata_buffer_desc desc = {
        .struct_size = sizeof desc, .label = label, .size = size, .data = data};
    base_error err = {0};
    strata_buffer out = {0};
    succeed(r, gpu_buffer_create(r->scope, &desc, &out, &err), &err);
    return out;
}

static strata_image make_image(rig *r, strata_image_desc desc) {
    base_error err = {0};
    strata_image out = {0};
    desc.struct_size = sizeof desc;
    succeed(r, gpu_image_create(r->scope, &desc, &out, &err), &err);
    return out;
}

strata_image rig_image(rig *r, const char *label, uint32_t format, uint32_t width, uint32_t height,
                       uint32_t layers) {
    return make_image(
        r,
        (strata_image_desc){
            .format = format, .label = label, .width = width, .height = height, .layers = layers});
}

strata_image rig_multisampled(rig *r, const char *label, uint32_t format, uint32_t width,
                              uint32_t height, uint32_t samples) {
    return make_image(r, (strata_image_desc){.format = format,
                                             .label = label,
                                             .width = width,
                                             .height = height,
                                             .samples = samples});
}

strata_program rig_program(rig *r, uint32_t kind, const char *text) {
    const strata_glsl source = {.text = text, .path = "test.glsl"};
    const strata_program_desc desc = {
        .struct_size = sizeof desc, .kind = kind, .label = "program", .source = &source};
    base_error err = {0};
    strata_program out = {0};
    succeed(r, gpu_program_create(r->scope, &desc, &out, &err), &err);
    return out;
}

strata_draws rig_draws(rig *r, strata_buffer commands, strata_buffer count, strata_buffer indices,
                       uint32_t capacity) {
    const gpu_draws_desc desc = {
        .commands = commands, .count = count, .indices = indices, .capacity = capacity};
    base_error err = {0};
    strata_draws out = {0};
    succeed(r, gpu_draws_create(r->scope, &desc, &out, &err), &err);
    return out;
}

strata_bind rig_bind_buffer(const char *name, strata_buffer buffer) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .name = name, .buffer = buffer};
}

strata_bind rig_bind_image(const char *name, strata_image image) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .name = name, .image = image};
}

strata_bind rig_bind_pool(strata_pool pool) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .pool = pool};
}

/* ---- recording and reading --------------------------------------------------------------- */

void rig_pass(rig *r, strata_pass pass) {
    pass.struct_size = sizeof pass;
    if (!pass.label)
        pass.label = "pass";
    gpu_pass(r->g, OWNER, &pass);
}

void rig_submit(rig *r) {
    base_error err = {0};
    succeed(r, gpu_submit(r->g, &err), &err);
}

void rig_read(rig *r, strata_buffer buffer, void *data, uint64_t size) {
    base_error err = {0};
    succeed(r, gpu_buffer_read(r->g, buffer, 0, size, data, &err), &err);
}

void rig_texels(rig *r, strata_image image, uint32_t layer, void *texels, size_t size) {
    base_error err = {0};
    succeed(r, gpu_image_read(r->g, image, layer, texels, size, &err), &err);
}

/* ---- remembered results ------------------------------------------------------------------ */

static struct {
    const char *name, *backend;
    void *data;
    size_t size;
} remembered[64];
static size_t remembered_count;

void rig_same(rig *r, const char *name, const void *data, size_t size) {
    for (size_t i = 0; i < remembered_count; i++)
        if (!strcmp(remembered[i].name, name)) {
            const unsigned char *a = remembered[i].data, *b = data;
            assert_int_equal(remembered[i].size, size);
            for (size_t k = 0; k < size; k++)
                if (a[k] != b[k])
                    fail_msg("%s: byte %zu is %02x on %s, %02x on %s", name, k, a[k],
                             remembered[i].backend, b[k], r->backend);
            return;
        }
    assert_true(remembered_count < BASE_COUNT(remembered));
    remembered[remembered_count].name = name;
    remembered[remembered_count].backend = r->backend;
    remembered[remembered_count].size = size;
    remembered[remembered_count].data = malloc(size);
    assert_non_null(remembered[remembered_count].data);
    memcpy(remembered[remembered_count++].data, data, size);
}

/* ---- a small scene ----------------------------------------------------------------------- */

typedef struct record { /* StrataRecord of shaders/strata/scene.glsl */
    float world[3][4];
    uint32_t material, primitive_base, primitive_map, flags;
    uint32_t streams[7];
    float scale;
} record;

typedef struct frame_block { /* StrataFrame of shaders/strata/frame.glsl */
    float world_to_clip[16], world_to_eye[16], clip_to_world[16];
    float eye[4], background[4];
    uint32_t frame_size[4], band[4];
    uint32_t counts[4];
} frame_block;

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static void global(rig *r, const char *name, strata_buffer buffer) {
    const strata_bind bind = rig_bind_buffer(name, buffer);
    base_error err = {0};
    succeed(r, gpu_set_global(r->g, name, &bind, &err), &err);
}

void rig_scene(rig *r, uint32_t width, uint32_t height, strata_buffer positions,
               const rig_placement *placements, uint32_t instances) {
    const uint32_t material[64] = {0}; /* at least one StrataMaterial */
    record *records = calloc(instances, sizeof *records);
    assert_non_null(records);
    for (uint32_t i = 0; i < instances; i++) {
        const rig_placement *p = &placements[i];
        records[i] = (record){
            .world = {{p->scale, 0, 0, p->x}, {0, p->scale, 0, p->y}, {0, 0, p->scale, p->z}},
            .primitive_base = p->primitive_base,
            .primitive_map = UINT32_MAX,
            .scale = p->scale};
    }
    frame_block frame = {.eye = {0, 0, 1, 0},
                         .frame_size = {width, height, 1, 0},
                         .band = {0, 0, width, height},
                         .counts = {0, 1, instances, 0}};
    memcpy(frame.world_to_clip, identity, sizeof identity);
    memcpy(frame.world_to_eye, identity, sizeof identity);
    memcpy(frame.clip_to_world, identity, sizeof identity);
    global(r, "StrataRecords", rig_buffer(r, "records", instances * sizeof *records, records));
    global(r, "StrataPositions", positions);
    global(r, "StrataMaterials", rig_buffer(r, "materials", sizeof material, material));
    global(r, "StrataFrame", rig_buffer(r, "frame", sizeof frame, &frame));
    free(records);
}
