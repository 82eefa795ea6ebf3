/* SPDX-License-Identifier: MIT
 *
 * Technique `stencil` at its edges: batches of 8 layers, the 253rd to 256th layer, and fragments
 * that must not take a layer: hidden ones, masked ones, backs of one-sided faces, corners of
 * splats. Pictures are compared with abuffer's, bit for bit.
 */
#define _GNU_SOURCE

#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "render/render.h"
#include "scenes/glb.h"

enum { SIZE = 16 };

static const char *const backends[] = {"vulkan", "gl"};

/* Both captures on one scene. */
static void check_same(strata *instance, strata_scene *sc, const char *backend, uint32_t bands,
                       uint32_t width, uint32_t height, const char *what) {
    char text[256];
    snprintf(text, sizeof text, "%s on %s in %u bands", what, backend, bands);
    const way plain = {.backend = backend, .use = "abuffer,ppc"};
    const way routed = {.backend = backend, .use = "stencil,ppc", .bands = bands};
    picture a = picture_render(sc, instance, &plain, width, height);
    const uint64_t fragments = instance->result.report.total;
    picture b = picture_render(sc, instance, &routed, width, height);
    picture_same(&a, &b, text);
    assert_int_equal(instance->result.report.total, fragments);
    assert_int_equal(instance->result.report.kept, fragments);
    picture_free(&a);
    picture_free(&b);
}

static void layers_fill_batches(void **state) {
    static const uint32_t counts[] = {1, 7, 8, 9, 15, 16, 17, 253, 254};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        for (size_t i = 0; instance && i < sizeof counts / sizeof *counts; ++i) {
            char path[96];
            snprintf(path, sizeof path, "scene:layers?count=%u&width=8&height=8&order=far",
                     counts[i]);
            strata_scene *sc = picture_scene(instance, path);
            check_same(instance, sc, backends[b], 1, 8, 8, path);
            assert_int_equal(instance->result.report.largest, counts[i]);
            strata_scene_close(sc);
        }
    }
}

static void equal_depths_keep_their_layers(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, "scene:stack?count=254&shift=0&split=1");
        check_same(instance, sc, backends[b], 1, 13, 11, "254 squares at one depth");
        strata_scene_close(sc);
    }
}

/* ---- beyond the stencil ---------------------------------------------------------------------- */

static void one_layer_more_is_refused(void **state) {
    static const uint32_t counts[] = {255, 256, 300};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        for (size_t i = 0; instance && i < sizeof counts / sizeof *counts; ++i) {
            const strata_render_options options = {
                .struct_size = sizeof options, .width = 8, .height = 8, .use = "stencil"};
            char path[96], line[160];
            snprintf(path, sizeof path,
                     "scene:layers?count=%u&width=8&height=8&where=pixel&order=near", counts[i]);
            snprintf(line, sizeof line,
                     "stencil: a pixel holds %u fragments and a stencil of 8 bits routes 254; "
                     "abuffer has no such limit",
                     counts[i]);
            strata_scene *sc = picture_scene(instance, path);
            assert_true(strata_render(instance, sc, &options) < 0);
            assert_string_equal(strata_error(instance), line);
            strata_scene_close(sc);

            sc = picture_scene(instance, "scene:layers?count=20&width=8&height=8");
            check_same(instance, sc, backends[b], 1, 8, 8, "after a refusal");
            strata_scene_close(sc);
        }
    }
}

/* ---- fragments that take no layer ------------------------------------------------------------ */

/* Full-screen squares, and discs round two places such that the pixel between them lies in the
 * square of each and in the disc of none. */
typedef struct pile {
    uint32_t front, level, behind; /* of glass, against a wall */
    uint32_t masked, turned;       /* that do not exist: by alpha, by their side */
    uint32_t discs, more;          /* at the one place and at the other */
    uint32_t wall;
} pile;

enum { GLASS = 0, COLORS = 3, WALL = COLORS, MASKED, TURNED, DISCS };

static void add_squares(base_text *nodes, uint32_t count, uint32_t mesh, double first,
                        double step) {
    for (uint32_t i = 0; i < count; ++i)
        base_text_add(nodes, "{\"mesh\":%u,\"translation\":[0,0,%.9g]%s},",
                      mesh == GLASS ? i % COLORS : mesh, first + i * step,
                      mesh == TURNED ? ",\"rotation\":[0,1,0,0]" : "");
}

static void add_materials(test_glb *g) {
    static const char *const colors[COLORS] = {"1,0.4,0.2,0.02", "0.2,1,0.4,0.03",
                                               "0.3,0.5,1,0.015"};
    base_text t = {0};
    for (int i = 0; i < COLORS; ++i)
        base_text_add(&t,
                      "{\"alphaMode\":\"BLEND\",\"doubleSided\":true,\"extensions\":"
                      "{\"KHR_materials_unlit\":{}},\"pbrMetallicRoughness\":"
                      "{\"baseColorFactor\":[%s]}},",
                      colors[i]);
    test_glb_json(g,
                  "\"materials\":[%s{\"extensions\":{\"KHR_materials_unlit\":{}}},"
                  "{\"alphaMode\":\"MASK\",\"doubleSided\":true,\"extensions\":"
                  "{\"KHR_materials_transmission\":{\"transmissionFactor\":1}},"
                  "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.4]}},"
                  "{\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":"
                  "{\"baseColorFactor\":[1,0,0,0.5]}}]",
                  t.data);
    base_text_free(&t);
}

/* Meshes and materials are numbered alike; the discs are of the first glass. */
static void add_meshes(test_glb *g, const pile *p) {
    static const float square[12] = {-2, -2, 0, 2, -2, 0, -2, 2, 0, 2, 2, 0};
    const double pixel = 2.0 / SIZE, between = -1 + 6.5 * pixel;
    const uint32_t discs = p->discs + p->more, count = discs ? discs : 1;
    float *places = calloc(count, 3 * sizeof *places);
    base_text t = {0};
    for (uint32_t i = 0; i < count; ++i) {
        places[3 * i] = places[3 * i + 1] = (float)(between + (i < p->discs ? 1.4 : -1.4) * pixel);
        places[3 * i + 2] = (float)(0.5 + 0.001 * i);
    }
    const uint32_t corners = test_glb_floats(g, "VEC3", 3, 4, square);
    const uint32_t points = test_glb_floats(g, "VEC3", 3, count, places);
    for (uint32_t i = 0; i < DISCS; ++i)
        base_text_add(&t,
                      "{\"primitives\":[{\"mode\":5,\"material\":%u,\"attributes\":{\"POSITION\":"
                      "%u}}]},",
                      i, corners);
    test_glb_json(g,
                  "\"meshes\":[%s{\"primitives\":[{\"mode\":0,\"material\":0,\"attributes\":"
                  "{\"POSITION\":%u}}]}]",
                  t.data, points);
    base_text_free(&t);
    free(places);
}

/* What takes no layer is drawn first. */
static void write_pile(const pile *p, char path[64]) {
    test_glb g = {0};
    base_text nodes = {0};
    size_t size;
    add_squares(&nodes, p->behind, GLASS, -0.01, -0.01);
    add_squares(&nodes, p->masked, MASKED, 1.5, 0.001);
    add_squares(&nodes, p->turned, TURNED, 1.2, 0.001);
    add_squares(&nodes, p->discs ? 1 : 0, DISCS, 0, 0);
    add_squares(&nodes, p->level, GLASS, 0, 0);
    add_squares(&nodes, p->wall, WALL, 0, 0);
    add_squares(&nodes, p->front, GLASS, 0.01, 0.003);
    base_text_add(&g.rest, /* longer than test_glb_json takes */
                  ",\"nodes\":[%s{\"camera\":0,\"translation\":[0,0,5]}],\"cameras\":"
                  "[{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":1,"
                  "\"znear\":0.1,\"zfar\":20}}],\"extensionsUsed\":[\"KHR_materials_unlit\","
                  "\"KHR_materials_transmission\"]",
                  nodes.data);
    add_materials(&g);
    add_meshes(&g, p);
    unsigned char *file = test_glb_finish(&g, &size);
    strcpy(path, "/tmp/strata-stencil-XXXXXX.glb");
    const int fd = mkstemps(path, 4);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, file, size), size);
    close(fd);
    free(file);
    base_text_free(&nodes);
}

static void only_what_is_seen_takes_a_layer(void **state) {
    static const struct {
        pile pile;
        uint32_t largest;
        const char *what;
    } rows[] = {
        {{.front = 20, .behind = 300, .wall = 1}, 20, "300 squares behind a wall"},
        {{.front = 250, .level = 4, .behind = 9, .wall = 1}, 254, "4 squares level with a wall"},
        {{.front = 9, .wall = 1}, 9, "a wall behind all"},
        {{.behind = 30, .wall = 1}, 0, "nothing before the wall"},
        {{.front = 100, .masked = 200}, 100, "200 masked squares"},
        {{.front = 100, .turned = 200}, 100, "200 one-sided squares seen from behind"},
        {{.front = 100, .discs = 150, .more = 150}, 250, "splats of more corners than layers"},
        {{.front = 100, .discs = 50}, 150, "splats, whose corners find layers enough"},
        {{.front = 12, .behind = 5, .masked = 6, .turned = 7, .discs = 8, .more = 9, .wall = 1},
         21,
         "all"},
    };
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        for (size_t i = 0; instance && i < sizeof rows / sizeof *rows; ++i) {
            char path[64];
            write_pile(&rows[i].pile, path);
            strata_scene *sc = picture_scene(instance, path);
            unlink(path);
            check_same(instance, sc, backends[b], 1, SIZE, SIZE, rows[i].what);
            assert_int_equal(instance->result.report.largest, rows[i].largest);
            check_same(instance, sc, backends[b], 3, SIZE, SIZE, rows[i].what);
            strata_scene_close(sc);
        }
    }
}

/* ---- how many layers a frame has is learned ---------------------------------------------------
 */

static void show(strata_scene *sc, uint32_t from, uint32_t to, uint32_t visible) {
    for (uint32_t i = from; i < to; ++i)
        assert_int_equal(strata_scene_set_visible(sc, i, visible), STRATA_OK);
}

/* How often the frame was recorded again. */
static uint32_t retries(strata *instance, strata_scene *sc, const char *backend) {
    const way routed = {.backend = backend, .use = "stencil,ppc"};
    picture p = picture_render(sc, instance, &routed, SIZE, SIZE);
    picture_free(&p);
    return (uint32_t)instance->result.retries;
}

static void layers_grow_and_shrink(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        char path[64];
        write_pile(&(pile){.front = 40}, path);
        strata_scene *sc = picture_scene(instance, path);
        unlink(path);
        show(sc, 5, 40, 0);
        retries(instance, sc, backends[b]);
        assert_int_equal(retries(instance, sc, backends[b]), 0);
        show(sc, 5, 40, 1);
        assert_true(retries(instance, sc, backends[b]) > 0);
        assert_int_equal(retries(instance, sc, backends[b]), 0);
        show(sc, 5, 40, 0);
        for (int i = 0; i < 70; ++i) /* fewer layers are needed for two windows of 32 frames */
            assert_int_equal(retries(instance, sc, backends[b]), 0);
        show(sc, 5, 40, 1);
        assert_true(retries(instance, sc, backends[b]) > 0);
        check_same(instance, sc, backends[b], 1, SIZE, SIZE, "grown, shrunk and grown");
        strata_scene_close(sc);
    }
}

/* Opaque geometry comes while the scene is shown, with or without what it hides. */
static void a_wall_appears(void **state) {
    static const uint32_t hidden_at_first[][2] = {{6, 7}, {0, 7}}; /* 6 behind, then the wall */
    (void)state;
    for (size_t i = 0; i < 4; ++i) {
        const char *backend = backends[i / 2];
        const uint32_t *hidden = hidden_at_first[i % 2];
        strata *instance = picture_instance(backend);
        if (!instance)
            continue;
        char path[64];
        write_pile(&(pile){.front = 6, .behind = 6, .wall = 1}, path);
        strata_scene *sc = picture_scene(instance, path);
        unlink(path);
        show(sc, hidden[0], hidden[1], 0);
        retries(instance, sc, backend);
        show(sc, hidden[0], hidden[1], 1);
        const way routed = {.backend = backend, .use = "stencil,ppc"};
        const way plain = {.backend = backend, .use = "abuffer,ppc"};
        picture a = picture_render(sc, instance, &routed, SIZE, SIZE);
        picture b = picture_render(sc, instance, &plain, SIZE, SIZE);
        picture_same(&a, &b, backend);
        picture_free(&a);
        picture_free(&b);
        strata_scene_close(sc);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(layers_fill_batches),
        cmocka_unit_test(equal_depths_keep_their_layers),
        cmocka_unit_test(one_layer_more_is_refused),
        cmocka_unit_test(only_what_is_seen_takes_a_layer),
        cmocka_unit_test(layers_grow_and_shrink),
        cmocka_unit_test(a_wall_appears),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    picture_close();
    return failed;
}
