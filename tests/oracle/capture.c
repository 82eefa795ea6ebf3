/* SPDX-License-Identifier: MIT
 *
 * Renders through the public API and reads the frame back with its raw records, straight from the
 * planes of fragments/1. See oracle.h.
 */
#define _POSIX_C_SOURCE 200809L
#include "oracle/oracle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- instances and scenes -------------------------------------------------------------------- */

strata *oracle_open(void **state) {
    const char *build = getenv("STRATA_TEST_BUILD");
    char cache[4096] = "";
    if (build)
        snprintf(cache, sizeof cache, "%s/tests/cache", build);
    const strata_open_options options = {
        .struct_size = sizeof options, .backend = *state, .cache_dir = cache};
    strata *s = NULL;
    base_error err = {0};
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    if (render_device(s, &err) == STRATA_OK)
        return s;
    print_message("skipped: %s: %s\n", (const char *)*state, err.text);
    strata_close(s);
    return NULL;
}

static strata_scene *load_own(strata *s, const char *name) {
    char path[] = "/tmp/strata-oracle-XXXXXX";
    size_t size = 0;
    unsigned char *file = oracle_scene_build(name, &size);
    strata_scene *sc = NULL;
    assert_non_null(file);
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, file, size), size);
    close(fd);
    free(file);
    if (strata_scene_load(s, path, &sc) != STRATA_OK)
        fail_msg("own:%s: %s", name, strata_error(s));
    unlink(path);
    return sc;
}

strata_scene *oracle_scene(strata *s, const char *name) {
    strata_scene *sc = NULL;
    if (strncmp(name, "own:", 4) == 0)
        return load_own(s, name + 4);
    if (strata_scene_load(s, name, &sc) != STRATA_OK)
        fail_msg("%s: %s", name, strata_error(s));
    return sc;
}

void oracle_render(strata *s, strata_scene *sc, const oracle_case *c) {
    const char *const settings[2] = {c->setting[0], c->setting[1]};
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = c->width,
                                           .height = c->height,
                                           .use = "abuffer,ppc",
                                           .camera = c->camera,
                                           .settings = settings,
                                           .setting_count = c->setting[1]   ? 2
                                                            : c->setting[0] ? 1
                                                                            : 0,
                                           .outputs = c->outputs,
                                           .shuffle = c->shuffle,
                                           .background = {0.1f, 0.2f, 0.4f, 1.0f},
                                           .has_background = 1};
    if (strata_render(s, sc, &options) != STRATA_OK)
        fail_msg("%s on %s: %s", c->scene, s->backend, strata_error(s));
}

/* ---- reading back ---------------------------------------------------------------------------- */

static void *room(size_t count, size_t size) {
    void *memory = base_calloc(count ? count : 1, size);
    assert_non_null(memory);
    return memory;
}

/* Everything that fragments/1 holds, as it lies in device memory. */
typedef struct raw {
    uint32_t linked, count;
    uint32_t *ranges, *keys, *links;
    uint32_t *payload[PLAN_MAX_PLANES];
} raw;

static void read_plane(const render_session *session, uint32_t plane, uint64_t bytes, void *data) {
    gpu *g = session->owner->gpu;
    base_error err = {0};
    const strata_buffer buffer = gpu_pool_plane(g, session->fragments.records, plane);
    if (bytes && gpu_buffer_read(g, buffer, 0, bytes, data, &err) != STRATA_OK)
        fail_msg("plane %u: %s", plane, err.text);
}

static void raw_read(const render_session *session, raw *r) {
    gpu *g = session->owner->gpu;
    const plan_payload *payload = &session->plan->payload;
    const size_t pixels = (size_t)session->width * session->height;
    base_error err = {0};
    uint64_t needed = 0;
    assert_int_equal(session->band_count, 1);
    assert_int_equal(gpu_pool_needed(g, session->fragments.records, &needed, &err), STRATA_OK);
    assert_true(needed <= gpu_pool_capacity(g, session->fragments.records));
    r->linked = session->fragments.layout == STRATA_FRAGMENTS_LINKED;
    r->count = (uint32_t)needed;
    r->ranges = room(pixels, 8);
    r->keys = room(needed, 8);
    r->links = r->linked ? room(needed, 8) : NULL;
    assert_int_equal(gpu_buffer_read(g, session->fragments.ranges, 0, pixels * 8, r->ranges, &err),
                     STRATA_OK);
    read_plane(session, 0, needed * 8, r->keys);
    if (r->linked)
        read_plane(session, 1, needed * 8, r->links);
    for (uint32_t i = 0; i < payload->plane_count; i++) {
        r->payload[i] = room(needed, 8);
        read_plane(session, i + 1 + r->linked, needed * payload->plane_strides[i], r->payload[i]);
    }
}

static void raw_free(raw *r) {
    free(r->ranges);
    free(r->keys);
    free(r->links);
    for (uint32_t i = 0; i < PLAN_MAX_PLANES; i++)
        free(r->payload[i]);
}

static oracle_record make_record(const raw *r, const plan_payload *payload, size_t slot) {
    oracle_record record = {.key = r->keys[2 * slot], .order = r->keys[2 * slot + 1]};
    uint32_t word = 0;
    for (uint32_t i = 0; i < payload->plane_count; i++) {
        const uint32_t words = payload->plane_strides[i] / 4;
        memcpy(record.words + word, r->payload[i] + slot * words, words * sizeof(uint32_t));
        word += words;
    }
    return record;
}

/* Groups the records by pixel; every slot belongs to one pixel and every pixel to as many as it
 * says. */
static void collect(const raw *r, const plan_payload *payload, oracle_capture *c) {
    const size_t pixels = (size_t)c->width * c->height;
    unsigned char *used = room(r->count, 1);
    c->records = room(r->count, sizeof *c->records);
    c->first = room(pixels + 1, sizeof *c->first);
    for (size_t p = 0; p < pixels; p++) {
        const uint32_t count = r->ranges[2 * p + 1];
        uint32_t slot = r->ranges[2 * p];
        c->first[p + 1] = c->first[p];
        for (uint32_t i = 0; i < count; i++) {
            if (slot >= r->count || used[slot])
                fail_msg("pixel %zu: record %u of %u is slot %u of %u, %s", p, i, count, slot,
                         r->count, slot < r->count ? "which is another's too" : "beyond the end");
            if (r->linked && r->links[2 * (size_t)slot + 1] != p)
                fail_msg("pixel %zu: slot %u says that it is of pixel %u", p, slot,
                         r->links[2 * (size_t)slot + 1]);
            used[slot] = 1;
            c->records[c->first[p + 1]++] = make_record(r, payload, slot);
            slot = r->linked ? r->links[2 * (size_t)slot] : slot + 1;
        }
        if (r->linked && slot != UINT32_MAX)
            fail_msg("pixel %zu: its list goes on after the %u records that it counts", p, count);
    }
    free(used);
    c->record_count = c->first[pixels];
    if (c->record_count != r->count)
        fail_msg("the ranges hold %zu records, the pool %u", c->record_count, r->count);
}

static float *read_color(strata *s, uint32_t width, uint32_t height) {
    const size_t row = (size_t)width * 4;
    float *top_down = room(row * height, sizeof(float)), *out = room(row * height, sizeof(float));
    assert_int_equal(strata_read(s, STRATA_OUTPUT_COLOR, top_down, row * height * sizeof(float)),
                     STRATA_OK);
    for (uint32_t y = 0; y < height; y++)
        memcpy(out + y * row, top_down + (height - 1 - y) * row, row * sizeof(float));
    free(top_down);
    return out;
}

void oracle_capture_frame(strata *s, strata_scene *sc, const oracle_case *c, oracle_capture *out) {
    const size_t pixels = (size_t)c->width * c->height;
    oracle_case deep = *c;
    base_error err = {0};
    deep.outputs |= STRATA_OUTPUT_DEEP; /* keeps the opaque part */
    oracle_render(s, sc, &deep);
    const render_session *session = s->session;
    *out = (oracle_capture){.width = c->width,
                            .height = c->height,
                            .plan = session->plan,
                            .scene = session->scene,
                            .view = s->result.view,
                            .background = {0.1f, 0.2f, 0.4f, 1.0f}};
    out->color = read_color(s, c->width, c->height);
    out->behind = room(pixels * 4, sizeof(float));
    memcpy(out->behind, s->result.deep_build.opaque, pixels * 4 * sizeof(float));
    out->depth = room(pixels, sizeof(float));
    assert_int_equal(
        gpu_image_read(s->gpu, session->depth, 0, out->depth, pixels * sizeof(float), &err),
        STRATA_OK);
    if (!session->has_fragments) {
        out->first = room(pixels + 1, sizeof *out->first);
        return;
    }
    raw r = {0};
    raw_read(session, &r);
    collect(&r, &session->plan->payload, out);
    raw_free(&r);
}

void oracle_capture_free(oracle_capture *c) {
    free(c->color);
    free(c->behind);
    free(c->depth);
    free(c->first);
    free(c->records);
    *c = (oracle_capture){0};
}

/* ---- records --------------------------------------------------------------------------------- */

static int nearer(const void *a, const void *b) {
    const oracle_record *left = a, *right = b;
    if (left->key != right->key)
        return left->key < right->key ? -1 : 1;
    return left->order < right->order ? -1 : left->order > right->order;
}

void oracle_sort(oracle_record *records, size_t count) {
    if (count) /* none may have no memory at all */
        qsort(records, count, sizeof *records, nearer);
}

float oracle_depth(const oracle_record *record) {
    const uint32_t bits = 0x3f800000u - record->key;
    float depth;
    memcpy(&depth, &bits, sizeof depth);
    return depth;
}

uint32_t oracle_primitive(const oracle_record *record) {
    return UINT32_MAX - record->order;
}

int oracle_transparent(const scene_material *material) {
    return material->alpha == SCENE_BLEND || material->transmission > 0.0f;
}
