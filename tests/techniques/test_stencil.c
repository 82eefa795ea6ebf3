/* SPDX-License-Identifier: MIT
 *
 * Technique `stencil` at its edges: batches of layers, the 253rd to 256th layer, and fragments that
 * must not take a layer: hidden ones, masked ones, backs of one-sided faces, corners of splats.
 * Pictures are compared with abuffer's, bit for bit.
 *
 * Both ways of routing are run. Through samples also where the self-test does not hold: on Vulkan,
 * samples miss fragments at edges alone, so what covers pixels whole is routed right all the same.
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
static const char fact[] = "selftest.sample_routing";

enum { WHOLE, EDGES }; /* what triangles do to pixels */

/* Where and how is routed. */
typedef struct variant {
    const char *device;  /* as it is */
    const char *backend; /* and what the test makes of it */
    const char *routing;
    int whole; /* 1: pixels that are covered whole are routed right in any case */
} variant;

static const variant variants[] = {
    {"vulkan", "vulkan", "stencil.routing=layers", 1},
    {"gl", "gl", "stencil.routing=layers", 1},
    {"vulkan", "vulkan claims:selftest.sample_routing", "stencil.routing=samples", 1},
    {"gl", "gl claims:selftest.sample_routing", "stencil.routing=samples", 0},
};
enum { VARIANTS = sizeof variants / sizeof *variants };

static int is_layered(const variant *v) {
    return strcmp(v->routing, "stencil.routing=layers") == 0;
}

/* NULL where there is no such device, or where it would not route the scene right. */
static strata *variant_instance(const variant *v, int edges) {
    strata *device = picture_instance(v->device);
    if (!device || !(is_layered(v) || (v->whole && edges == WHOLE) || picture_fact(device, fact)))
        return NULL;
    return picture_instance(v->backend);
}

static way routed_by(const variant *v) {
    return (way){.backend = v->backend, .use = "stencil,ppc", .settings = {v->routing}};
}

/* Both captures on one scene. */
static void check_same(strata *instance, strata_scene *sc, const variant *v, uint32_t bands,
                       uint32_t width, uint32_t height, const char *what) {
    char text[256];
    snprintf(text, sizeof text, "%s on %s in %u bands", what, v->backend, bands);
    const way plain = {.backend = v->backend, .use = "abuffer,ppc"};
    way routed = routed_by(v);
    routed.bands = bands;
    picture a = picture_render(sc, instance, &plain, width, height);
    const uint64_t fragments = instance->result.report.total;
    picture b = picture_render(sc, instance, &routed, width, height);
    picture_same(&a, &b, text);
    assert_int_equal(instance->result.report.total, fragments);
    assert_int_equal(instance->result.report.kept, fragments);
    picture_free(&a);
    picture_free(&b);
}

/* ---- fragments that take no layer ------------------------------------------------------------ */

/* Triangles that cover the picture, triangles with a corner of two edges between pixels, and discs
 * round two places such that the pixel between them lies in the square of each and in the disc of
 * none. */
typedef struct pile {
    uint32_t front, level, behind; /* of glass, against a wall */
    uint32_t corners;              /* of glass, anywhere */
    uint32_t masked, turned;       /* that do not exist: by alpha, by their side */
    uint32_t discs, more;          /* at the one place and at the other */
    uint32_t wall;
} pile;

enum { GLASS = 0, COLORS = 3, WALL = COLORS, MASKED, TURNED, CORNERS, DISCS = CORNERS + 4 };

static void add_sheets(base_text *nodes, uint32_t count, uint32_t mesh, double first, double step) {
    for (uint32_t i = 0; i < count; ++i)
        base_text_add(nodes, "{\"mesh\":%u,\"translation\":[0,0,%.9g]%s},",
                      mesh == GLASS ? i % COLORS : mesh, first + i * step,
                      mesh == TURNED ? ",\"rotation\":[0,1,0,0]" : "");
}

/* Each at a corner of pixels, open to one of four sides. */
static void add_corners(base_text *nodes, uint32_t count) {
    const double pixel = 2.0 / SIZE;
    for (uint32_t i = 0, random = 1; i < count; ++i) {
        random = random * 1664525 + 1013904223;
        base_text_add(nodes, "{\"mesh\":%u,\"translation\":[%.9g,%.9g,%.9g]},",
                      CORNERS + (random >> 30), (random >> 8) % SIZE * pixel - 1,
                      (random >> 16) % SIZE * pixel - 1, 0.001 * (random >> 20 & 255u));
    }
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

/* Meshes and materials are numbered alike; corners are of glass, and so are the discs. */
static void add_meshes(test_glb *g, const pile *p) {
    static const float all[9] = {-2, -2, 0, 6, -2, 0, -2, 6, 0};
    const double pixel = 2.0 / SIZE, between = -1 + 6.5 * pixel;
    const uint32_t discs = p->discs + p->more, count = discs ? discs : 1;
    float *places = calloc(count, 3 * sizeof *places);
    base_text t = {0};
    for (uint32_t i = 0; i < count; ++i) {
        places[3 * i] = places[3 * i + 1] = (float)(between + (i < p->discs ? 1.4 : -1.4) * pixel);
        places[3 * i + 2] = (float)(0.5 + 0.001 * i);
    }
    const uint32_t sheet = test_glb_floats(g, "VEC3", 3, 3, all);
    const uint32_t points = test_glb_floats(g, "VEC3", 3, count, places);
    for (uint32_t i = 0; i < DISCS; ++i) {
        const float x = i & 1u ? 8 : -8, y = i & 2u ? 8 : -8;
        const float corner[9] = {0, 0, 0, x, 0, 0, 0, y, 0};
        base_text_add(&t, "{\"primitives\":[{\"material\":%u,\"attributes\":{\"POSITION\":%u}}]},",
                      i < CORNERS ? i : i % COLORS,
                      i < CORNERS ? sheet : test_glb_floats(g, "VEC3", 3, 3, corner));
    }
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
    add_corners(&nodes, p->corners);
    add_sheets(&nodes, p->behind, GLASS, -0.01, -0.01);
    add_sheets(&nodes, p->masked, MASKED, 1.5, 0.001);
    add_sheets(&nodes, p->turned, TURNED, 1.2, 0.001);
    add_sheets(&nodes, p->discs ? 1 : 0, DISCS, 0, 0);
    add_sheets(&nodes, p->level, GLASS, 0, 0);
    add_sheets(&nodes, p->wall, WALL, 0, 0);
    add_sheets(&nodes, p->front, GLASS, 0.01, 0.003);
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

static strata_scene *pile_scene(strata *instance, const pile *p) {
    char path[64];
    write_pile(p, path);
    strata_scene *sc = picture_scene(instance, path);
    unlink(path);
    return sc;
}

static void only_what_is_seen_takes_a_layer(void **state) {
    static const struct {
        pile pile;
        uint32_t largest;
        const char *what;
    } rows[] = {
        {{.front = 20, .behind = 300, .wall = 1}, 20, "300 sheets behind a wall"},
        {{.front = 250, .level = 4, .behind = 9, .wall = 1}, 254, "4 sheets level with a wall"},
        {{.front = 9, .wall = 1}, 9, "a wall behind all"},
        {{.behind = 30, .wall = 1}, 0, "nothing before the wall"},
        {{.front = 100, .masked = 200}, 100, "200 masked sheets"},
        {{.front = 100, .turned = 200}, 100, "200 one-sided sheets seen from behind"},
        {{.front = 100, .discs = 150, .more = 150}, 250, "splats of more corners than layers"},
        {{.front = 100, .discs = 50}, 150, "splats, whose corners find layers enough"},
        {{.front = 12, .behind = 5, .masked = 6, .turned = 7, .discs = 8, .more = 9, .wall = 1},
         21,
         "all"},
    };
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b)
        for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
            strata *instance = variant_instance(&variants[b], rows[i].pile.discs ? EDGES : WHOLE);
            if (!instance)
                continue;
            strata_scene *sc = pile_scene(instance, &rows[i].pile);
            check_same(instance, sc, &variants[b], 1, SIZE, SIZE, rows[i].what);
            assert_int_equal(instance->result.report.largest, rows[i].largest);
            check_same(instance, sc, &variants[b], 3, SIZE, SIZE, rows[i].what);
            strata_scene_close(sc);
        }
}

/* ---- batches and the last layer -------------------------------------------------------------- */

/* That many fragments in each pixel, far ones drawn first. */
static strata_scene *layers_scene(strata *instance, uint32_t count) {
    return pile_scene(instance, &(pile){.front = count});
}

static void layers_fill_batches(void **state) {
    static const uint32_t counts[] = {1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 253, 254};
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b) {
        strata *instance = variant_instance(&variants[b], WHOLE);
        for (size_t i = 0; instance && i < sizeof counts / sizeof *counts; ++i) {
            char what[32];
            snprintf(what, sizeof what, "%u layers", counts[i]);
            strata_scene *sc = layers_scene(instance, counts[i]);
            check_same(instance, sc, &variants[b], 1, SIZE, SIZE, what);
            assert_int_equal(instance->result.report.largest, counts[i]);
            strata_scene_close(sc);
        }
    }
}

/* Pixels differ in their counts, and triangles in the pixels that they cover. */
static void corners_are_routed(void **state) {
    static const uint32_t counts[] = {1, 5, 60, 250};
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b) {
        strata *instance = variant_instance(&variants[b], WHOLE);
        for (size_t i = 0; instance && i < sizeof counts / sizeof *counts; ++i) {
            char what[32];
            snprintf(what, sizeof what, "%u corners", counts[i]);
            strata_scene *sc = pile_scene(instance, &(pile){.corners = counts[i]});
            check_same(instance, sc, &variants[b], 1, SIZE, SIZE, what);
            check_same(instance, sc, &variants[b], 3, SIZE, SIZE, what);
            strata_scene_close(sc);
        }
    }
}

static void equal_depths_keep_their_layers(void **state) {
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b) {
        strata *instance = variant_instance(&variants[b], EDGES);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, "scene:stack?count=254&shift=0&split=1");
        check_same(instance, sc, &variants[b], 1, 13, 11, "254 squares at one depth");
        strata_scene_close(sc);
    }
}

static void one_layer_more_is_refused(void **state) {
    static const uint32_t counts[] = {255, 256, 300};
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b) {
        strata *instance = variant_instance(&variants[b], WHOLE);
        for (size_t i = 0; instance && i < sizeof counts / sizeof *counts; ++i) {
            const char *const settings[] = {variants[b].routing};
            const strata_render_options options = {.struct_size = sizeof options,
                                                   .width = 8,
                                                   .height = 8,
                                                   .use = "stencil",
                                                   .settings = settings,
                                                   .setting_count = 1};
            char line[160];
            snprintf(line, sizeof line,
                     "stencil: a pixel holds %u fragments and a stencil of 8 bits routes 254; "
                     "abuffer has no such limit",
                     counts[i]);
            strata_scene *sc = layers_scene(instance, counts[i]);
            assert_true(strata_render(instance, sc, &options) < 0);
            assert_string_equal(strata_error(instance), line);
            strata_scene_close(sc);

            sc = layers_scene(instance, 20);
            check_same(instance, sc, &variants[b], 1, 8, 8, "after a refusal");
            strata_scene_close(sc);
        }
    }
}

/* ---- the way of routing ---------------------------------------------------------------------- */

/* Of the last recording of the frame. */
static uint32_t passes_of(const strata *instance, const char *label) {
    uint32_t count = 0, found = 0;
    const gpu_timing *timings = gpu_timings(instance->gpu, &count);
    for (uint32_t i = 0; i < count; ++i)
        found += strcmp(timings[i].label, label) == 0;
    return found;
}

/* `auto` and `samples` on a device as it is. */
static void the_self_test_decides(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        const way as_it_comes = {.backend = backends[b], .use = "stencil,ppc"};
        const char *const samples[] = {"stencil.routing=samples"};
        const strata_render_options options = {.struct_size = sizeof options,
                                               .width = SIZE,
                                               .height = SIZE,
                                               .use = "stencil,ppc",
                                               .settings = samples,
                                               .setting_count = 1};
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        const int holds = picture_fact(instance, fact) != 0;
        strata_scene *sc = layers_scene(instance, 9);
        picture p = picture_render(sc, instance, &as_it_comes, SIZE, SIZE);
        assert_int_equal(passes_of(instance, "begin") > 0, holds);
        picture_free(&p);
        assert_int_equal(strata_render(instance, sc, &options),
                         holds ? STRATA_OK : STRATA_ERROR_UNSUPPORTED);
        if (!holds)
            assert_string_equal(strata_error(instance),
                                "stencil: its settings ask for what this device does not have");
        strata_scene_close(sc);
    }
}

/* One geometry pass for all samples of a batch, one a layer else. */
static void samples_share_geometry_passes(void **state) {
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b) {
        const way routed = routed_by(&variants[b]);
        strata *instance = variant_instance(&variants[b], WHOLE);
        if (!instance)
            continue;
        uint32_t samples = (uint32_t)picture_fact(instance, "limit.samples");
        samples = is_layered(&variants[b]) ? 1 : samples < 8 ? samples : 8;
        strata_scene *sc = layers_scene(instance, 19);
        picture p = picture_render(sc, instance, &routed, SIZE, SIZE);
        picture_free(&p);
        assert_int_equal(passes_of(instance, "route"), (19 + samples - 1) / samples);
        assert_int_equal(passes_of(instance, "begin"), samples > 1 ? 19 : 0);
        strata_scene_close(sc);
    }
}

/* A device that routes otherwise than its self-test said is found out, and nothing is shown. */
static void misrouting_is_refused(void **state) {
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b) {
        strata *device = picture_instance(variants[b].device);
        if (is_layered(&variants[b]) || !device || picture_fact(device, fact))
            continue;
        strata *instance = picture_instance(variants[b].backend);
        const strata_render_options options = {
            .struct_size = sizeof options, .width = 64, .height = 64, .use = "stencil,ppc"};
        strata_scene *sc = picture_scene(instance, "scene:soup?small=300&medium=50");
        assert_int_equal(strata_render(instance, sc, &options), STRATA_ERROR_UNSUPPORTED);
        assert_non_null(strstr(strata_error(instance), "stencil: this driver routed "));
        assert_non_null(strstr(strata_error(instance), " pixels otherwise than it counted them"));
        strata_scene_close(sc);
    }
}

/* ---- how many layers a frame has is learned ---------------------------------------------------
 */

static void show(strata_scene *sc, uint32_t from, uint32_t to, uint32_t visible) {
    for (uint32_t i = from; i < to; ++i)
        assert_int_equal(strata_scene_set_visible(sc, i, visible), STRATA_OK);
}

/* How often the frame was recorded again. */
static uint32_t retries(strata *instance, strata_scene *sc, const variant *v) {
    const way routed = routed_by(v);
    picture p = picture_render(sc, instance, &routed, SIZE, SIZE);
    picture_free(&p);
    return (uint32_t)instance->result.retries;
}

static void layers_grow_and_shrink(void **state) {
    (void)state;
    for (size_t b = 0; b < VARIANTS; ++b) {
        const variant *v = &variants[b];
        strata *instance = variant_instance(v, WHOLE);
        if (!instance)
            continue;
        strata_scene *sc = pile_scene(instance, &(pile){.front = 40});
        show(sc, 5, 40, 0);
        retries(instance, sc, v);
        assert_int_equal(retries(instance, sc, v), 0);
        show(sc, 5, 40, 1);
        assert_true(retries(instance, sc, v) > 0);
        assert_int_equal(retries(instance, sc, v), 0);
        show(sc, 5, 40, 0);
        for (int i = 0; i < 70; ++i) /* fewer layers are needed for two windows of 32 frames */
            assert_int_equal(retries(instance, sc, v), 0);
        show(sc, 5, 40, 1);
        assert_true(retries(instance, sc, v) > 0);
        check_same(instance, sc, v, 1, SIZE, SIZE, "grown, shrunk and grown");
        strata_scene_close(sc);
    }
}

/* Opaque geometry comes while the scene is shown, with or without what it hides. */
static void a_wall_appears(void **state) {
    static const uint32_t hidden_at_first[][2] = {{6, 7}, {0, 7}}; /* 6 behind, then the wall */
    (void)state;
    for (size_t i = 0; i < 2 * VARIANTS; ++i) {
        const variant *v = &variants[i / 2];
        const uint32_t *hidden = hidden_at_first[i % 2];
        strata *instance = variant_instance(v, WHOLE);
        if (!instance)
            continue;
        strata_scene *sc = pile_scene(instance, &(pile){.front = 6, .behind = 6, .wall = 1});
        show(sc, hidden[0], hidden[1], 0);
        retries(instance, sc, v);
        show(sc, hidden[0], hidden[1], 1);
        const way routed = routed_by(v);
        const way plain = {.backend = v->backend, .use = "abuffer,ppc"};
        picture a = picture_render(sc, instance, &routed, SIZE, SIZE);
        picture b = picture_render(sc, instance, &plain, SIZE, SIZE);
        picture_same(&a, &b, v->backend);
        picture_free(&a);
        picture_free(&b);
        strata_scene_close(sc);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_what_is_seen_takes_a_layer),
        cmocka_unit_test(layers_fill_batches),
        cmocka_unit_test(corners_are_routed),
        cmocka_unit_test(equal_depths_keep_their_layers),
        cmocka_unit_test(one_layer_more_is_refused),
        cmocka_unit_test(the_self_test_decides),
        cmocka_unit_test(samples_share_geometry_passes),
        cmocka_unit_test(misrouting_is_refused),
        cmocka_unit_test(layers_grow_and_shrink),
        cmocka_unit_test(a_wall_appears),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    picture_close();
    return failed;
}
