/* SPDX-License-Identifier: MIT
 *
 * The renderer held to the fold oracle: every pixel's records, read back raw, must be well formed,
 * and folding them in double must give the rendered colour within the bound that fold.c derives; in
 * each layout and payload. Isolates sorting and compositing.
 */
#include "oracle/oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- records --------------------------------------------------------------------------------- */

/* Whether a number is that of a primitive that is drawn as transparent. */
static int is_transparent(const scene *s, uint32_t primitive) {
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_instance *instance = &s->instances[i];
        const scene_mesh *mesh = &s->meshes[instance->mesh];
        const uint32_t count =
            mesh->topology == SCENE_TRIANGLES ? mesh->index_count / 3 : mesh->vertex_count;
        if (primitive >= instance->primitive_base && primitive - instance->primitive_base < count)
            return instance->visible && oracle_transparent(&s->materials[mesh->material]);
    }
    return 0;
}

/* Sorted records of one pixel: a strict order, keys and numbers in their ranges, nothing behind the
 * opaque surface. */
static void check_records(const oracle_capture *c, size_t pixel, const oracle_record *sorted,
                          size_t count) {
    for (size_t i = 0; i < count; i++) {
        const oracle_record *r = &sorted[i];
        if (r->key > 0x3f800000u)
            fail_msg("pixel %zu: key %08x is beyond the far plane's", pixel, r->key);
        if (!is_transparent(c->scene, oracle_primitive(r)))
            fail_msg("pixel %zu: order %08x is of no transparent primitive", pixel, r->order);
        if (i && r->key == r[-1].key && r->order == r[-1].order)
            fail_msg("pixel %zu: two records have key %08x, order %08x", pixel, r->key, r->order);
        if (oracle_depth(r) < c->depth[pixel])
            fail_msg("pixel %zu: depth %.9g lies behind the opaque %.9g", pixel,
                     (double)oracle_depth(r), (double)c->depth[pixel]);
    }
}

/* ---- colours --------------------------------------------------------------------------------- */

typedef struct tally {
    double worst;  /* error over bound */
    double *slack; /* bound over error, of channels whose error is not zero */
    size_t slack_count;
    uint64_t several;       /* pixels with two records or more */
    uint64_t lost, swapped; /* of them, where a lost record or a swap would be seen */
} tally;

static int beyond(const oracle_value want[4], const float *have) {
    for (int i = 0; i < 4; i++)
        if (!(fabs((double)have[i] - want[i].value) <= want[i].error))
            return 1;
    return 0;
}

/* The oracle must see what it is for: a missing record, and two neighbours in the wrong order. */
static void check_power(const oracle_capture *c, oracle_record *sorted, size_t count,
                        const float *behind, const float *have, tally *t) {
    oracle_value want[4];
    oracle_fold(c->plan, sorted + 1, count - 1, behind, want);
    t->lost += (uint64_t)beyond(want, have);
    const oracle_record kept = sorted[0];
    sorted[0] = sorted[1];
    sorted[1] = kept;
    oracle_fold(c->plan, sorted, count, behind, want);
    t->swapped += (uint64_t)beyond(want, have);
    t->several++;
}

static void check_pixel(const oracle_capture *c, size_t pixel, oracle_record *records, size_t count,
                        tally *t) {
    const float *have = c->color + 4 * pixel, *behind = c->behind + 4 * pixel;
    oracle_value want[4];
    long double backwards[4];
    if (count == 0) {
        assert_memory_equal(have, behind, 4 * sizeof *have);
        return;
    }
    oracle_sort(records, count);
    check_records(c, pixel, records, count);
    oracle_fold(c->plan, records, count, behind, want);
    oracle_fold_backwards(c->plan, records, count, behind, backwards);
    for (int i = 0; i < 4; i++) {
        const double error = fabs((double)have[i] - want[i].value);
        /* double errs as float does, 2^29 times less; the oracle may not need its own mercy */
        const double own = (double)fabsl(backwards[i] - (long double)want[i].value);
        if (!(own <= want[i].error * 0x1p-28))
            fail_msg("pixel %zu, channel %d: the oracle is off by %g", pixel, i, own);
        if (!(error <= want[i].error))
            fail_msg("pixel %zu (%zu, %zu), channel %d, %zu records: %.9g is not %.9g +- %.3g",
                     pixel, pixel % c->width, pixel / c->width, i, count, (double)have[i],
                     want[i].value, want[i].error);
        if (error > 0) {
            t->slack[t->slack_count++] = want[i].error / error;
            t->worst = fmax(t->worst, error / want[i].error);
        }
    }
    if (count >= 2)
        check_power(c, records, count, behind, have, t);
}

static int ascending(const void *a, const void *b) {
    const double left = *(const double *)a, right = *(const double *)b;
    return left < right ? -1 : left > right;
}

/* Pixels without any surface show the background, whatever was drawn elsewhere. */
static void check_background(const oracle_capture *c) {
    for (size_t p = 0; p < (size_t)c->width * c->height; p++)
        if (c->depth[p] == 0.0f)
            assert_memory_equal(c->behind + 4 * p, c->background, sizeof c->background);
}

static void check_frame(const oracle_case *k, const oracle_capture *c) {
    const size_t pixels = (size_t)c->width * c->height;
    tally t = {.slack = base_calloc(pixels * 4, sizeof *t.slack)};
    size_t deepest = 0;
    assert_non_null(t.slack);
    check_background(c);
    for (size_t p = 0; p < pixels; p++) {
        const size_t count = c->first[p + 1] - c->first[p];
        deepest = count > deepest ? count : deepest;
        check_pixel(c, p, c->records + c->first[p], count, &t);
    }
    qsort(t.slack, t.slack_count, sizeof *t.slack, ascending);
    print_message("  %-58s %s%s%zu records, at most %zu; error <= %.2f bound, median bound/error "
                  "%.1f; a loss seen in %.1f %%, a swap in %.1f %%\n",
                  k->scene, k->setting[0] ? k->setting[0] : "", k->setting[0] ? ", " : "",
                  c->record_count, deepest, t.worst,
                  t.slack_count ? t.slack[t.slack_count / 2] : 0.0,
                  t.several ? 100.0 * (double)t.lost / (double)t.several : 100.0,
                  t.several ? 100.0 * (double)t.swapped / (double)t.several : 100.0);
    assert_true(t.lost * 100 >= t.several * 95);
    /* thousands of faint layers may err by more than one swap changes */
    assert_true(deepest > 128 || t.swapped * 100 >= t.several * 60);
    free(t.slack);
}

static void fold_all(void **state, const oracle_case *cases, size_t count) {
    strata *s = oracle_open(state);
    if (!s)
        skip();
    for (size_t i = 0; i < count; i++) {
        strata_scene *sc = oracle_scene(s, cases[i].scene);
        oracle_capture c;
        oracle_capture_frame(s, sc, &cases[i], &c);
        check_frame(&cases[i], &c);
        oracle_capture_free(&c);
        strata_scene_close(sc);
    }
    strata_close(s);
}

/* ---- cases ----------------------------------------------------------------------------------- */

#define LINKED "abuffer.mode=linked"
#define HALF   "abuffer.payload=half"
#define UNORM8 "abuffer.payload=unorm8"

static void test_scenes(void **state) {
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:soup?small=1500&medium=150&depth=14", 80, 64)},
        {ORACLE_FRAME("scene:shells?count=5&subdivision=2", 72, 72)},
        {ORACLE_FRAME("scene:particles?count=600&radius=0.08", 64, 64)},
        {ORACLE_FRAME("scene:glass?detail=1&smoke=300", 80, 60)},
        {ORACLE_FRAME("own:crossing", 64, 64)},
        {ORACLE_FRAME("own:opaque", 32, 32)},
    };
    fold_all(state, cases, BASE_COUNT(cases));
}

/* At every edge between the classes that a resolve may sort pixels into, and far beyond. */
static void test_depths(void **state) {
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:layers?count=1&width=24&height=16", 24, 16)},
        {ORACLE_FRAME("scene:layers?count=2&width=24&height=16", 24, 16)},
        {ORACLE_FRAME("scene:layers?count=32&where=pixel&width=24&height=16", 24, 16)}, /* else 0 */
        {ORACLE_FRAME("scene:layers?count=33&width=24&height=16", 24, 16)},
        {ORACLE_FRAME("scene:layers?count=64&width=24&height=16&alpha=0.05", 24, 16)},
        {ORACLE_FRAME("scene:layers?count=65&width=24&height=16&alpha=0.05", 24, 16)},
        {ORACLE_FRAME("scene:layers?count=1500&width=16&height=12&alpha=0.004&opaque=1", 16, 12)},
        {ORACLE_FRAME("scene:layers?count=1500&width=16&height=12&alpha=0.5&order=far", 16, 12)},
    };
    fold_all(state, cases, BASE_COUNT(cases));
}

/* The order numbers alone decide. */
static void test_ties(void **state) {
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:stack?count=2", 48, 48)},
        {ORACLE_FRAME("scene:stack?count=3&opaque=1", 48, 48)},
        {ORACLE_FRAME("scene:stack?count=100&alpha=0.05", 48, 48)},
        {ORACLE_FRAME("own:ties", 64, 64)},
    };
    fold_all(state, cases, BASE_COUNT(cases));
}

static void test_linked(void **state) {
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:soup?small=1500&medium=150&depth=14", 80, 64), .setting = {LINKED}},
        {ORACLE_FRAME("scene:stack?count=100&alpha=0.05", 48, 48), .setting = {LINKED}},
        {ORACLE_FRAME("scene:layers?count=65&width=24&height=16&alpha=0.05", 24, 16),
         .setting = {LINKED}},
    };
    fold_all(state, cases, BASE_COUNT(cases));
}

static void test_payloads(void **state) {
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:shells?count=5&subdivision=2", 72, 72), .setting = {HALF}},
        {ORACLE_FRAME("scene:shells?count=5&subdivision=2", 72, 72), .setting = {UNORM8}},
        {ORACLE_FRAME("scene:glass?detail=1&smoke=300", 80, 60), .setting = {HALF}},
        {ORACLE_FRAME("scene:glass?detail=1&smoke=300", 80, 60), .setting = {UNORM8, LINKED}},
    };
    fold_all(state, cases, BASE_COUNT(cases));
}

/* ---- what a narrower payload loses ----------------------------------------------------------- */

/* Half an ulp of a half at `value`; halves end at 65504 and have 2^-24 as their least step. */
static double half_error(double value) {
    int exponent = 0;
    frexp(value, &exponent);
    return ldexp(1.0, (exponent < -13 ? -13 : exponent) - 12);
}

static void check_narrow(double exact, double narrow, int bits) {
    const double most = bits == 16 ? 65504.0 : 1.0, least = bits == 16 ? -65504.0 : 0.0;
    const double clamped = fmin(fmax(exact, least), most);
    /* encoding to 8 bits rounds twice in float before it rounds to the code */
    const double error = bits == 16 ? half_error(clamped) : 0.5 / 255.0 + 2 * ORACLE_UNIT;
    if (!(fabs(narrow - clamped) <= error))
        fail_msg("%.9g became %.9g in %d bits, further than %.3g", exact, narrow, bits, error);
}

/* The same records, narrower: same pixels, keys and numbers, each channel rounded correctly. */
static void compare_payloads(const oracle_capture *wide, const oracle_capture *narrow, int bits) {
    static const char *const fields[] = {"color", "glow", "through", "id"};
    const size_t pixels = (size_t)wide->width * wide->height;
    uint64_t compared = 0;
    assert_int_equal(wide->record_count, narrow->record_count);
    assert_memory_equal(wide->first, narrow->first, (pixels + 1) * sizeof *wide->first);
    for (size_t p = 0; p < pixels; p++) {
        oracle_sort(wide->records + wide->first[p], wide->first[p + 1] - wide->first[p]);
        oracle_sort(narrow->records + wide->first[p], wide->first[p + 1] - wide->first[p]);
    }
    for (size_t i = 0; i < wide->record_count; i++) {
        const oracle_record *a = &wide->records[i], *b = &narrow->records[i];
        assert_int_equal(a->key, b->key);
        assert_int_equal(a->order, b->order);
        for (size_t f = 0; f < BASE_COUNT(fields); f++)
            for (uint32_t c = 0; c < 4; c++) {
                int rounded = 0;
                const double x = oracle_payload(&wide->plan->payload, a, fields[f], c, &rounded);
                const double y = oracle_payload(&narrow->plan->payload, b, fields[f], c, &rounded);
                assert_int_equal(isnan(x), isnan(y));
                if (f == 3 && !isnan(x))
                    assert_true(x == y);
                else if (!isnan(x))
                    check_narrow(x, y, bits);
                compared += isnan(x) ? 0 : 1;
            }
    }
    assert_true(compared > 1000);
}

static void test_narrowing(void **state) {
    static const char *const scenes[] = {"scene:shells?count=5&subdivision=2", "own:bright"};
    strata *s = oracle_open(state), *other = oracle_open(state);
    if (!s || !other)
        skip();
    for (size_t i = 0; i < BASE_COUNT(scenes); i++) {
        strata_scene *sc = oracle_scene(s, scenes[i]), *same = oracle_scene(other, scenes[i]);
        oracle_capture wide, narrow;
        oracle_case c = {ORACLE_FRAME(scenes[i], 64, 64)};
        oracle_capture_frame(s, sc, &c, &wide);
        for (int bits = 16; bits >= 8; bits -= 8) {
            c.setting[0] = bits == 16 ? HALF : UNORM8;
            oracle_capture_frame(other, same, &c, &narrow);
            compare_payloads(&wide, &narrow, bits);
            oracle_capture_free(&narrow);
        }
        oracle_capture_free(&wide);
        strata_scene_close(sc);
        strata_scene_close(same);
    }
    strata_close(s);
    strata_close(other);
}

/* ---- the oracle itself ----------------------------------------------------------------------- */

static const plan_payload packed = {
    .field_count = 2,
    .fields = {{.name = "half", .channels = 2, .at = {{0, 0, 0, 0, 16}, {0, 0, 0, 16, 16}}},
               {.name = "unorm", .channels = 2, .at = {{1, 0, 1, 8, 8}, {1, 0, 1, 24, 8}}}}};

static void test_decoding(void **state) {
    (void)state;
    const oracle_record r = {.words = {0x7bff8001u, 0xff003300u}};
    int rounded = 0;
    assert_true(oracle_payload(&packed, &r, "half", 0, &rounded) == -0x1p-24);
    assert_true(oracle_payload(&packed, &r, "half", 1, &rounded) == 65504.0);
    assert_int_equal(rounded, 0);
    assert_true(oracle_payload(&packed, &r, "unorm", 0, &rounded) == 0.2);
    assert_true(oracle_payload(&packed, &r, "unorm", 1, &rounded) == 1.0);
    assert_int_equal(rounded, 2);
    assert_true(isnan(oracle_payload(&packed, &r, "unorm", 2, &rounded)));
    assert_true(isnan(oracle_payload(&packed, &r, "other", 0, &rounded)));
}

/* The bound of a plain walk is of the size that its derivation says. */
static void test_bound(void **state) {
    (void)state;
    enum { COUNT = 200 };
    static const modules_effect_note note = {.id = "over"};
    plan_effect effect = {.effect = &note, .active = 1};
    plan p = {
        .effects = &effect, .effect_count = 1, .active_effects = 1, .transmittance_channels = 1};
    p.payload = (plan_payload){.field_count = 1, .fields = {{.name = "color", .channels = 4}}};
    for (uint32_t c = 0; c < 4; c++)
        p.payload.fields[0].at[c] = (plan_channel){c, c / 2, c % 2, 0, 32};
    static oracle_record records[COUNT];
    const float color[4] = {0.01f, 0.005f, 0.0f, 0.02f}, behind[4] = {1, 1, 1, 1};
    for (int i = 0; i < COUNT; i++)
        memcpy(records[i].words, color, sizeof color);
    oracle_value out[4];
    oracle_fold(&p, records, COUNT, behind, out);
    for (int c = 0; c < 4; c++) {
        const double left = pow(1.0 - (double)color[3], COUNT);
        const double want = (double)color[c] * (1.0 - left) / (double)color[3] + left;
        assert_true(fabs(out[c].value - want) < 1e-13);
        assert_true(out[c].error <= oracle_gamma(2 * COUNT + 2, ORACLE_UNIT) * want * 1.000001);
        assert_true(out[c].error >= oracle_gamma(20, ORACLE_UNIT) * want);
    }
}

#define ON_EACH(test)                                                                              \
    {#test "_vulkan", test, NULL, NULL, "vulkan"}, {                                               \
#test "_gl", test, NULL, NULL, "gl"                                                        \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_decoding),
        cmocka_unit_test(test_bound),
        ON_EACH(test_scenes),
        ON_EACH(test_depths),
        ON_EACH(test_ties),
        ON_EACH(test_linked),
        ON_EACH(test_payloads),
        ON_EACH(test_narrowing),
    };
    return cmocka_run_group_tests_name("oracle_fold", tests, NULL, NULL);
}
