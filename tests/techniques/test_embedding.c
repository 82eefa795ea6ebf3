/* SPDX-License-Identifier: MIT
 *
 * strata/host.h and strata/frame.h held to their words: what an embedding program may keep, may not
 * mix, and finds after failures; that pools of opaque techniques are verified like all others.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/gpu_internal.h"
#include "render/render.h"

enum { WIDTH = 16, HEIGHT = 8 };

static strata *open_on(const char *backend) {
    const strata_open_options options = {.struct_size = sizeof options, .backend = backend};
    strata *s = NULL;
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    return s;
}

static strata *open_null(void) {
    return open_on("null");
}

static strata_scene *layers(strata *s) {
    strata_scene *sc = NULL;
    assert_int_equal(strata_scene_load(s, "scene:layers?count=3", &sc), STRATA_OK);
    return sc;
}

static const strata_render_options small = {
    .struct_size = sizeof small, .width = WIDTH, .height = HEIGHT};

static strata_result ignore(void *user, const char *text, size_t length) {
    (void)user, (void)text, (void)length;
    return STRATA_OK;
}

/* "The image stays with the instance until the next render." */
static void the_image_outlives_its_scene(void **state) {
    static float pixels[HEIGHT * WIDTH * 4];
    uint32_t width = 0, height = 0;
    (void)state;
    strata *s = open_null();
    strata_scene *sc = layers(s);
    assert_int_equal(strata_render(s, sc, &small), STRATA_OK);
    strata_scene_close(sc);
    assert_int_equal(strata_size(s, &width, &height), STRATA_OK);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    assert_int_equal(strata_read(s, STRATA_OUTPUT_COLOR, pixels, sizeof pixels), STRATA_OK);
    assert_int_equal(strata_account(s, ignore, NULL), STRATA_ERROR_INVALID_STATE);
    assert_non_null(strstr(strata_error(s), "closed"));
    strata_close(s);
}

static void a_scene_of_another_instance_is_refused(void **state) {
    (void)state;
    strata *s = open_null(), *other = open_null();
    strata_scene *sc = layers(other);
    assert_int_equal(strata_render(s, sc, &small), STRATA_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(strata_error(s), "another instance"));
    assert_int_equal(strata_plan(s, sc, &small, ignore, NULL), STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(strata_render(other, sc, &small), STRATA_OK);
    strata_close(other);
    strata_close(s);
}

/* Options of a later version: their unknown end must be zero, and is then no matter. */
static void unknown_options_are_refused(void **state) {
    struct {
        strata_open_options known;
        uint64_t later;
    } open = {.known = {.struct_size = sizeof open, .backend = "null"}, .later = 1};
    struct {
        strata_render_options known;
        uint64_t later;
    } render = {.known = small, .later = 1};
    strata *s = NULL;
    (void)state;
    render.known.struct_size = sizeof render;
    assert_int_equal(strata_open(&open.known, &s), STRATA_ERROR_INVALID_ARGUMENT);
    assert_null(s);
    assert_non_null(strstr(strata_error(NULL), "strata_open"));
    open.later = 0;
    assert_int_equal(strata_open(&open.known, &s), STRATA_OK);
    strata_scene *sc = layers(s);
    assert_int_equal(strata_render(s, sc, &render.known), STRATA_ERROR_INVALID_ARGUMENT);
    render.later = 0;
    assert_int_equal(strata_render(s, sc, &render.known), STRATA_OK);
    strata_close(s);
}

static void render_refused(strata *s, strata_scene *sc, const strata_render_options *options,
                           const char *line) {
    assert_true(strata_render(s, sc, options) < 0);
    if (!strstr(strata_error(s), line))
        fail_msg("'%s' instead of '%s'", strata_error(s), line);
}

static void senseless_options_are_refused(void **state) {
    strata_render_options o = small;
    (void)state;
    strata *s = open_null();
    strata_scene *sc = layers(s);
    o.setting_count = 2;
    render_refused(s, sc, &o, "settings");
    o = small, o.tolerance = -1;
    render_refused(s, sc, &o, "tolerance");
    o = small, o.tolerance = (double)NAN;
    render_refused(s, sc, &o, "tolerance");
    o = small, o.pace = -1;
    render_refused(s, sc, &o, "pace");
    o = small, o.pace = (double)INFINITY;
    render_refused(s, sc, &o, "pace");
    o = small, o.outputs = 0x80;
    render_refused(s, sc, &o, "outputs");
    o = small, o.bands = UINT32_MAX; /* more than there are pixels: one each */
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    assert_int_equal(s->session->band_count, WIDTH * HEIGHT);
    strata_close(s);
}

static double longest_learnt(double pace) {
    const strata_open_options options = {.struct_size = sizeof options, .cache_dir = ""};
    strata_render_options o = small;
    strata *s = NULL;
    double longest = 0;
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    o.repeat = 3;
    o.learn = 1;
    o.pace = pace;
    assert_int_equal(strata_render(s, layers(s), &o), STRATA_OK);
    for (uint32_t i = 0; i < s->costs.count; ++i)
        for (uint32_t k = 0; k < s->costs.techniques[i].count; ++k)
            longest = fmax(longest, s->costs.techniques[i].points[k].ms);
    strata_close(s);
    return longest;
}

/* Of frames that take a billion times as long as usual next to nothing is learnt. */
static void what_is_learnt_is_in_the_usual_pace(void **state) {
    (void)state;
    const double usual = longest_learnt(0);
    if (!(usual > 0))
        skip(); /* a device that times no passes */
    assert_true(usual > 1e-4 && longest_learnt(1e9) < 1e-4 && longest_learnt(1) > 1e-4);
}

/* Frames that all points rest on. */
static uint32_t learnt_frames(const strata *s) {
    uint32_t frames = 0;
    for (uint32_t i = 0; i < s->costs.count; ++i)
        for (uint32_t k = 0; k < s->costs.techniques[i].count; ++k)
            frames += s->costs.techniques[i].points[k].frames;
    return frames;
}

/* Where all was learnt on a device a thousand times slower, or as much faster, it is that much
 * faster now, or slower; also where half of what runs is known. */
static void the_pace_is_told_by_what_is_known(void **state) {
    (void)state;
    static const double slower[] = {1000, 1, 0.001};
    for (size_t i = 0; i < 2 * BASE_COUNT(slower); ++i) {
        const strata_open_options options = {.struct_size = sizeof options, .cache_dir = ""};
        base_error err = {0};
        strata_render_options o = small;
        strata *s = NULL;
        assert_int_equal(strata_open(&options, &s), STRATA_OK);
        strata_scene *sc = layers(s);
        o.use = "abuffer,ppc";
        o.repeat = 6;
        o.learn = 1;
        assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
        if (learnt_frames(s) == 0)
            skip();
        for (uint32_t k = 0; k < s->costs.count; ++k) {
            for (uint32_t m = 0; m < s->costs.techniques[k].count; ++m)
                s->costs.techniques[k].points[m].ms *= slower[i / 2];
            if (i % 2 && strcmp(s->costs.techniques[k].name, "ppc") == 0)
                s->costs.techniques[k].name[0] = '-'; /* is not known */
        }
        assert_int_equal(render_costs_fit(s, &s->costs, &err), STRATA_OK);
        o.learn = 0;
        assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
        const double pace = render_frame_pace(s) * slower[i / 2];
        assert_int_equal(render_knows_frame(s), i % 2 == 0);
        assert_true(pace > 0.1 && pace < 10);
        o.budget = 1e-3; /* is missed: the next plan expects of all what this one's frames told */
        o.repeat = 8;
        assert_true(strata_render(s, sc, &o) >= STRATA_OK);
        const double expects = s->budget.ns / s->costs.ns * slower[i / 2];
        assert_true(i % 2 == 0 || (expects > 0.1 && expects < 10));
        for (uint32_t k = 0; k < s->costs.count; ++k)
            s->costs.techniques[k].name[0] = '-';
        assert_true(render_frame_pace(s) == 0);
        strata_close(s);
    }
}

/* What a plan expects is of the view that it was made for: others would be learnt as if they were
 * that one. */
static void other_views_teach_nothing(void **state) {
    (void)state;
    const strata_open_options options = {.struct_size = sizeof options, .cache_dir = ""};
    strata_render_options o = small;
    strata *s = NULL;
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    strata_scene *sc = layers(s);
    o.repeat = 3;
    o.learn = 1;
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    const uint32_t first = learnt_frames(s);
    o.continues = 1;
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    const uint32_t second = learnt_frames(s);
    o.angle = 90;
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    assert_int_equal(learnt_frames(s), second);
    o.angle = 0;
    o.camera = "orbit:50,30";
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    assert_int_equal(learnt_frames(s), second);
    if (first == 0)
        skip(); /* a device that times no passes */
    assert_true(second > first);
    o.continues = 0;
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    assert_true(learnt_frames(s) > second);
    strata_close(s);
}

/* Behind hiz surfaces cost less than their terms say. */
static void what_is_culled_teaches_nothing(void **state) {
    (void)state;
    static const char *const uses[] = {"surface,abuffer,ppc", "hiz,surface,abuffer,ppc"};
    for (size_t i = 0; i < BASE_COUNT(uses); ++i) {
        const strata_open_options options = {.struct_size = sizeof options, .cache_dir = ""};
        strata_render_options o = small;
        strata *s = NULL;
        strata_scene *sc = NULL;
        assert_int_equal(strata_open(&options, &s), STRATA_OK);
        assert_int_equal(strata_scene_load(s, "scene:city?count=200", &sc), STRATA_OK);
        o.use = uses[i];
        o.repeat = 3;
        o.learn = 1;
        assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
        uint32_t drew = 0, folded = 0;
        for (uint32_t k = 0; k < s->costs.count; ++k) {
            drew += strcmp(s->costs.techniques[k].name, "surface") == 0 ||
                    strcmp(s->costs.techniques[k].name, "abuffer") == 0;
            folded += strcmp(s->costs.techniques[k].name, "ppc") == 0;
        }
        strata_close(s);
        if (folded == 0)
            skip();
        assert_int_equal(drew, i == 0 ? 2 : 0);
    }
}

/* A sequence with a budget that failed to begin begins with the frame that continues it. */
static void a_budget_begins_late(void **state) {
    (void)state;
    strata *s = open_null();
    strata_scene *sc = layers(s);
    strata_render_options o = small;
    o.budget = 5;
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    o.camera = "nope";
    assert_true(strata_render(s, sc, &o) < 0);
    o.camera = NULL;
    o.continues = 1;
    assert_int_equal(strata_render(s, sc, &o), STRATA_OK);
    assert_int_equal(strata_account(s, ignore, NULL), STRATA_OK);
    assert_int_equal(json_array_size(s->budget.plans), 1);
    strata_close(s);
}

/* A session that goes on tells of the scene as it is now. */
static void evidence_is_of_the_scene_as_it_is(void **state) {
    char before[192] = "";
    (void)state;
    strata *s = open_null();
    strata_scene *sc = NULL;
    const render_session *session = NULL;
    assert_int_equal(strata_scene_load(s, "scene:stack", &sc), STRATA_OK); /* of three */
    for (uint32_t hidden = 0; hidden < 2; ++hidden) {
        assert_int_equal(strata_scene_set_visible(sc, 0, !hidden), STRATA_OK);
        assert_int_equal(strata_render(s, sc, &small), STRATA_OK);
        const plan_effect *over = &s->session->plan->effects[0];
        assert_string_equal(over->effect->id, "over");
        assert_int_equal(hidden && strcmp(before, over->evidence) == 0, 0);
        assert_true(!hidden || s->session == session);
        session = s->session;
        snprintf(before, sizeof before, "%s", over->evidence);
    }
    strata_close(s);
}

/* However often the device is lost, from one render to the next it is replaced. */
static void every_render_may_lose_the_device(void **state) {
    (void)state;
    strata *s = open_null();
    strata_scene *sc = layers(s);
    for (int i = 0; i < 4; ++i) {
        if (strata_render(s, sc, &small) != STRATA_OK)
            fail_msg("render %d: %s", i, strata_error(s));
        assert_int_equal(s->result.warning_count, i > 0);
        s->gpu->lost = 1;
    }
    assert_int_equal(s->exclusion_count, 0);
    strata_close(s);
}

/* ---- pools of the opaque half -----------------------------------------------------------------
 */

enum { NEEDED = 300000 };

static const strata_glsl demanding = {
    .text = "layout(local_size_x = 1) in;\n"
            "layout(std430) buffer Demand { uint needed; uint capacity; };\n"
            "layout(std430) writeonly buffer Values { uint values[]; };\n"
            "void main() { needed = 300000u; values[0] = capacity; }\n",
    .path = "demanding.comp.glsl"};

/* The surface technique with a pool of its own. */
static struct {
    strata_technique table;
    const strata_technique *surface;
    const strata_gpu *gpu;
    strata_program program;
    strata_pool pool;
    uint64_t seen; /* by verify() */
    uint32_t verified;
} opaque;

static strata_result opaque_prepare(void *state, const strata_view *view) {
    const strata_pool_desc pool = {.struct_size = sizeof pool,
                                   .label = "values",
                                   .plane_count = 1,
                                   .counter_name = "Demand",
                                   .plane_names = {"Values"},
                                   .plane_strides = {4},
                                   .expected = 16};
    const strata_program_desc program = {.struct_size = sizeof program,
                                         .kind = STRATA_PROGRAM_COMPUTE,
                                         .label = "demand",
                                         .source = &demanding};
    strata_result r = opaque.surface->prepare(state, view);
    if (r == STRATA_OK)
        r = opaque.gpu->pool_create(opaque.gpu->self, &pool, &opaque.pool);
    if (r == STRATA_OK)
        r = opaque.gpu->program_create(opaque.gpu->self, &program, &opaque.program);
    return r;
}

static void opaque_record(void *state, const strata_frame *frame) {
    const strata_bind bind = {.struct_size = sizeof bind, .pool = opaque.pool};
    opaque.surface->record(state, frame);
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "demand",
                                            .program = opaque.program,
                                            .groups = {1},
                                            .binds = &bind,
                                            .bind_count = 1});
}

static strata_result opaque_verify(void *state, const strata_frame *frame) {
    opaque.verified++;
    opaque.seen = frame->needed(frame->self, opaque.pool);
    return opaque.surface->verify ? opaque.surface->verify(state, frame) : STRATA_OK;
}

static void pools_of_opaque_techniques_grow(void **state) {
    static const char *const backends[] = {"vulkan", "gl"};
    strata_render_options banded = small;
    banded.bands = 3;
    banded.use = "surface,abuffer,ppc";
    (void)state;
    for (size_t b = 0; b < BASE_COUNT(backends); ++b) {
        strata *s = open_on(backends[b]);
        strata_scene *sc = NULL;
        assert_int_equal(strata_scene_load(s, "scene:city", &sc), STRATA_OK);
        if (strata_render(s, sc, &banded) != STRATA_OK) {
            print_message("%s: %s\n", backends[b], strata_error(s));
            strata_close(s);
            continue;
        }
        render_technique *t = &s->session->techniques[0];
        assert_string_equal(t->technique->stage, "surface");
        memset(&opaque, 0, sizeof opaque);
        opaque.surface = t->technique;
        opaque.table = *t->technique;
        opaque.table.prepare = opaque_prepare;
        opaque.table.record = opaque_record;
        opaque.table.verify = opaque_verify;
        opaque.gpu = &t->gpu;
        t->technique = &opaque.table;
        s->session->prepared = 0;
        if (strata_render(s, sc, &banded) != STRATA_OK)
            fail_msg("%s: %s", backends[b], strata_error(s));
        assert_int_equal(opaque.seen, NEEDED);
        assert_true(gpu_pool_capacity(s->gpu, opaque.pool) >= NEEDED);
        assert_int_equal(opaque.verified,
                         s->result.retries + 1); /* once a frame, not once a band */
        strata_close(s);
    }
}

/* ---- structs of techniques --------------------------------------------------------------------
 */

/* The capture technique, which first hands over structs that the host must not trust. */
static struct {
    strata_technique table;
    const strata_technique *capture;
    const strata_gpu *gpu;
    uint32_t probed;
} careless;

static void probe_creation(const strata_gpu *table) {
    struct {
        strata_image_desc known;
        uint64_t later;
    } picture = {
        .known = {.struct_size = sizeof picture, .format = STRATA_FORMAT_R32F, .label = "i"},
        .later = 1};
    struct {
        strata_pool_desc known;
        uint64_t later;
    } pool = {.known = {.struct_size = sizeof pool,
                        .label = "p",
                        .plane_count = 1,
                        .counter_name = "C",
                        .plane_names = {"P"},
                        .plane_strides = {4}},
              .later = 1};
    strata_image i = {1};
    strata_pool p = {1};
    assert_int_equal(table->image_create(table->self, NULL, &i), STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(i.id, 0);
    assert_int_equal(table->pool_create(table->self, NULL, &p), STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(p.id, 0);
    assert_int_equal(table->image_create(table->self, &picture.known, &i),
                     STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(table->pool_create(table->self, &pool.known, &p),
                     STRATA_ERROR_INVALID_ARGUMENT);
    picture.later = pool.later = 0;
    assert_int_equal(table->image_create(table->self, &picture.known, &i), STRATA_OK);
    assert_int_equal(table->pool_create(table->self, &pool.known, &p), STRATA_OK);
    picture.known.struct_size = pool.known.struct_size = 0;
    assert_int_equal(table->image_create(table->self, &picture.known, &i),
                     STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(table->pool_create(table->self, &pool.known, &p),
                     STRATA_ERROR_INVALID_ARGUMENT);
}

static strata_result careless_prepare(void *state, const strata_view *view) {
    struct {
        strata_fragments known;
        uint64_t later;
    } fragments = {.known = {.struct_size = sizeof fragments, .layout = view->layout}, .later = 1};
    probe_creation(careless.gpu);
    assert_int_equal(view->publish_fragments(view->self, NULL), STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(view->publish_fragments(view->self, &fragments.known),
                     STRATA_ERROR_INVALID_ARGUMENT);
    fragments.later = 0;
    fragments.known.nearest = 5; /* beyond what this module's version has: not read */
    fragments.known.struct_size = offsetof(strata_fragments, nearest);
    assert_int_equal(view->publish_fragments(view->self, &fragments.known), STRATA_OK);
    const render_technique *t = view->self;
    assert_int_equal(t->session->fragments.nearest, 0);
    assert_int_equal(t->session->fragments.struct_size, sizeof(strata_fragments));
    careless.probed++;
    return careless.capture->prepare(state, view);
}

static void structs_of_techniques_are_checked(void **state) {
    (void)state;
    strata *s = open_null();
    strata_scene *sc = layers(s);
    strata_render_options captured = small;
    captured.use = "abuffer,ppc";
    assert_int_equal(strata_render(s, sc, &captured), STRATA_OK);
    render_technique *t = &s->session->techniques[0];
    while (strcmp(t->technique->stage, "capture") != 0)
        ++t;
    memset(&careless, 0, sizeof careless);
    careless.capture = t->technique;
    careless.table = *t->technique;
    careless.table.prepare = careless_prepare;
    careless.gpu = &t->gpu;
    t->technique = &careless.table;
    s->session->prepared = 0;
    strata_render(s, sc, &captured);
    assert_int_equal(careless.probed, 1);
    strata_close(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_image_outlives_its_scene),
        cmocka_unit_test(a_scene_of_another_instance_is_refused),
        cmocka_unit_test(unknown_options_are_refused),
        cmocka_unit_test(senseless_options_are_refused),
        cmocka_unit_test(what_is_learnt_is_in_the_usual_pace),
        cmocka_unit_test(the_pace_is_told_by_what_is_known),
        cmocka_unit_test(other_views_teach_nothing),
        cmocka_unit_test(what_is_culled_teaches_nothing),
        cmocka_unit_test(a_budget_begins_late),
        cmocka_unit_test(evidence_is_of_the_scene_as_it_is),
        cmocka_unit_test(every_render_may_lose_the_device),
        cmocka_unit_test(pools_of_opaque_techniques_grow),
        cmocka_unit_test(structs_of_techniques_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
