/* SPDX-License-Identifier: MIT
 *
 * The table of hard cases, and what single rows ask for beyond the flags. See hard.h.
 */
#include "hard/hard.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- what single rows ask for -----------------------------------------------------------------
 */

static strata_render_options sized(const picture *p) {
    return (strata_render_options){
        .struct_size = sizeof(strata_render_options), .width = p->width, .height = p->height};
}

/* Layers that cover nothing leave the background's bits. */
static void shows_background(strata *instance, strata_scene *sc, const hard_row *row) {
    const float behind[4] = {0.1f, 0.2f, 0.4f, 1};
    hard_quads(instance, sc, row);
    strata_render_options options = sized(&(picture){16, 16, NULL});
    memcpy(options.background, behind, sizeof behind);
    options.has_background = 1;
    picture p = hard_render(instance, sc, options);
    for (size_t i = 0; i < (size_t)16 * 16; i++)
        if (memcmp(p.pixels + 4 * i, behind, sizeof behind) != 0)
            fail_msg("%s: pixel %zu is not the background", row->name, i);
    picture_free(&p);
}

/* Layers that cover everything are what the same layers are when they are drawn as opaque. */
static void equals_opaque(strata *instance, strata_scene *sc, const hard_row *row) {
    hard_quads(instance, sc, row);
    strata_render_options options = sized(&(picture){16, 16, NULL});
    picture blended = hard_render(instance, sc, options);
    strata_scene *solid = hard_scene(instance, row->name);
    for (uint32_t i = 0; i < solid->scene->material_count; i++)
        solid->scene->materials[i].alpha = SCENE_OPAQUE;
    options.use = "surface";
    picture opaque = hard_render(instance, solid, options);
    picture_same(&blended, &opaque, row->name);
    strata_scene_close(solid);
    picture_free(&blended);
    picture_free(&opaque);
}

/* The picture on nothing, put on a background, is the picture on that background: colours are
 * premultiplied. Both are right to within their certificates, the composition rounds three times.
 */
static void premultiplied(strata *instance, strata_scene *sc, const hard_row *row) {
    const float on[4] = {0.25f, 0.75f, 0.5f, 1};
    strata_render_options options = sized(&(picture){32, 32, NULL});
    options.has_background = 1;
    picture bare = hard_render(instance, sc, options);
    memcpy(options.background, on, sizeof on);
    picture full = hard_render(instance, sc, options);
    const double bound =
        oracle_gamma(3 * 3 + 3, ORACLE_UNIT) * 2; /* of colours up to 1, 2 layers */
    for (size_t i = 0; i < (size_t)32 * 32 * 4; i++) {
        const double through = 1 - (double)bare.pixels[i / 4 * 4 + 3];
        const double whole = (double)bare.pixels[i] + through * (double)on[i % 4];
        if (fabs(whole - (double)full.pixels[i]) > bound)
            fail_msg("%s: pixel %zu: %.9g put on the background is %.9g, not %.9g", row->name,
                     i / 4, (double)bare.pixels[i], whole, (double)full.pixels[i]);
    }
    picture_free(&bare);
    picture_free(&full);
}

/* Both greys are 188 of 255 in sRGB; half of white over black is 1/2, which is 188 as well. */
static void linear_light(strata *instance, strata_scene *sc, const hard_row *row) {
    strata_render_options options = sized(&(picture){32, 32, NULL});
    picture p = hard_render(instance, sc, options);
    for (size_t i = 0; i < (size_t)32 * 32 * 4; i++) {
        const double value = (double)p.pixels[i];
        const int column = (int)(i / 4 % 32) / 8, channel = (int)(i % 4);
        const double coded = 255 * (1.055 * pow(value, 1 / 2.4) - 0.055);
        if (channel == 3 || column >= 2 ? value != (channel == 3 ? 1 : 0.5)
                                        : floor(coded + 0.5) != 188)
            fail_msg("%s: column %d, channel %d: %.9g", row->name, column, channel, value);
    }
    picture_free(&p);
}

/* So many bands are made, and no more. */
static void fits_at_once(strata *instance, strata_scene *sc, const hard_row *row) {
    picture p = hard_render(instance, sc, sized(&(picture){512, 512, NULL}));
    const uint32_t expected = row->fragments > 1 << 24 ? 2 : 1;
    if (picture_fact(instance, "limit.storage_range") == 1u << 27 &&
        instance->result.bands != expected)
        fail_msg("%s on %s: %u bands, not %u", row->name, instance->backend, instance->result.bands,
                 expected);
    picture_free(&p);
}

/* ---- the table --------------------------------------------------------------------------------
 */

/* Where an invariance is left out README.md says why. */
#define FLAT (HARD_SPLIT | HARD_TRANSLATE | HARD_ROTATE | HARD_FOLD | HARD_FILE)
#define DEEP (HARD_SPLIT | HARD_FOLD)

#define EACH(n, side) .depth = (n), .fragments = (int64_t)(n) * (side) * (side)

const hard_row hard_rows[] = {
    /* geometry */
    {"coplanar-2", FLAT | HARD_RAY, .depth = 2, .fragments = HARD_ANY, .orders = 6,
     .kills = "the order at equal depth is lost"},
    {"coplanar-3", FLAT | HARD_RAY, .depth = 3, .fragments = HARD_ANY, .orders = 12,
     .kills = "at equal depth the earlier primitive lies in front"},
    {"coplanar-100", FLAT | HARD_RAY, .depth = 100, .fragments = HARD_ANY, .orders = 8,
     .kills = "runs are merged by depth alone"},
    {"crossing", HARD_ALL & ~(unsigned)HARD_ROTATE, HARD_ANY, HARD_ANY, .orders = 4,
     .kills = "all records have one depth"},
    {"slivers", HARD_ALL & ~(unsigned)HARD_ROTATE, HARD_ANY, HARD_ANY,
     .kills = "corners are rounded to coarse steps"},
    {"near-plane", HARD_ALL & ~(unsigned)HARD_ROTATE, HARD_ANY, HARD_ANY,
     .kills = "corners behind the eye are thrown away"},
    {"huge", HARD_SPLIT | HARD_FOLD | HARD_FILE | HARD_RAY, HARD_ANY, HARD_ANY,
     .kills = "large coordinates are cut off"},
    {"tiny", HARD_SPLIT | HARD_FOLD | HARD_FILE | HARD_RAY, HARD_ANY, HARD_ANY,
     .kills = "small coordinates are rounded to zero"},
    {"depth-range", HARD_SPLIT | HARD_FOLD | HARD_FILE | HARD_RAY, HARD_ANY, HARD_ANY,
     .kills = "depth is rounded to 16 bits"},
    {"not-a-number", HARD_REFUSED, .kills = "positions may be NaN"},
    {"infinite", HARD_REFUSED, .kills = "positions may be infinite"},
    {"shared-edges", HARD_ALL & ~(unsigned)HARD_ROTATE, EACH(3, 32),
     .kills = "one corner of two triangles is projected to two places"},
    {"dust", (HARD_ALL & ~(unsigned)HARD_ROTATE), HARD_ANY, HARD_ANY,
     .kills = "primitive numbers have 14 bits"},
    {"screen", HARD_ALL, EACH(3, 48), .kills = "the last column is not counted"},
    {"layers-0", HARD_FOLD | HARD_FILE, EACH(0, 16), .also = shows_background,
     .kills = "pixels without fragments are black"},
    {"layers-1", FLAT | HARD_RAY, EACH(1, 16), .also = hard_quads,
     .kills = "pixels of one fragment have no class"},
    {"layers-2", FLAT | HARD_RAY, EACH(2, 16), .also = hard_quads,
     .kills = "slots do not follow their keys"},
    {"layers-32", FLAT | HARD_RAY, EACH(32, 16), .also = hard_quads,
     .kills = "the network of 32 leaves out exchanges"},
    {"layers-33", FLAT | HARD_RAY, EACH(33, 16), .also = hard_quads,
     .kills = "a pixel of 33 goes to the network of 32"},
    {"layers-64", FLAT | HARD_RAY, EACH(64, 16), .also = hard_quads,
     .kills = "the network of 64 leaves out exchanges"},
    {"layers-65", FLAT | HARD_RAY, EACH(65, 16), .also = hard_quads,
     .kills = "a pixel of 65 goes to the network of 64"},
    {"layers-254", FLAT, EACH(254, 8), .also = hard_quads, .kills = "the stencil has a layer less"},
    {"layers-256", FLAT, EACH(256, 8), .also = hard_quads, .kills = "counts wrap at 256"},
    {"layers-1500", DEEP | HARD_FILE, .depth = 1500, .fragments = 1500, .also = hard_quads,
     .kills = "of a pixel's list 1,024 are sorted"},
    {"layers-20000", DEEP | HARD_LARGE, .depth = 20000, .fragments = 20000, .also = hard_quads,
     .kills = "counts have 14 bits"},
    {"pixel-100000", DEEP | HARD_LARGE, .depth = 100000, .fragments = 100000, .also = hard_quads,
     .kills = "one invocation walks 100,000 fragments"},
    /* colour */
    {"alpha-0", FLAT | HARD_RAY, EACH(8, 16), .also = shows_background,
     .kills = "colours are not premultiplied"},
    {"alpha-1", FLAT | HARD_RAY, EACH(8, 16), .also = equals_opaque,
     .kills = "alpha stays below 1"},
    {"alpha-next-to-1", FLAT | HARD_RAY, EACH(3, 16), .also = hard_quads,
     .kills = "what is nearly opaque is opaque"},
    {"alpha-512th", FLAT, EACH(200, 16), .also = hard_quads,
     .kills = "unorm8: a quantum of what was stored, not of 1"},
    {"alpha-millionth", DEEP | HARD_LARGE, .depth = 10000, .fragments = 10000, .also = hard_quads,
     .kills = "faint fragments cover nothing"},
    {"alpha-denormal", FLAT | HARD_RAY, EACH(8, 16), .also = hard_quads,
     .kills = "a fragment of hardly any alpha does not exist"},
    {"hdr-65504", FLAT | HARD_RAY, .depth = 8, .fragments = HARD_ANY, .also = hard_quads,
     .kills = "colours are cut off at 1,000"},
    {"hdr-million", FLAT | HARD_RAY, .depth = 8, .fragments = HARD_ANY, .also = hard_quads,
     .kills = "what a half cuts off is certified"},
    {"negative", FLAT & ~(unsigned)HARD_FILE, .depth = 8, .fragments = HARD_ANY, .also = hard_quads,
     .kills = "what unorm8 cuts off below 0 is certified"},
    {"straight", FLAT & ~(unsigned)HARD_ROTATE, .depth = 2, .fragments = HARD_ANY,
     .also = premultiplied, .kills = "the picture is straight"},
    {"srgb", FLAT, .depth = 1, .fragments = 512, .also = linear_light,
     .kills = "sRGB texels are not decoded"},
    /* capacity; the rest are limits, capacity.c */
    {"storage-128-mib", HARD_LARGE, .depth = 64, .fragments = 1 << 24, .also = fits_at_once,
     .kills = "what fits a range exactly does not"},
    {"storage-one-more", HARD_LARGE, .depth = 65, .fragments = (1 << 24) + 1, .also = fits_at_once,
     .kills = "one record more than a range holds"},
};
const size_t hard_row_count = sizeof hard_rows / sizeof *hard_rows;
