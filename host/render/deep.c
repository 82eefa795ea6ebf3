/* SPDX-License-Identifier: MIT
 *
 * Deep images: after a band was verified, its records become elements on the device, are sorted by
 * (key, order) here and appended; the opaque surface is each pixel's last sample. Stands between
 * fragments and image.
 */
#include "render/render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CHUNK 1048576u /* records turned into elements at a time */

typedef struct deep_record {
    uint32_t key, order, slot;
} deep_record;

/* A band's records, read back. */
typedef struct deep_band {
    uint32_t pixels, records;
    uint32_t *ranges, *keys, *links; /* pairs; links NULL when contiguous */
    float *elements;                 /* [records][8]: C, T */
    deep_record *sorted;             /* of one pixel */
} deep_band;

strata_result render_deep_begin(render_session *session, base_error *err) {
    render_deep *deep = &session->owner->result.deep_build;
    const size_t pixels = (size_t)session->width * session->height;
    render_deep_free(deep);
    deep->offset = base_calloc(pixels, sizeof *deep->offset);
    deep->count = base_calloc(pixels, sizeof *deep->count);
    deep->opaque = base_calloc(pixels * 4, sizeof *deep->opaque);
    if (!deep->offset || !deep->count || !deep->opaque)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "deep image: out of memory");
    return gpu_image_read(session->owner->gpu, session->color, 0, deep->opaque,
                          pixels * 4 * sizeof *deep->opaque, err);
}

void render_deep_free(render_deep *deep) {
    free(deep->offset);
    free(deep->count);
    free(deep->depth);
    free(deep->color);
    free(deep->color_alpha);
    free(deep->opaque);
    *deep = (render_deep){0};
}

/* ---- reading a band -------------------------------------------------------------------------- */

static strata_result make_program(render_session *session, base_error *err) {
    if (session->deep_program.id)
        return STRATA_OK;
    const strata_glsl *source = gpu_library_find("strata/elements.glsl");
    strata_result r =
        gpu_program_create(session->scope,
                           &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                  .kind = STRATA_PROGRAM_COMPUTE,
                                                  .label = "elements",
                                                  .source = source},
                           &session->deep_program, err);
    if (r == STRATA_OK)
        r = gpu_buffer_create(session->scope,
                              &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                    .label = "elements",
                                                    .size = (uint64_t)CHUNK * 32},
                              &session->deep_elements, err);
    return r;
}

static strata_result read_elements(render_session *session, deep_band *band, base_error *err) {
    gpu *g = session->owner->gpu;
    const strata_bind binds[] = {
        {.struct_size = sizeof(strata_bind),
         .name = "StrataElements",
         .buffer = session->deep_elements},
        {.struct_size = sizeof(strata_bind), .pool = session->fragments.records}};
    strata_result r = STRATA_OK;
    for (uint32_t first = 0; first < band->records && r == STRATA_OK; first += CHUNK) {
        const uint32_t left = band->records - first;
        const uint32_t params[2] = {first, left < CHUNK ? left : CHUNK};
        strata_pass pass = {.struct_size = sizeof pass,
                            .label = "elements",
                            .program = session->deep_program,
                            .params = params,
                            .params_size = sizeof params,
                            .binds = binds,
                            .bind_count = 2};
        strata_groups(params[1], pass.groups);
        gpu_pass(g, "host", &pass);
        r = gpu_submit(g, err);
        if (r == STRATA_OK)
            r = gpu_buffer_read(g, session->deep_elements, 0, (uint64_t)params[1] * 32,
                                band->elements + (size_t)first * 8, err);
    }
    return r;
}

static strata_result read_band(render_session *session, deep_band *band, base_error *err) {
    gpu *g = session->owner->gpu;
    const strata_pool pool = session->fragments.records;
    const int linked = session->fragments.layout == STRATA_FRAGMENTS_LINKED;
    uint64_t needed = 0;
    strata_result r = gpu_pool_needed(g, pool, &needed, err);
    if (r != STRATA_OK)
        return r;
    band->records = (uint32_t)needed;
    band->ranges = base_calloc(band->pixels, 8);
    band->keys = base_calloc(needed + 1, 8);
    band->links = linked ? base_calloc(needed + 1, 8) : NULL;
    band->elements = base_calloc(needed + 1, 32);
    band->sorted = base_calloc(needed + 1, sizeof *band->sorted);
    if (!band->ranges || !band->keys || !band->elements || !band->sorted ||
        (linked && !band->links))
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "deep image: out of memory");
    r = gpu_buffer_read(g, session->fragments.ranges, 0, (uint64_t)band->pixels * 8, band->ranges,
                        err);
    if (r == STRATA_OK && needed)
        r = gpu_buffer_read(g, gpu_pool_plane(g, pool, 0), 0, needed * 8, band->keys, err);
    if (r == STRATA_OK && needed && linked)
        r = gpu_buffer_read(g, gpu_pool_plane(g, pool, 1), 0, needed * 8, band->links, err);
    if (r == STRATA_OK)
        r = make_program(session, err);
    return r == STRATA_OK ? read_elements(session, band, err) : r;
}

/* ---- sorting and appending ------------------------------------------------------------------- */

static int by_key(const void *a, const void *b) {
    const deep_record *left = a, *right = b;
    if (left->key != right->key)
        return left->key < right->key ? -1 : 1;
    return left->order < right->order ? -1 : left->order > right->order;
}

/* Slots of a pixel, in order. Returns their number, at most all records; a list that is longer than
 * it says ends early. */
static uint32_t sort_pixel(deep_band *band, uint32_t pixel) {
    const uint32_t said = band->ranges[2 * pixel + 1],
                   count = said < band->records ? said : band->records;
    uint32_t slot = band->ranges[2 * pixel], found = 0;
    while (found < count && slot < band->records) {
        band->sorted[found++] = (deep_record){.key = band->keys[2 * (size_t)slot],
                                              .order = band->keys[2 * (size_t)slot + 1],
                                              .slot = slot};
        slot = band->links ? band->links[2 * (size_t)slot] : slot + 1;
    }
    qsort(band->sorted, found, sizeof *band->sorted, by_key);
    return found;
}

static strata_result reserve(render_deep *deep, size_t more, int colored, base_error *err) {
    if (deep->samples + more <= deep->capacity)
        return STRATA_OK;
    const size_t capacity = (deep->samples + more) * 3 / 2 + 1024;
    float *depth = base_realloc(deep->depth, capacity, sizeof *depth);
    deep->depth = depth ? depth : deep->depth;
    float *color = base_realloc(deep->color, capacity, 4 * sizeof *color);
    deep->color = color ? color : deep->color;
    float *alpha = colored ? base_realloc(deep->color_alpha, capacity, 3 * sizeof *alpha) : NULL;
    deep->color_alpha = alpha ? alpha : deep->color_alpha;
    if (!depth || !color || (colored && !alpha))
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "deep image: out of memory");
    deep->capacity = capacity;
    return STRATA_OK;
}

static void append(render_deep *deep, float depth, const float color[4],
                   const float transmittance[3]) {
    const size_t at = deep->samples++;
    deep->depth[at] = depth;
    memcpy(deep->color + 4 * at, color, 4 * sizeof *color);
    for (size_t c = 0; c < 3 && deep->color_alpha; ++c)
        deep->color_alpha[3 * at + c] = 1.0f - transmittance[c];
}

/* Fragments of one pixel and the opaque surface behind them. */
static strata_result append_pixel(render_session *session, deep_band *band, uint32_t found,
                                  size_t at, float opaque_depth, base_error *err) {
    strata *s = session->owner;
    render_deep *deep = &s->result.deep_build;
    const float none[3] = {0, 0, 0};
    strata_result r =
        reserve(deep, (size_t)found + 1, session->plan->transmittance_channels == 3, err);
    if (r != STRATA_OK)
        return r;
    deep->offset[at] = deep->samples;
    for (uint32_t i = 0; i < found; ++i) {
        const uint32_t bits = 0x3f800000u - band->sorted[i].key;
        const float *element = band->elements + 8 * (size_t)band->sorted[i].slot;
        float z;
        memcpy(&z, &bits, sizeof z);
        append(deep, (float)scene_view_distance(&s->result.view, (double)z), element, element + 4);
    }
    if (opaque_depth > 0)
        append(deep, (float)scene_view_distance(&s->result.view, (double)opaque_depth),
               deep->opaque + 4 * at, none);
    deep->count[at] = (uint32_t)(deep->samples - deep->offset[at]);
    return STRATA_OK;
}

static strata_result append_band(render_session *session, const render_rect *rect, deep_band *band,
                                 const float *depth, base_error *err) {
    strata_result r = STRATA_OK;
    for (uint32_t y = 0; y < rect->height && r == STRATA_OK; ++y)
        for (uint32_t x = 0; x < rect->width && r == STRATA_OK; ++x) {
            const size_t at = (size_t)(rect->y + y) * session->width + rect->x + x;
            const uint32_t found = band->ranges ? sort_pixel(band, y * rect->width + x) : 0;
            r = append_pixel(session, band, found, at, depth[at], err);
        }
    return r;
}

strata_result render_deep_band(render_session *session, const render_rect *rect, base_error *err) {
    const size_t pixels = (size_t)session->width * session->height;
    deep_band band = {.pixels = rect->width * rect->height};
    float *depth = base_calloc(pixels, sizeof *depth);
    strata_result r = STRATA_OK;
    if (!depth)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "deep image: out of memory");
    if (session->has_fragments)
        r = read_band(session, &band, err);
    if (r == STRATA_OK)
        r = gpu_image_read(session->owner->gpu, session->depth, 0, depth, pixels * sizeof *depth,
                           err);
    if (r == STRATA_OK)
        r = append_band(session, rect, &band, depth, err);
    free(band.ranges);
    free(band.keys);
    free(band.links);
    free(band.elements);
    free(band.sorted);
    free(depth);
    return r;
}

image_deep render_deep_image(const render_session *session) {
    const render_deep *deep = &session->owner->result.deep_build;
    return (image_deep){.width = session->width,
                        .height = session->height,
                        .offset = deep->offset,
                        .count = deep->count,
                        .sample_count = deep->samples,
                        .depth = deep->depth,
                        .color = deep->color,
                        .color_alpha = deep->color_alpha};
}
