/* SPDX-License-Identifier: MIT
 *
 * What the tests of techniques share: a scene rendered through the public interface, its pixels,
 * and comparisons bit for bit.
 */
#ifndef STRATA_TESTS_PICTURE_H
#define STRATA_TESTS_PICTURE_H

#include "strata/host.h"

typedef struct picture {
    uint32_t width, height;
    float *pixels; /* [height][width][4], first row on top */
} picture;

/* One way to render. Zero is the plan's own choice on Vulkan. */
typedef struct way {
    const char *backend, *use, *effects, *camera;
    const char *settings[8]; /* up to the first NULL */
    uint32_t bands, shuffle, samples;
    double tolerance;
    const char *filter;
} way;

/* Scenes that every exact technique must agree on. */
typedef struct test_scene {
    const char *path;
    uint32_t width, height;
    uint32_t depth; /* at least the largest number of fragments in one pixel */
} test_scene;

extern const test_scene picture_scenes[];
extern const size_t picture_scene_count;

/* An instance of this backend, kept for the whole program; NULL when the backend cannot be opened
 * here (the caller skips and says so). "vulkan lacks:FACT" is Vulkan on a device without it,
 * "vulkan claims:FACT" on one that has it (strata_open_options.inject). */
strata *picture_instance(const char *backend);
void picture_close(void); /* all instances */

/* A fact of its device (strata/gpu.h), for ways that not every device takes. `selftest.interlock`
 * may be claimed: its sections are plain code then, which counts where the device keeps a pixel's
 * fragments in order by itself. */
uint64_t picture_fact(const strata *instance, const char *id);

/* Loads; a failure fails the test with the instance's line. */
strata_scene *picture_scene(strata *instance, const char *path);

/* Renders; a failure fails the test with the instance's line. Free with picture_free. */
picture picture_render(strata_scene *scene, strata *instance, const way *w, uint32_t width,
                       uint32_t height);
void picture_free(picture *p);

/* Fails unless every bit is equal, naming the first pixel that differs. */
void picture_same(const picture *a, const picture *b, const char *what);
uint64_t picture_hash(const picture *p);

#endif
