/* SPDX-License-Identifier: MIT
 *
 * Folds of deep images; see deep.h.
 */
#include "techniques/deep.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/render.h"

deep_copy deep_of(const char *backend, strata *instance, strata_scene *sc, uint32_t width,
                  uint32_t height) {
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = width,
                                           .height = height,
                                           .use = "abuffer,ppc",
                                           .outputs = STRATA_OUTPUT_DEEP};
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s: %s", backend, strata_error(instance));
    const image_deep *deep = &instance->result.deep;
    deep_copy d = {.pixels = (size_t)width * height};
    d.count = malloc(d.pixels * sizeof *d.count);
    d.offset = malloc(d.pixels * sizeof *d.offset);
    d.color = malloc((deep->sample_count + 1) * 4 * sizeof *d.color);
    assert_true(d.count && d.offset && d.color);
    memcpy(d.count, deep->count, d.pixels * sizeof *d.count);
    memcpy(d.offset, deep->offset, d.pixels * sizeof *d.offset);
    memcpy(d.color, deep->color, deep->sample_count * 4 * sizeof *d.color);
    return d;
}

void deep_free(deep_copy *d) {
    free(d->count);
    free(d->offset);
    free(d->color);
}

void fold_nearest(const deep_copy *d, size_t pixel, uint32_t k, float out[4]) {
    float color[4] = {0, 0, 0, 0}, through = 1;
    for (uint32_t i = 0; i < d->count[pixel] && (k == 0 || i < k); ++i) {
        const float *sample = d->color + 4 * (d->offset[pixel] + i);
        for (int c = 0; c < 4; ++c)
            color[c] = color[c] + through * sample[c];
        through = through * (1.0f - sample[3]);
    }
    for (int c = 0; c < 4; ++c)
        out[c] = color[c] + through * (c < 3 ? 0.2f : 1.0f);
}

void deep_check_report(const strata *instance, const deep_copy *d, uint32_t k, const char *what) {
    const render_report *report = &instance->result.report;
    uint64_t total = 0, kept = 0;
    for (size_t i = 0; i < d->pixels; ++i) {
        total += d->count[i];
        kept += k && d->count[i] > k ? k : d->count[i];
    }
    if (report->total != total || report->kept != kept || report->dropped != total - kept)
        fail_msg("%s: reported %llu, %llu kept, %llu dropped; there are %llu, %llu to keep", what,
                 (unsigned long long)report->total, (unsigned long long)report->kept,
                 (unsigned long long)report->dropped, (unsigned long long)total,
                 (unsigned long long)kept);
}
