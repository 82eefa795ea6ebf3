/* SPDX-License-Identifier: MIT
 *
 * The list of procedural scenes with their knobs, as data: for help texts, for checking what a user
 * sets, and for the presets.
 */
#include "scene/generate.h"

#define SEED                                                                                       \
    { "seed", "start of the random numbers", 1, 0, 4294967295.0, 1, NULL }

static const char *const city_views[] = {[CITY_STREET] = "street", [CITY_AERIAL] = "aerial", NULL};
static const char *const layer_places[] = {[LAYERS_ALL] = "all", [LAYERS_PIXEL] = "pixel", NULL};
static const char *const layer_orders[] = {
    [LAYERS_SHUFFLED] = "shuffled", [LAYERS_NEAR_FIRST] = "near", [LAYERS_FAR_FIRST] = "far", NULL};

static const scene_generator_knob shells[] = {
    [SHELLS_SEED] = SEED,
    [SHELLS_COUNT] = {"count", "spheres", 8, 1, 1000, 1, NULL},
    [SHELLS_SUBDIVISION] = {"subdivision", "8 * 4^n triangles a sphere", 4, 0, 9, 1, NULL},
    [SHELLS_ALPHA] = {"alpha", "opacity of a surface", 0.25, 0, 1, 0, NULL},
    [SHELLS_CORE] = {"core", "1: an opaque sphere in the middle", 1, 0, 1, 1, NULL},
    [SHELLS_TRANSMISSION] = {"transmission", "above 0: coloured glass instead", 0, 0, 1, 0, NULL},
};
static const scene_generator_knob soup[] = {
    [SOUP_SEED] = SEED,
    [SOUP_SMALL] = {"small", "small triangles", 100000, 0, 1e7, 1, NULL},
    [SOUP_MEDIUM] = {"medium", "triangles of 16 times the area", 5000, 0, 1e6, 1, NULL},
    [SOUP_DEPTH] = {"depth", "mean fragments a pixel of a square image", 41.6, 0, 10000, 0, NULL},
    [SOUP_MATERIALS] = {"materials", "materials and meshes", 16, 1, 256, 1, NULL},
    [SOUP_ALPHA] = {"alpha", "mean opacity", 0.25, 0, 1, 0, NULL},
};
static const scene_generator_knob hairball[] = {
    [HAIRBALL_SEED] = SEED,
    [HAIRBALL_STRANDS] = {"strands", "hairs", 600, 1, 1e6, 1, NULL},
    [HAIRBALL_SEGMENTS] = {"segments", "pieces of a hair", 32, 1, 1000, 1, NULL},
    [HAIRBALL_SIDES] = {"sides", "2: ribbons, else tubes of so many sides", 2, 2, 16, 1, NULL},
    [HAIRBALL_RADIUS] = {"radius", "half width of a hair; the ball's is 1", 0.008, 1e-5, 0.5, 0,
                         NULL},
    [HAIRBALL_ALPHA] = {"alpha", "opacity of a hair", 0.3, 0, 1, 0, NULL},
    [HAIRBALL_CORE] = {"core", "1: an opaque sphere in the middle", 1, 0, 1, 1, NULL},
};
static const scene_generator_knob needles[] = {
    [NEEDLES_SEED] = SEED,
    [NEEDLES_BRANCHES] = {"branches", "boughs on the trunk", 90, 1, 10000, 1, NULL},
    [NEEDLES_NEEDLES] = {"needles", "needles on a bough", 210, 0, 100000, 1, NULL},
    [NEEDLES_LENGTH] = {"length", "of a needle; the tree is 2 high", 0.12, 1e-4, 1, 0, NULL},
    [NEEDLES_WIDTH] = {"width", "of a needle", 0.008, 1e-5, 1, 0, NULL},
    [NEEDLES_ALPHA] = {"alpha", "opacity of a needle", 0.5, 0, 1, 0, NULL},
};
static const scene_generator_knob particles[] = {
    [PARTICLES_SEED] = SEED,
    [PARTICLES_COUNT] = {"count", "splats", 20000, 1, 2e7, 1, NULL},
    [PARTICLES_RADIUS] = {"radius", "mean radius; the plume is 2 high", 0.03, 1e-6, 1, 0, NULL},
    [PARTICLES_ALPHA] = {"alpha", "opacity of a splat", 0.15, 0, 1, 0, NULL},
    [PARTICLES_CORE] = {"core", "1: an opaque sphere inside", 1, 0, 1, 1, NULL},
};
static const scene_generator_knob stack[] = {
    [STACK_SEED] = SEED,
    [STACK_COUNT] = {"count", "squares", 3, 1, 1e6, 1, NULL},
    [STACK_ALPHA] = {"alpha", "opacity of a square", 0.5, 0, 1, 0, NULL},
    [STACK_TILT] = {"tilt", "degrees about the x axis", 0, 0, 85, 0, NULL},
    [STACK_SHIFT] = {"shift", "how far each is moved off the centre", 0.25, 0, 0.5, 0, NULL},
    [STACK_SPLIT] = {"split", "1: every other square has its other diagonal", 0, 0, 1, 1, NULL},
    [STACK_OPAQUE] = {"opaque", "1: the first square is opaque", 0, 0, 1, 1, NULL},
    [STACK_MERGED] = {"merged", "1: one mesh instead of one a square", 0, 0, 1, 1, NULL},
};
static const scene_generator_knob city[] = {
    [CITY_SEED] = SEED,
    [CITY_COUNT] = {"count", "buildings", 2000, 1, 2e6, 1, NULL},
    [CITY_VIEW] = {"view", "where the first camera stands", CITY_STREET, 0, 1, 1, city_views},
    [CITY_GLASS] = {"glass", "share of buildings with a glass front", 0.2, 0, 1, 0, NULL},
    [CITY_ALPHA] = {"alpha", "opacity of the glass", 0.3, 0, 1, 0, NULL},
};
static const scene_generator_knob layers[] = {
    [LAYERS_SEED] = SEED,
    [LAYERS_COUNT] = {"count", "rectangles, at as many depths", 32, 0, 1e6, 1, NULL},
    [LAYERS_WHERE] = {"where", "the whole image, or its middle pixel", LAYERS_ALL, 0, 1, 1,
                      layer_places},
    [LAYERS_WIDTH] = {"width", "of the image this is rendered to", 64, 1, 16384, 1, NULL},
    [LAYERS_HEIGHT] = {"height", "of the image this is rendered to", 64, 1, 16384, 1, NULL},
    [LAYERS_ALPHA] = {"alpha", "opacity of a layer", 0.5, 0, 1, 0, NULL},
    [LAYERS_ORDER] = {"order", "in the file", LAYERS_SHUFFLED, 0, 2, 1, layer_orders},
    [LAYERS_OPAQUE] = {"opaque", "1: an opaque backdrop", 0, 0, 1, 1, NULL},
};
static const scene_generator_knob burst[] = {
    [BURST_SEED] = SEED,
    [BURST_MEAN] = {"mean", "fragments a pixel, on average", 16, 0, 1e6, 0, NULL},
    [BURST_SPREAD] = {"spread", "0: as many in each pixel; 1: all in one", 0.5, 0, 1, 0, NULL},
    [BURST_WIDTH] = {"width", "of the image this is rendered to", 64, 1, 4096, 1, NULL},
    [BURST_HEIGHT] = {"height", "of the image this is rendered to", 64, 1, 4096, 1, NULL},
    [BURST_ALPHA] = {"alpha", "opacity of a fragment", 0.01, 0, 1, 0, NULL},
};
static const scene_generator_knob glass[] = {
    [GLASS_SEED] = SEED,
    [GLASS_DETAIL] = {"detail", "triangles grow with its square", 4, 1, 40, 1, NULL},
    [GLASS_SMOKE] = {"smoke", "splats of smoke", 1500, 0, 1e6, 1, NULL},
};

#define KNOBS(list) .knobs = list, .knob_count = BASE_COUNT(list)

static const scene_generator generators[] = {
    {.name = "shells", .title = "nested transparent spheres", KNOBS(shells)},
    {.name = "soup", .title = "random unlit triangles, even over the image", KNOBS(soup)},
    {.name = "hairball", .title = "transparent hair round a sphere", KNOBS(hairball)},
    {.name = "needles", .title = "a fir with transparent needles", KNOBS(needles)},
    {.name = "particles", .title = "a plume of round splats", KNOBS(particles)},
    {.name = "stack", .title = "squares at exactly the same depth", KNOBS(stack)},
    {.name = "city", .title = "instanced buildings, some of glass", KNOBS(city)},
    {.name = "layers", .title = "rectangles at distinct depths, pixel by pixel", KNOBS(layers)},
    {.name = "glass", .title = "a still life of coloured glass and smoke", KNOBS(glass)},
    {.name = "burst", .title = "so many fragments, from even to all in one pixel", KNOBS(burst)},
};

const scene_generator *scene_generators(uint32_t *count) {
    *count = BASE_COUNT(generators);
    return generators;
}
