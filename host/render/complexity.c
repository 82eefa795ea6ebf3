/* SPDX-License-Identifier: MIT
 *
 * Depth complexity of the last deep image: how many fragments pixels hold, and how many of the
 * nearest would do for an error of 1/255. For the account.
 */
#include "render/render.h"

#include <math.h>
#include <stdlib.h>

#define ENOUGH (1.0 / 255)

/* pixels[n]: pixels of n fragments. */
typedef struct histogram {
    uint64_t *pixels;
    uint32_t size;
} histogram;

/* One sample's colour and what it lets through, of each channel. */
static void sample_at(const image_deep *deep, uint64_t i, double color[4], double through[4]) {
    for (int c = 0; c < 4; ++c) {
        color[c] = (double)deep->color[4 * i + (uint64_t)c];
        through[c] = 1 - (double)deep->color[4 * i + 3];
        if (deep->color_alpha && c < 3)
            through[c] = 1 - (double)deep->color_alpha[3 * i + (uint64_t)c];
    }
}

/* How many of the nearest fragments do, with what lies behind all of them in the place of the
 * others, for no channel to be off by more than ENOUGH; nor with any more. room: [fragments +
 * 1][4].
 */
static uint32_t needed(const image_deep *deep, uint64_t first, uint32_t fragments,
                       const float *behind, double *room) {
    double shown[4] = {0}, left[4] = {1, 1, 1, 1};
    for (uint32_t i = 0; i <= fragments; ++i) {
        double color[4], through[4];
        for (int c = 0; c < 4; ++c)
            room[4 * (size_t)i + (size_t)c] = shown[c] + left[c] * (double)behind[c];
        if (i == fragments)
            break;
        sample_at(deep, first + i, color, through);
        for (int c = 0; c < 4; ++c) {
            shown[c] += left[c] * color[c];
            left[c] *= through[c];
        }
    }
    uint32_t k = fragments;
    for (; k > 0; --k) {
        double error = 0;
        for (size_t c = 0; c < 4; ++c)
            error =
                fmax(error, fabs(room[4 * (size_t)(k - 1) + c] - room[4 * (size_t)fragments + c]));
        if (!(error <= ENOUGH))
            break;
    }
    return k;
}

static int is_opaque(const image_deep *deep, uint64_t i) {
    double color[4], through[4];
    sample_at(deep, i, color, through);
    return through[0] <= 0 && through[1] <= 0 && through[2] <= 0;
}

/* [[n, pixels], ..], n ascending, without those of no pixel. */
static json_t *pairs(const histogram *h) {
    json_t *list = json_array();
    for (uint32_t n = 0; n < h->size; ++n)
        if (h->pixels[n])
            json_array_append_new(list,
                                  json_pack("[I,I]", (json_int_t)n, (json_int_t)h->pixels[n]));
    return list;
}

static uint32_t largest_count(const image_deep *deep) {
    uint32_t largest = 0;
    for (size_t p = 0; p < (size_t)deep->width * deep->height; ++p)
        largest = deep->count[p] > largest ? deep->count[p] : largest;
    return largest;
}

json_t *render_complexity_json(const strata *s) {
    const image_deep *deep = &s->result.deep;
    const float *behind = s->result.deep_build.opaque;
    const float *depth = s->result.has_depth ? s->result.depth.pixels : NULL;
    if (!s->result.valid || !s->result.has_deep)
        return json_null();
    const uint32_t size = largest_count(deep) + 1;
    histogram held = {base_calloc(size, sizeof(uint64_t)), size},
              needs = {base_calloc(size, sizeof(uint64_t)), size};
    double *room = base_calloc((size_t)size + 1, 4 * sizeof *room);
    json_t *out = NULL;
    for (size_t p = 0;
         held.pixels && needs.pixels && room && p < (size_t)deep->width * deep->height; ++p) {
        uint32_t fragments = deep->count[p];
        const uint64_t last = deep->offset[p] + fragments - 1;
        /* An opaque surface is the last sample; a fragment that hides all can only look like one
         * where the depth of surfaces was not asked for. */
        const int opaque =
            fragments > 0 && (depth ? isfinite(depth[4 * p]) : is_opaque(deep, last));
        fragments -= (uint32_t)opaque;
        held.pixels[fragments]++;
        needs.pixels[needed(deep, deep->offset[p], fragments, behind + 4 * p, room)]++;
    }
    if (held.pixels && needs.pixels && room)
        out = json_pack("{s:o, s:f, s:o}", "held", pairs(&held), "enough", ENOUGH, "needed",
                        pairs(&needs));
    free(held.pixels);
    free(needs.pixels);
    free(room);
    return out ? out : json_null();
}
