/* SPDX-License-Identifier: MIT
 *
 * Occlusion culling hides no visible object: on scenes made to be hard on it (cull_scenes.h) each
 * frame is checked object by object by `cullcheck`, and compared with the frame that nobody culled:
 * depth bit for bit, colour too where ties are decided. A longer run of the same: hiz_sweep.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/render.h"
#include "scene/upload_internal.h"
#include "techniques/cull_scenes.h"

static const char *const backends[] = {"vulkan", "gl"};
static cull_rig rigs[2];

static int open_rigs(void **state) {
    (void)state;
    int any = 0;
    for (int b = 0; b < 2; ++b) {
        any |= cull_open(backends[b], 1, &rigs[b]);
        if (!rigs[b].culled)
            print_message("%s cannot be opened\n", backends[b]);
    }
    return any ? 0 : -1;
}

static int close_rigs(void **state) {
    (void)state;
    for (int b = 0; b < 2; ++b)
        cull_close(&rigs[b]);
    return 0;
}

static cull_counts run_on_both(cull_case c) {
    cull_counts counts = {0};
    for (int b = 0; b < 2; ++b) {
        if (!rigs[b].culled)
            continue;
        cull_run(&rigs[b], &c, &counts, NULL, NULL);
        if (counts.failure[0])
            fail_msg("%s: %s", backends[b], counts.failure);
    }
    return counts;
}

static void show(const char *what, const cull_counts *n) {
    print_message("%s: %llu object-frames, %llu outside, %llu slipped, %llu occluded, %llu "
                  "visible, %llu late, "
                  "%llu overshot, %llu ties\n",
                  what, (unsigned long long)n->object_frames, (unsigned long long)n->outside,
                  (unsigned long long)n->slipped, (unsigned long long)n->occluded,
                  (unsigned long long)n->visible, (unsigned long long)n->late,
                  (unsigned long long)n->overshot, (unsigned long long)n->ties);
}

/* ---- hard scenes ----------------------------------------------------------------------------- */

/* At each pixel of small images in turn: no level of the pyramid may lose it, at any size. */
static void holes_of_a_pixel_at_every_offset(void **state) {
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {2, 2}, {3, 3}, {5, 5}, {17, 3}, {3, 17}, {17, 17}};
    static const char *const taps[] = {"hiz.taps=2", "hiz.taps=4", "hiz.taps=8"};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
        for (uint64_t seed = 1; seed <= (i < 6 ? 9 : 3); ++seed)
            run_on_both((cull_case){.kind = CULL_HOLES,
                                    .seed = seed * 101 + i,
                                    .objects = 14,
                                    .frames = sizes[i][0] * sizes[i][1],
                                    .width = sizes[i][0],
                                    .height = sizes[i][1],
                                    .sweep_holes = 1,
                                    .settings = {taps[seed % 3], "hiz.history=keep"}});
}

static void holes_in_larger_images(void **state) {
    (void)state;
    static const uint32_t sizes[][2] = {{257, 129}, {641, 479}, {97, 61}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i)
        run_on_both((cull_case){.kind = CULL_HOLES,
                                .seed = 7 + i,
                                .objects = 24,
                                .frames = i == 1 ? 4 : 16,
                                .width = sizes[i][0],
                                .height = sizes[i][1]});
}

static void run_kind(cull_kind kind, uint32_t cases, uint32_t objects) {
    cull_counts all = {0};
    for (uint64_t seed = 1; seed <= cases; ++seed) {
        const cull_counts n =
            run_on_both((cull_case){.kind = kind, .seed = seed, .objects = objects, .frames = 8});
        all.object_frames += n.object_frames;
        all.outside += n.outside;
        all.slipped += n.slipped;
        all.occluded += n.occluded;
        all.visible += n.visible;
        all.late += n.late;
        all.overshot += n.overshot;
        all.ties += n.ties;
    }
    show(cull_kind_names[kind], &all);
    assert_true(all.occluded > 0 && all.outside > 0 && all.visible > 0 && all.late > 0);
}

static void walls_beside_the_eye(void **state) {
    (void)state;
    run_kind(CULL_NEAR, 6, 60);
}

static void any_transform(void **state) {
    (void)state;
    run_kind(CULL_RANDOM, 8, 100);
}

static void equal_depths(void **state) {
    (void)state;
    run_kind(CULL_COPLANAR, 6, 60);
}

static void slivers(void **state) {
    (void)state;
    run_kind(CULL_SLIVERS, 6, 100);
}

static void clusters(void **state) {
    (void)state;
    run_kind(CULL_CLUSTERS, 4, 30);
}

static void glass(void **state) {
    (void)state;
    run_kind(CULL_GLASS, 6, 60);
}

static void what_deforms(void **state) {
    (void)state;
    run_kind(CULL_DEFORM, 5, 40);
}

/* Whatever the last frame is said to have seen. */
static void scrambled_history(void **state) {
    (void)state;
    static const char *const histories[] = {"hiz.history=none", "hiz.history=all",
                                            "hiz.history=random", "hiz.history=keep"};
    for (size_t i = 0; i < 4; ++i)
        for (int kind = 0; kind < CULL_KINDS; ++kind)
            run_on_both((cull_case){.kind = (cull_kind)kind,
                                    .seed = 50 + i,
                                    .objects = 40,
                                    .frames = 3,
                                    .settings = {histories[i], "hiz.certify=1"}});
}

/* ---- what is found --------------------------------------------------------------------------- */

static strata_result append(void *user, const char *bytes, size_t size) {
    base_text_append(user, bytes, size);
    return STRATA_OK;
}

/* As the account has it. */
static json_int_t drawn_of(strata *s) {
    base_text text = {0};
    assert_int_equal(strata_account(s, append, &text), STRATA_OK);
    json_t *account = json_loads(text.data, 0, NULL);
    const json_t *drawn = json_object_get(json_object_get(account, "objects"), "drawn");
    assert_true(json_is_integer(drawn));
    const json_int_t value = json_integer_value(drawn);
    json_decref(account);
    base_text_free(&text);
    return value;
}

/* A pass-through culls nothing and is right: behind a wall that fills the image everything goes,
 * and nine in front of it, far smaller than a pixel, slip between two rows of pixels. */
static void everything_behind_a_wall_is_culled(void **state) {
    (void)state;
    for (int b = 0; b < 2; ++b) {
        if (!rigs[b].culled)
            continue;
        const cull_case c = {.kind = CULL_HOLES, .seed = 3, .objects = 60};
        strata_scene *sc = cull_scene(rigs[b].culled, &c);
        const strata_camera_pose pose = {.struct_size = sizeof pose,
                                         .eye = {0, 0, 100},
                                         .up = {0, 1, 0},
                                         .height = 32,
                                         .near = 1,
                                         .far = 200};
        const strata_render_options options = {.struct_size = sizeof options,
                                               .width = 47,
                                               .height = 32,
                                               .use = "surface,hiz,cullcheck",
                                               .pose = &pose,
                                               .repeat = 2};
        const float wall[16] = {100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1};
        assert_non_null(sc);
        for (uint32_t i = 0; i < 60; ++i) {
            const float box[16] = {1 + (float)i, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
            const float dot[16] = {1e-3f, 0, 0,     0, 0,        1e-3f, 0,  0,
                                   0,     0, 1e-3f, 0, (float)i, 0,     50, 1};
            assert_int_equal(strata_scene_set_transform(sc, i,
                                                        i > 9   ? box
                                                        : i > 0 ? dot
                                                                : wall),
                             STRATA_OK);
        }
        if (strata_render(rigs[b].culled, sc, &options) != STRATA_OK)
            fail_msg("%s", strata_error(rigs[b].culled));
        const render_report *report = &rigs[b].culled->session->report;
        assert_int_equal(report->objects, 60);
        assert_int_equal(report->occluded, 50);
        assert_int_equal(report->slipped, 9);
        assert_int_equal(report->visible, 1);
        assert_int_equal(drawn_of(rigs[b].culled), 1);
        strata_scene_close(sc);
    }
}

/* As many draws as there is room for, in one round or in two; numbers around those of chunks and
 * work groups. */
static void every_object_may_be_drawn(void **state) {
    (void)state;
    enum { SIDE = 47, PIXELS = SIDE * 3 };
    static const uint32_t counts[] = {1, 2, 31, 32, 33, 63, 65, 2047, 2048, 2049, 2209};
    static const char *const histories[] = {"hiz.history=keep", "hiz.history=random",
                                            "hiz.history=all", "hiz.history=none"};
    static float depth[2][PIXELS * PIXELS][4];
    const strata_camera_pose pose = {.struct_size = sizeof pose,
                                     .eye = {0, 0, 10},
                                     .up = {0, 1, 0},
                                     .height = SIDE,
                                     .near = 1,
                                     .far = 20};
    for (size_t i = 0; i < 2 * sizeof counts / sizeof *counts; ++i) {
        const cull_rig *rig = &rigs[i % 2];
        const cull_case c = {.kind = CULL_COPLANAR, .seed = i, .objects = counts[i / 2]};
        if (!rig->culled)
            continue;
        for (int k = 0; k < 2; ++k) {
            strata *s = k ? rig->plain : rig->culled;
            strata_scene *sc = cull_scene(s, &c);
            const strata_render_options options = {.struct_size = sizeof options,
                                                   .width = PIXELS,
                                                   .height = PIXELS,
                                                   .outputs = STRATA_OUTPUT_DEPTH,
                                                   .use = k ? "surface" : "surface,hiz,cullcheck",
                                                   .settings = &histories[i % 4],
                                                   .setting_count = k ? 0 : 1,
                                                   .pose = &pose,
                                                   .repeat = 2};
            assert_non_null(sc);
            for (uint32_t n = 0; n < c.objects; ++n) {
                const float cell[16] = {1,
                                        0,
                                        0,
                                        0,
                                        0,
                                        1,
                                        0,
                                        0,
                                        0,
                                        0,
                                        1,
                                        0,
                                        (float)(n % SIDE) - 23,
                                        (float)(n / SIDE) - 23,
                                        (float)(n % 7),
                                        1};
                assert_int_equal(strata_scene_set_transform(sc, n, cell), STRATA_OK);
            }
            if (strata_render(s, sc, &options) != STRATA_OK)
                fail_msg("%u objects: %s", c.objects, strata_error(s));
            if (k == 0)
                assert_int_equal(s->session->report.visible, c.objects);
            strata_read(s, STRATA_OUTPUT_DEPTH, depth[k][0], sizeof depth[k]);
            strata_scene_close(sc);
        }
        assert_memory_equal(depth[0], depth[1], sizeof depth[0]);
    }
}

/* ---- the checker itself ---------------------------------------------------------------------- */

/* States that are written by hand, where nobody culls: wrong ones are found, others pass. */
static void the_checker_finds_what_is_wrong(void **state) {
    (void)state;
    enum { HIDDEN = 2, SEEN = 0, OUTSIDE = 4, OCCLUDED = 6 };
    static const struct {
        uint32_t object, as;
        int wrong;
    } rows[] = {
        {HIDDEN, OCCLUDED, 0}, {SEEN, OCCLUDED, 1}, {SEEN, OUTSIDE, 1}, {HIDDEN, OUTSIDE, 0}};
    static const float worlds[3][16] = {{1, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1, 0, -.5f, 0, 1, 1},
                                        {1, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1, 0, .5f, 0, 1, 1},
                                        {.5f, 0, 0, 0, 0, .5f, 0, 0, 0, 0, .1f, 0, 0, 0, -1, 1}};
    const strata_camera_pose pose = {.struct_size = sizeof pose,
                                     .eye = {0, 0, 10},
                                     .up = {0, 1, 0},
                                     .height = 2,
                                     .near = 1,
                                     .far = 20};
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = 24,
                                           .height = 24,
                                           .use = "surface,cullcheck",
                                           .pose = &pose};
    for (size_t i = 0; i < 2 * sizeof rows / sizeof *rows; ++i) {
        strata *s = rigs[i % 2].culled;
        const cull_case c = {.kind = CULL_RANDOM, .seed = 1, .objects = 3};
        base_error err = {0};
        if (!s)
            continue;
        strata_scene *sc = cull_scene(s, &c);
        assert_non_null(sc);
        for (uint32_t k = 0; k < 3; ++k)
            strata_scene_set_transform(sc, k, worlds[k]);
        strata_scene_set_visible(sc, 1, 1);
        assert_int_equal(strata_render(s, sc, &options), STRATA_OK);
        const uint32_t objects = upload_count(s->session->upload).objects;
        assert_int_equal(gpu_buffer_write(s->gpu, s->session->upload->states,
                                          rows[i / 2].object * sizeof(uint32_t), sizeof(uint32_t),
                                          &rows[i / 2].as, &err),
                         STRATA_OK);
        const strata_result r = strata_render(s, sc, &options);
        assert_int_equal(r, rows[i / 2].wrong ? STRATA_ERROR_MODULE : STRATA_OK);
        if (rows[i / 2].wrong) {
            char line[128];
            snprintf(
                line, sizeof line,
                "cullcheck: 1 of %u objects are culled and visible, the first of them object 0",
                objects);
            assert_string_equal(strata_error(s), line);
        }
        strata_scene_close(sc);
    }
}

static uint32_t bits_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* The picture of the pyramid against blocks computed here. */
static void the_pyramid_is_shown_as_it_is(void **state) {
    (void)state;
    enum { WIDTH = 61, HEIGHT = 45, LEVEL = 3, BLOCKS = 8 };
    static const char *const settings[] = {"cullcheck.show=pyramid", "cullcheck.level=3"};
    static float pixels[WIDTH * HEIGHT][4], depth[HEIGHT][WIDTH];
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = WIDTH,
                                           .height = HEIGHT,
                                           .use = "surface,cullcheck",
                                           .effects = "none",
                                           .settings = settings,
                                           .setting_count = 2};
    for (int b = 0; b < 2; ++b) {
        strata *s = rigs[b].culled;
        strata_scene *sc = NULL;
        base_error err = {0};
        uint32_t block[BLOCKS][BLOCKS], lowest = UINT32_MAX, highest = 0;
        if (!s)
            continue;
        assert_int_equal(strata_scene_load(s, "scene:city?count=60", &sc), STRATA_OK);
        if (strata_render(s, sc, &options) != STRATA_OK)
            fail_msg("%s", strata_error(s));
        assert_int_equal(strata_read(s, STRATA_OUTPUT_COLOR, pixels[0], sizeof pixels), STRATA_OK);
        assert_int_equal(gpu_image_read(s->gpu, s->session->depth, 0, depth, sizeof depth, &err),
                         STRATA_OK);
        memset(block, 0xff, sizeof block);
        for (int y = 0; y < HEIGHT; ++y)
            for (int x = 0; x < WIDTH; ++x) {
                const uint32_t d = bits_of(depth[y][x]), *to = &block[y >> LEVEL][x >> LEVEL];
                block[y >> LEVEL][x >> LEVEL] = d < *to ? d : *to;
                lowest = d && d < lowest ? d : lowest;
                highest = d > highest ? d : highest;
            }
        for (int y = 0; y < HEIGHT; ++y)
            for (int x = 0; x < WIDTH; ++x) {
                const uint32_t d = block[y >> LEVEL][x >> LEVEL];
                const float grey =
                    d ? 0.03f + 0.97f * (float)(d - lowest) / (float)(highest - lowest) : 0.0f;
                assert_float_equal(pixels[(HEIGHT - 1 - y) * WIDTH + x][0], grey, 1e-5);
            }
        strata_scene_close(sc);
    }
}

/* Culled objects are red where they are, drawn ones green or yellow; both backends agree. */
static void states_are_shown(void **state) {
    (void)state;
    enum { SIZE = 64 };
    static const char *const settings[] = {"cullcheck.show=states"};
    static float pixels[2][SIZE * SIZE][4];
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = SIZE,
                                           .height = SIZE,
                                           .use = "surface,hiz,cullcheck",
                                           .effects = "none",
                                           .settings = settings,
                                           .setting_count = 1,
                                           .repeat = 2};
    for (int b = 0; b < 2; ++b) {
        strata *s = rigs[b].culled;
        strata_scene *sc = NULL;
        uint32_t red = 0, green = 0;
        if (!s)
            skip();
        assert_int_equal(strata_scene_load(s, "scene:city?count=2000", &sc), STRATA_OK);
        if (strata_render(s, sc, &options) != STRATA_OK)
            fail_msg("%s", strata_error(s));
        strata_read(s, STRATA_OUTPUT_COLOR, pixels[b][0], sizeof pixels[b]);
        for (int i = 0; i < SIZE * SIZE; ++i) {
            const float *p = pixels[b][i];
            red += p[0] > p[1] && p[0] > p[2] && p[0] > 0.05f;
            green += p[1] > p[0] && p[1] > p[2] && p[1] > 0.05f;
        }
        assert_true(red > 20 && green > 200);
        strata_scene_close(sc);
    }
    for (int i = 0; i < SIZE * SIZE * 4; ++i)
        assert_float_equal(pixels[0][i / 4][i % 4], pixels[1][i / 4][i % 4], 1e-5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_checker_finds_what_is_wrong),
        cmocka_unit_test(the_pyramid_is_shown_as_it_is),
        cmocka_unit_test(states_are_shown),
        cmocka_unit_test(everything_behind_a_wall_is_culled),
        cmocka_unit_test(every_object_may_be_drawn),
        cmocka_unit_test(holes_of_a_pixel_at_every_offset),
        cmocka_unit_test(holes_in_larger_images),
        cmocka_unit_test(walls_beside_the_eye),
        cmocka_unit_test(any_transform),
        cmocka_unit_test(equal_depths),
        cmocka_unit_test(slivers),
        cmocka_unit_test(clusters),
        cmocka_unit_test(glass),
        cmocka_unit_test(what_deforms),
        cmocka_unit_test(scrambled_history),
    };
    return cmocka_run_group_tests(tests, open_rigs, close_rigs);
}
