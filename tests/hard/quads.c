/* SPDX-License-Identifier: MIT
 *
 * From the scene straight to the picture, without a record of the renderer's: scenes of quads of
 * one colour and one depth each, seen along -z through the square -1..1, folded in double. So
 * whatever happens to a colour on its way into a payload is seen. See hard.h.
 */
#include "hard/hard.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct quad {
    double box[4], z, color[4]; /* left, bottom, right, top; straight */
} quad;

static int nearer(const void *a, const void *b) {
    const quad *left = a, *right = b;
    return (left->z < right->z) - (left->z > right->z);
}

/* Four vertices each, the first of the lower left and the third of the upper right corner. */
static quad *collect(const scene *s, size_t *count) {
    quad *quads = base_calloc(s->primitive_count / 2 + 1, sizeof *quads);
    assert_non_null(quads);
    *count = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_mesh *m = &s->meshes[s->instances[i].mesh];
        const float *factor = s->materials[m->material].base_color;
        assert_true(m->vertex_count % 4 == 0 && m->colors);
        for (size_t v = 0; v < m->vertex_count; v += 4) {
            quad *q = &quads[(*count)++];
            for (size_t k = 0; k < 4; k++) {
                q->box[k] = (double)m->positions[3 * (v + (k / 2) * 2) + k % 2];
                q->color[k] = (double)m->colors[4 * v + k] * (double)factor[k];
            }
            q->z = (double)m->positions[3 * v + 2];
        }
    }
    qsort(quads, *count, sizeof *quads, nearer);
    return quads;
}

/* The walk, and the sum of the sizes of its terms. */
static uint32_t fold(const quad *quads, size_t count, double x, double y, const float behind[4],
                     double color[4], double size[4]) {
    uint32_t met = 0;
    double through = 1;
    memset(color, 0, 4 * sizeof *color);
    memset(size, 0, 4 * sizeof *size);
    for (size_t i = 0; i <= count; i++) {
        const quad *q = i < count ? &quads[i] : NULL;
        if (q && !(x > q->box[0] && x < q->box[2] && y > q->box[1] && y < q->box[3]))
            continue;
        for (int c = 0; c < 4; c++) {
            const double light = !q      ? (double)behind[c]
                                 : c < 3 ? q->color[c] * q->color[3]
                                         : q->color[3];
            color[c] += through * light;
            size[c] += fabs(through * light);
        }
        through *= q ? 1 - q->color[3] : 1;
        met += q != NULL;
    }
    return met;
}

/* Of n fragments each brings 3 roundings to what lies behind, and 2 of its own product: the factor,
 * and alpha. What is denormal may be flushed to zero. */
void hard_quads(strata *instance, strata_scene *sc, const hard_row *row) {
    const float behind[4] = {0.125f, 0.25f, 0.5f, 1};
    const scene_hard_case *k = hard_case(row->name);
    strata_render_options options = {.width = k->width, .height = k->height, .has_background = 1};
    memcpy(options.background, behind, sizeof behind);
    picture p = hard_render(instance, sc, options);
    size_t count;
    quad *quads = collect(sc->scene, &count);
    for (uint32_t y = 0; y < k->height; y++)
        for (uint32_t x = 0; x < k->width; x++) {
            double color[4], size[4];
            const uint32_t met = fold(quads, count, (2 * x + 1.0) / k->width - 1,
                                      1 - (2 * y + 1.0) / k->height, behind, color, size);
            const float *seen = p.pixels + 4 * ((size_t)y * k->width + x);
            for (int c = 0; c < 4; c++) {
                const double bound =
                    oracle_gamma(3 * met + 3, ORACLE_UNIT) * size[c] + met * 0x1p-126;
                if (!(fabs((double)seen[c] - color[c]) <= bound))
                    fail_msg("%s on %s: pixel (%u, %u), channel %d, %u layers: %.9g, not %.9g +- "
                             "%.3g",
                             k->name, instance->backend, x, y, c, met, (double)seen[c], color[c],
                             bound);
            }
        }
    free(quads);
    picture_free(&p);
}
