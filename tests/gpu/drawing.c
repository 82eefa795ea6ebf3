/* SPDX-License-Identifier: MIT
 *
 * The drawing of drawing.h: programs from the sources of plugins/surface, passes as its record()
 * makes them.
 */
#include "gpu/drawing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "image/image.h"

typedef struct frame_block { /* StrataFrame */
    float world_to_clip[16], world_to_eye[16], clip_to_world[16], eye[4], background[4];
    uint32_t size[4], band[4];
    uint32_t counts[4];
} frame_block;

/* Sources live as long as the process: programs keep them. */
static const strata_glsl *source(const char *name, base_error *err) {
    static struct {
        const char *name;
        strata_glsl glsl;
    } known[8];
    for (size_t i = 0; i < BASE_COUNT(known); i++) {
        if (known[i].name && strcmp(known[i].name, name) == 0)
            return &known[i].glsl;
        if (known[i].name)
            continue;
        const char *root = getenv("STRATA_TEST_SOURCE");
        char path[1024];
        unsigned char *text;
        size_t size;
        snprintf(path, sizeof path, "%s/plugins/surface/%s", root ? root : ".", name);
        if (base_file_read(path, 1u << 20, &text, &size, err) != STRATA_OK)
            return NULL;
        known[i].name = name;
        known[i].glsl = (strata_glsl){(const char *)text, name};
        return &known[i].glsl;
    }
    return NULL;
}

static int make_programs(drawing *d, base_error *err) {
    static const char *const names[3] = {"nearest.frag.glsl", "winner.frag.glsl",
                                         "surface.frag.glsl"};
    static const char *const defines[] = {"SURFACE_EXACT"};
    for (int i = d->exact ? 0 : 2; i < 3; i++) {
        strata_program_desc desc = {.struct_size = sizeof desc,
                                    .kind = STRATA_PROGRAM_SCENE,
                                    .label = names[i],
                                    .source = source(names[i], err),
                                    .defines = defines,
                                    .define_count = d->exact};
        if (!desc.source || gpu_program_create(d->scope, &desc, &d->programs[i], err) != STRATA_OK)
            return 0;
    }
    return 1;
}

static int make_image(drawing *d, const char *label, uint32_t format, strata_image *out,
                      base_error *err) {
    strata_image_desc desc = {.struct_size = sizeof desc,
                              .format = format,
                              .label = label,
                              .width = d->width,
                              .height = d->height};
    return gpu_image_create(d->scope, &desc, out, err) == STRATA_OK;
}

static int fill_frame(drawing *d, const scene *s, const drawing_options *o, base_error *err) {
    scene_view view;
    if (scene_view_make(s, o->camera, 0.0, d->width, d->height, &view, err) != STRATA_OK)
        return 0;
    upload_counts counts = upload_count(d->u);
    frame_block block = {
        .size = {d->width, d->height, o->samples ? o->samples : 1, 0},
        .band = {0, 0, d->width, d->height},
        .counts = {counts.lights, counts.materials, counts.records, counts.textures}};
    memcpy(block.world_to_clip, view.world_to_clip, sizeof view.world_to_clip);
    memcpy(block.world_to_eye, view.world_to_eye, sizeof view.world_to_eye);
    memcpy(block.clip_to_world, view.clip_to_world, sizeof view.clip_to_world);
    memcpy(block.eye, view.eye, sizeof view.eye);
    return upload_set_key_light(d->u, &view, err) == STRATA_OK &&
           gpu_buffer_write(d->g, d->frame, 0, sizeof block, &block, err) == STRATA_OK;
}

static void record(drawing *d, strata_draws draws, uint32_t round) {
    uint32_t load = round ? STRATA_LOAD_KEEP : STRATA_LOAD_CLEAR;
    strata_attachment color = {.struct_size = sizeof color,
                               .image = d->color,
                               .load = load,
                               .clear = {0.2f, 0.2f, 0.2f, 1.0f}};
    strata_attachment winners = {.struct_size = sizeof winners, .image = d->winners, .load = load};
    strata_attachment clear = {.struct_size = sizeof clear, .image = d->depth, .load = load};
    strata_attachment keep = {.struct_size = sizeof keep, .image = d->depth};
    strata_bind bind = {.struct_size = sizeof bind, .name = "winners", .image = d->winners};
    strata_pass passes[3] = {{.label = "nearest",
                              .color = &winners,
                              .color_count = 1,
                              .depth = &clear,
                              .depth_test = STRATA_TEST_GREATER,
                              .depth_write = 1},
                             {.label = "winner",
                              .binds = &bind,
                              .bind_count = 1,
                              .depth = &keep,
                              .depth_test = STRATA_TEST_EQUAL},
                             {.label = "surface",
                              .binds = &bind,
                              .bind_count = d->exact,
                              .color = &color,
                              .color_count = 1,
                              .depth = d->exact ? &keep : &clear,
                              .depth_test = d->exact ? STRATA_TEST_EQUAL : STRATA_TEST_GREATER,
                              .depth_write = !d->exact}};
    gpu_begin(d->g, d->width, d->height);
    for (int i = d->exact ? 0 : 2; i < 3; i++) {
        passes[i].struct_size = sizeof passes[i];
        passes[i].program = d->programs[i];
        passes[i].draws = draws;
        gpu_pass(d->g, "surface", &passes[i]);
    }
}

int drawing_draw(drawing *d, const scene *s, const drawing_options *o, base_error *err) {
    size_t count = (size_t)d->width * d->height;
    if (!fill_frame(d, s, o, err))
        return 0;
    record(d, upload_draws(d->u, o->slot ? o->slot : "draws.opaque/1"), o->round);
    return gpu_submit(d->g, err) == STRATA_OK &&
           gpu_image_read(d->g, d->color, 0, d->pixels, count * 16, err) == STRATA_OK &&
           gpu_image_read(d->g, d->depth, 0, d->depths, count * 4, err) == STRATA_OK;
}

static int make_upload(drawing *d, const scene *s, uint32_t seed, base_error *err) {
    unsigned char *transparent = base_calloc(s->material_count ? s->material_count : 1, 1);
    if (!transparent)
        return 0;
    for (uint32_t i = 0; i < s->material_count; i++)
        transparent[i] = s->materials[i].alpha == SCENE_BLEND || s->materials[i].transmission > 0;
    const upload_options options = {.transparent = transparent, .shuffle_seed = seed};
    strata_result result = upload_create(d->g, s, &options, &d->u, err);
    free(transparent);
    return result == STRATA_OK;
}

int drawing_make(drawing *d, gpu *g, const scene *s, const drawing_options *o, base_error *err) {
    *d = (drawing){.g = g, .width = o->width, .height = o->height, .exact = o->exact};
    size_t count = (size_t)d->width * d->height;
    d->pixels = base_calloc(count, 16);
    d->depths = base_calloc(count, 4);
    d->scope = gpu_scope_create(g, "surface");
    strata_buffer_desc desc = {
        .struct_size = sizeof desc, .label = "frame", .size = sizeof(frame_block)};
    strata_bind bind = {.struct_size = sizeof bind, .name = "StrataFrame"};
    int fine = d->pixels && d->depths && d->scope && make_upload(d, s, o->seed, err) &&
               gpu_buffer_create(d->scope, &desc, &d->frame, err) == STRATA_OK;
    bind.buffer = d->frame;
    fine = fine && gpu_set_global(g, "StrataFrame", &bind, err) == STRATA_OK &&
           make_image(d, "color", STRATA_FORMAT_RGBA32F, &d->color, err) &&
           make_image(d, "depth", STRATA_FORMAT_D32F, &d->depth, err) &&
           make_image(d, "winners", STRATA_FORMAT_R32U, &d->winners, err) &&
           make_programs(d, err) && drawing_draw(d, s, o, err);
    if (!fine)
        drawing_free(d);
    return fine;
}

void drawing_free(drawing *d) {
    if (!d->g)
        return;
    gpu_set_global(d->g, "StrataFrame", NULL, NULL);
    upload_free(d->u);
    if (d->scope)
        gpu_scope_end(d->scope);
    free(d->pixels);
    free(d->depths);
    *d = (drawing){0};
}

int drawing_save(const drawing *d, const char *path) {
    image im = {.width = d->width, .height = d->height, .pixels = d->pixels};
    base_error err = {0};
    return image_write_png(&im, path, &err) == STRATA_OK;
}
