/* SPDX-License-Identifier: MIT
 *
 * Certificates held to their word: a frame's exact picture by the fold oracle, and every channel's
 * error against the bound that came with it. See oracle.h.
 */
#include "oracle/oracle.h"

#include <math.h>
#include <stdlib.h>

oracle_exact oracle_exact_make(strata *s, strata_scene *sc, const oracle_case *k) {
    oracle_capture c;
    oracle_capture_frame(s, sc, k, &c);
    const size_t pixels = (size_t)c.width * c.height;
    oracle_exact out = {.channels = pixels * 4,
                        .color = base_calloc(pixels * 4, sizeof *out.color),
                        .count = base_calloc(pixels, sizeof *out.count)};
    assert_true(out.color && out.count);
    for (size_t p = 0; p < pixels; p++) {
        oracle_value value[4];
        oracle_sort(c.records + c.first[p], out.count[p] = c.first[p + 1] - c.first[p]);
        if (c.plan->transparent)
            oracle_fold(c.plan, c.records + c.first[p], out.count[p], c.behind + 4 * p, value);
        for (int i = 0; i < 4; i++)
            out.color[4 * p + (size_t)i] =
                c.plan->transparent ? value[i].value : (double)c.behind[4 * p + (size_t)i];
    }
    oracle_capture_free(&c);
    return out;
}

void oracle_exact_free(oracle_exact *e) {
    free(e->color);
    free(e->count);
}

static int ascending(const void *a, const void *b) {
    const double left = *(const double *)a, right = *(const double *)b;
    return left < right ? -1 : left > right;
}

void oracle_certify(strata *s, strata_scene *sc, const oracle_case *k, const char *use,
                    const char *const settings[3], uint32_t bands) {
    strata_render_options options = {.struct_size = sizeof options,
                                     .width = k->width,
                                     .height = k->height,
                                     .use = use,
                                     .camera = k->camera,
                                     .settings = settings,
                                     .bands = bands,
                                     .outputs = STRATA_OUTPUT_BOUND,
                                     .background = {0.1f, 0.2f, 0.4f, 1.0f},
                                     .has_background = 1};
    while (options.setting_count < 3 && settings[options.setting_count])
        options.setting_count++;
    if (strata_render(s, sc, &options) != STRATA_OK)
        fail_msg("%s, %s: %s", k->scene, use, strata_error(s));
}

oracle_tally oracle_hold(const strata *s, const oracle_exact *e, const char *what) {
    const float *color = s->result.color.pixels, *bound = s->result.bound.map.pixels;
    oracle_tally t = {.slack = base_calloc(e->channels, sizeof *t.slack)};
    assert_non_null(t.slack);
    for (size_t i = 0; i < e->channels; i++) {
        const double error = fabs((double)color[i] - e->color[i]), b = (double)bound[i];
        if (isinf(b)) {
            t.uncertified++;
            continue;
        }
        t.certified++;
        if (!(error <= b))
            fail_msg("%s: channel %zu of pixel %zu, %zu fragments: %.9g is %.3g off %.9g, the "
                     "certificate says %.3g",
                     what, i % 4, i / 4, e->count[i / 4], (double)color[i], error, e->color[i], b);
        if (e->count[i / 4] == 0)
            assert_true(b == 0);
        t.largest = fmax(t.largest, b);
        if (error > 0) {
            t.slack[t.slack_count++] = b / error;
            t.worst = fmax(t.worst, error / b);
        }
    }
    qsort(t.slack, t.slack_count, sizeof *t.slack, ascending);
    return t;
}

void oracle_tally_free(oracle_tally *t) {
    free(t->slack);
    t->slack = NULL;
}
