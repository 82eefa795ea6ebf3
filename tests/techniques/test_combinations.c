/* SPDX-License-Identifier: MIT
 *
 * Every combination that the slots allow renders, and is exact, within its certificate, or says
 * that it is uncertified: clip x (capture x resolve, or stream) x modes x samples, on both
 * backends. What is installed is read from the modules' notes; no technique is named here but the
 * reference's.
 *
 * Variants (plan/variants.h) are techniques with one knob set. Those of the knobs that decide what
 * is kept (mode, k) are crossed with each other, with every clip and with the filter; the others
 * stand alone.
 */
#include "techniques/picture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "plan/variants.h"
#include "render/render.h"

enum { MAX_TOLD = 64 };

static const char *const backends[] = {"vulkan", "gl"};
static const char *const payloads[] = {"float", "half", "unorm8"};
static const uint32_t sample_counts[] = {1, 4};

/* A frame as it is asked for. clip and resolve may be NULL. */
typedef struct combination {
    const modules_technique_note *clip;
    const plan_variant *capture; /* or stream */
    const plan_variant *resolve;
    uint32_t samples;
    char use[192], what[1024];
} combination;

typedef struct shown {
    picture color, bound;
} shown;

typedef struct tally {
    uint32_t exact, certified, uncertified, refused;
    char told[MAX_TOLD][256]; /* refusals, each once */
    uint32_t told_count;
} tally;

typedef struct bench {
    const test_scene *scene;
    const char *backend;
    strata *instance;
    strata_scene *sc;
    const modules *installed;
    shown (*references)[3]; /* [sample_counts][payloads], of the first backend */
    tally *counts;
} bench;

/* ---- rendering ------------------------------------------------------------------------------- */

static strata_result ignore_text(void *user, const char *bytes, size_t size) {
    (void)user, (void)bytes, (void)size;
    return STRATA_OK;
}

static picture read_output(strata *instance, uint32_t output, const test_scene *s) {
    picture p = {.width = s->width, .height = s->height};
    const size_t size = (size_t)s->width * s->height * 4 * sizeof(float);
    p.pixels = malloc(size);
    assert_non_null(p.pixels);
    if (strata_read(instance, output, p.pixels, size) != STRATA_OK)
        fail_msg("%s", strata_error(instance));
    return p;
}

static void free_shown(shown *s) {
    picture_free(&s->color);
    picture_free(&s->bound);
}

static strata_render_options options_of(const bench *b, const combination *c,
                                        const char *settings[2]) {
    uint32_t count = 0;
    if (c->capture->settings[0][0])
        settings[count++] = c->capture->settings[0];
    if (c->resolve && c->resolve->settings[0][0])
        settings[count++] = c->resolve->settings[0];
    return (strata_render_options){.struct_size = sizeof(strata_render_options),
                                   .width = b->scene->width,
                                   .height = b->scene->height,
                                   .outputs = STRATA_OUTPUT_BOUND,
                                   .use = c->use,
                                   .settings = settings,
                                   .setting_count = count,
                                   .samples = c->samples,
                                   .filter = "tent"};
}

static void describe(combination *c, const bench *b) {
    snprintf(c->use, sizeof c->use, "%s%s%s%s%s", c->clip ? c->clip->id : "", c->clip ? "," : "",
             c->capture->technique->id, c->resolve ? "," : "",
             c->resolve ? c->resolve->technique->id : "");
    snprintf(c->what, sizeof c->what, "%s on %s: %s %s %s, %u samples", b->scene->path, b->backend,
             c->use, c->capture->settings[0], c->resolve ? c->resolve->settings[0] : "",
             c->samples);
}

static void tell_refusal(bench *b, const combination *c) {
    tally *t = b->counts;
    char line[256];
    snprintf(line, sizeof line, "%.80s on %s: %.160s", c->use, b->backend,
             strata_error(b->instance));
    t->refused++;
    for (uint32_t i = 0; i < t->told_count; ++i)
        if (strcmp(t->told[i], line) == 0)
            return;
    if (t->told_count < MAX_TOLD)
        snprintf(t->told[t->told_count++], sizeof t->told[0], "%s", line);
}

/* 0: the plan refuses it, or this device has not what a knob was set to. What is planned must
 * render otherwise, and by the techniques asked for. */
static int render(bench *b, combination *c, shown *out) {
    const char *settings[2];
    describe(c, b);
    const strata_render_options options = options_of(b, c, settings);
    if (strata_plan(b->instance, b->sc, &options, ignore_text, NULL) != STRATA_OK) {
        tell_refusal(b, c);
        return 0;
    }
    const strata_result r = strata_render(b->instance, b->sc, &options);
    if (r == STRATA_ERROR_UNSUPPORTED && options.setting_count > 0) {
        tell_refusal(b, c);
        return 0;
    }
    if (r != STRATA_OK)
        fail_msg("%s: %s", c->what, strata_error(b->instance));
    assert_int_equal(b->instance->exclusion_count, 0);
    assert_non_null(plan_find(b->instance->session->plan, c->capture->technique->id));
    *out = (shown){.color = read_output(b->instance, STRATA_OUTPUT_COLOR, b->scene),
                   .bound = read_output(b->instance, STRATA_OUTPUT_BOUND, b->scene)};
    return 1;
}

/* ---- judging --------------------------------------------------------------------------------- */

static int same_bits(const picture *a, const picture *b) {
    return memcmp(a->pixels, b->pixels, (size_t)a->width * a->height * 4 * sizeof(float)) == 0;
}

/* Each channel lies within its certificate, that of the reference included. Returns how many pixels
 * say that they are uncertified. */
static uint32_t check_certificate(const shown *s, const shown *reference, const char *what) {
    uint32_t uncertified = 0;
    for (uint32_t i = 0; i < s->color.width * s->color.height; ++i) {
        int unknown = 0;
        for (uint32_t c = 4 * i; c < 4 * i + 4; ++c) {
            const double theirs = (double)reference->bound.pixels[c],
                         bound = (double)s->bound.pixels[c],
                         allowed = bound + (isinf(theirs) ? 0 : theirs),
                         error =
                             fabs((double)s->color.pixels[c] - (double)reference->color.pixels[c]);
            unknown |= isinf(bound);
            if (!(error <= allowed))
                fail_msg("%s: pixel (%u, %u), channel %u: error %g, certified %g", what,
                         i % s->color.width, i / s->color.width, c % 4, error, allowed);
        }
        uncertified += (uint32_t)unknown;
    }
    return uncertified;
}

/* The account has a bound exactly where every pixel has one. */
static void check_account(const bench *b, uint32_t uncertified, const char *what) {
    json_t *account = render_account_json(b->instance);
    assert_non_null(account);
    if (json_is_null(json_object_get(account, "bound")) != (uncertified > 0))
        fail_msg("%s: %u pixels are uncertified, and the account says otherwise", what,
                 uncertified);
    json_decref(account);
}

static void judge(bench *b, const combination *c, const shown *s) {
    const size_t samples = c->samples == 4;
    const shown *equal = &b->references[samples][c->capture->payload];
    const int same = same_bits(&s->color, &equal->color);
    if (c->capture->exact && (!c->resolve || c->resolve->exact) && !same)
        picture_same(&equal->color, &s->color, c->what);
    const uint32_t uncertified = check_certificate(s, &b->references[samples][0], c->what);
    check_account(b, uncertified, c->what);
    if (same)
        b->counts->exact++;
    else if (uncertified == 0)
        b->counts->certified++;
    else
        b->counts->uncertified++;
}

/* ---- enumerating ----------------------------------------------------------------------------- */

static plan_variant reference_capture(const bench *b, uint32_t payload) {
    plan_variant v = {.technique = modules_find_technique(b->installed, "abuffer"),
                      .payload = payload};
    snprintf(v.settings[0], sizeof v.settings[0], "abuffer.payload=%s", payloads[payload]);
    return v;
}

static void render_references(bench *b) {
    const plan_variant ppc = {.technique = modules_find_technique(b->installed, "ppc")};
    for (size_t s = 0; s < 2; ++s)
        for (uint32_t p = 0; p < 3; ++p) {
            const plan_variant abuffer = reference_capture(b, p);
            combination c = {.capture = &abuffer, .resolve = &ppc, .samples = sample_counts[s]};
            if (!b->references[s][p].color.pixels && !render(b, &c, &b->references[s][p]))
                fail_msg("%s: %s", c.what, strata_error(b->instance));
        }
}

/* Without a clip and with each; a clip only spares work: it leaves the picture as it is. */
static void with_clips(bench *b, const plan_variants *clips, combination c, int crossed) {
    shown plain = {0};
    if (!render(b, &c, &plain))
        return;
    judge(b, &c, &plain);
    const int orderly = c.capture->orderly && (!c.resolve || c.resolve->orderly);
    for (uint32_t i = 0; i < clips->count && crossed; ++i) {
        shown clipped = {0};
        if (clips->at[i].settings[0][0])
            continue;
        c.clip = clips->at[i].technique;
        if (!render(b, &c, &clipped))
            continue;
        judge(b, &c, &clipped);
        if (orderly)
            picture_same(&plain.color, &clipped.color, c.what);
        free_shown(&clipped);
    }
    free_shown(&plain);
}

static void with_samples(bench *b, const plan_variants *clips, const plan_variant *capture,
                         const plan_variant *resolve) {
    const int crossed = capture->crossed && (!resolve || resolve->crossed);
    for (size_t s = 0; s < (crossed ? 2u : 1u); ++s)
        with_clips(
            b, clips,
            (combination){.capture = capture, .resolve = resolve, .samples = sample_counts[s]},
            crossed);
}

static void collect(const bench *b, const char *stage, plan_variants *out) {
    base_error err = {0};
    if (plan_variants_collect(b->installed, stage, b->scene->depth, PLAN_BREADTH_EDGES, out,
                              &err) != STRATA_OK)
        fail_msg("%s", err.text);
}

static void every_combination(bench *b) {
    plan_variants clips = {0}, captures = {0}, resolves = {0}, streams = {0};
    collect(b, "clip", &clips);
    collect(b, "capture", &captures);
    collect(b, "resolve", &resolves);
    collect(b, "stream", &streams);
    for (uint32_t i = 0; i < captures.count; ++i)
        for (uint32_t k = 0; k < resolves.count; ++k)
            if (plan_variants_meet(&captures.at[i], &resolves.at[k], PLAN_BREADTH_EDGES))
                with_samples(b, &clips, &captures.at[i], &resolves.at[k]);
    for (uint32_t i = 0; i < streams.count; ++i)
        with_samples(b, &clips, &streams.at[i], NULL);
    free(clips.at);
    free(captures.at);
    free(resolves.at);
    free(streams.at);
}

static void combinations_render(void **state) {
    static tally counts;
    shown references[2][3];
    modules *installed = NULL;
    base_error err = {0};
    assert_int_equal(modules_scan(NULL, &installed, &err), STRATA_OK);
    counts = (tally){0};
    memset(references, 0, sizeof references);
    for (size_t i = 0; i < 2; ++i) {
        bench b = {.scene = *state,
                   .backend = backends[i],
                   .instance = picture_instance(backends[i]),
                   .installed = installed,
                   .references = references,
                   .counts = &counts};
        if (!b.instance)
            continue;
        b.sc = picture_scene(b.instance, b.scene->path);
        render_references(&b);
        every_combination(&b);
        strata_scene_close(b.sc);
    }
    for (uint32_t i = 0; i < counts.told_count; ++i)
        print_message("refused: %s\n", counts.told[i]);
    print_message("%u exact, %u certified, %u uncertified, %u refused\n", counts.exact,
                  counts.certified, counts.uncertified, counts.refused);
    for (size_t i = 0; i < 6; ++i)
        free_shown(&references[i / 3][i % 3]);
    modules_free(installed);
}

/* Opaque surfaces between, coloured transmission, coplanar layers. */
static const test_scene scenes[] = {
    {"scene:glass", 20, 15, 117},
    {"scene:stack?count=12", 12, 12, 12},
};

int main(void) {
    struct CMUnitTest tests[2];
    for (size_t i = 0; i < 2; ++i)
        tests[i] = (struct CMUnitTest){.name = scenes[i].path,
                                       .test_func = combinations_render,
                                       .initial_state = (void *)(uintptr_t)&scenes[i]};
    const int failed = cmocka_run_group_tests_name("combinations", tests, NULL, NULL);
    picture_close();
    return failed;
}
