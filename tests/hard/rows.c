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
    strata_render_options options = sized(&(picture){16, 16, NULL});
    picture blended = hard_render(instance, sc, options);
    for (uint32_t i = 0; i < sc->scene->material_count; i++)
        sc->scene->materials[i].alpha = SCENE_OPAQUE;
    sc->scene->revision++;
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
     .kills = "one depth for the whole triangle"},
    {"slivers", HARD_ALL & ~(unsigned)HARD_ROTATE, HARD_ANY, HARD_ANY,
     .kills = "thin triangles are dropped"},
    {"near-plane", HARD_ALL & ~(unsigned)HARD_ROTATE, HARD_ANY, HARD_ANY,
     .kills = "what crosses the near plane is dropped"},
    {"huge", HARD_SPLIT | HARD_FOLD | HARD_FILE, HARD_ANY, HARD_ANY,
     .kills = "large coordinates are cut off"},
    {"tiny", HARD_SPLIT | HARD_FOLD | HARD_FILE | HARD_RAY, HARD_ANY, HARD_ANY,
     .kills = "small coordinates are rounded to zero"},
    {"depth-range", HARD_SPLIT | HARD_FOLD | HARD_FILE | HARD_RAY, HARD_ANY, HARD_ANY,
     .kills = "depth is rounded to 16 bits"},
    {"not-a-number", HARD_REFUSED, .kills = "positions are not checked"},
    {"infinite", HARD_REFUSED, .kills = "positions are not checked for infinities"},
    {"shared-edges", HARD_ALL & ~(unsigned)HARD_ROTATE, EACH(3, 32),
     .kills = "pixels on an edge belong to both triangles"},
    {"dust", (HARD_ALL & ~(unsigned)HARD_ROTATE), HARD_ANY, HARD_ANY,
     .kills = "the smallest triangles are dropped"},
    {"screen", HARD_ALL, EACH(3, 48), .kills = "fragments of one triangle beyond 1,024 are lost"},
    {"layers-0", HARD_FOLD | HARD_FILE, EACH(0, 16), .kills = "empty pixels are resolved"},
    {"layers-1", FLAT | HARD_RAY, EACH(1, 16), .kills = "a pixel's only fragment is lost"},
    {"layers-2", FLAT | HARD_RAY, EACH(2, 16), .kills = "two fragments are not sorted"},
    {"layers-32", FLAT | HARD_RAY, EACH(32, 16), .kills = "the network of 32 leaves out a step"},
    {"layers-33", FLAT | HARD_RAY, EACH(33, 16), .kills = "a pixel of 33 goes to the class of 32"},
    {"layers-64", FLAT | HARD_RAY, EACH(64, 16), .kills = "the network of 64 leaves out a step"},
    {"layers-65", FLAT | HARD_RAY, EACH(65, 16), .kills = "a pixel of 65 goes to the class of 64"},
    {"layers-254", FLAT, EACH(254, 8), .kills = "the last layer of the stencil is lost"},
    {"layers-256", FLAT, EACH(256, 8), .kills = "counts of fragments wrap at 256"},
    {"layers-1500", DEEP | HARD_FILE, .depth = 1500, .fragments = 1500,
     .kills = "a pixel's list ends after 1,024"},
    {"layers-20000", DEEP | HARD_LARGE, .depth = 20000, .fragments = 20000,
     .kills = "one invocation walks 20,000 fragments"},
    {"pixel-100000", DEEP | HARD_LARGE, .depth = 100000, .fragments = 100000,
     .kills = "counts of fragments have 16 bits"},
    /* colour */
    {"alpha-0", FLAT | HARD_RAY, EACH(8, 16), .also = shows_background,
     .kills = "colours are not premultiplied"},
    {"alpha-1", FLAT | HARD_RAY, EACH(8, 16), .also = equals_opaque,
     .kills = "alpha stays below 1"},
    {"alpha-next-to-1", FLAT | HARD_RAY, EACH(8, 16), .kills = "what is nearly opaque is opaque"},
    {"alpha-512th", FLAT, EACH(200, 16),
     .kills = "the bound of an 8-bit payload is a quarter of a step"},
    {"alpha-millionth", DEEP | HARD_LARGE, .depth = 10000, .fragments = 10000,
     .kills = "faint fragments are left out"},
    {"alpha-denormal", FLAT | HARD_RAY, EACH(8, 16), .kills = "alphas without a value are dropped"},
    {"hdr-65504", FLAT | HARD_RAY, .depth = 8, .fragments = HARD_ANY,
     .kills = "colours are cut off at 1,000"},
    {"hdr-million", FLAT | HARD_RAY, .depth = 8, .fragments = HARD_ANY,
     .kills = "what a half cuts off is certified"},
    {"negative", FLAT & ~(unsigned)HARD_FILE, .depth = 8, .fragments = HARD_ANY,
     .kills = "what unorm8 cuts off at 0 is certified"},
    {"straight", FLAT & ~(unsigned)HARD_ROTATE, .depth = 2, .fragments = HARD_ANY,
     .also = premultiplied, .kills = "textures are filtered premultiplied, and multiplied again"},
    {"srgb", FLAT, .depth = 1, .fragments = 512, .also = linear_light,
     .kills = "sRGB textures are read as linear"},
    /* capacity; the rest are limits, capacity.c */
    {"storage-128-mib", HARD_LARGE, .depth = 64, .fragments = 1 << 24,
     .kills = "a range of exactly the limit is refused"},
    {"storage-one-more", HARD_LARGE, .depth = 65, .fragments = (1 << 24) + 1,
     .kills = "one record beyond the range is dropped"},
};
const size_t hard_row_count = sizeof hard_rows / sizeof *hard_rows;
