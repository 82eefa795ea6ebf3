/* SPDX-License-Identifier: MIT
 *
 * The objects that the tests of the validation spoil one at a time, and how they ask what became of
 * it. Included by those tests only.
 */
#ifndef STRATA_TESTS_GPU_WORLD_H
#define STRATA_TESTS_GPU_WORLD_H

#include "unit/gpu_fixture.h"

typedef struct world {
    fixture f;
    strata_buffer values, extra, block;
    strata_image color, other, small, depth, layered, integer, srgb, multisampled;
    strata_program compute, fullscreen, writing, reading, texels, replacing, scene;
    strata_bind binds[3];
    uint32_t count;
    strata_pass dispatch; /* sound as it is; a test spoils one thing */
    strata_pass draw;
    strata_attachment attachment, depth_attachment;
} world;

/* Codes that some test has caused. */
extern unsigned char caused[128];

int open_world(void **state);
int close_world(void **state);

/* The pass fails with this code, its line holds `text` and the pass's label, and nothing was
 * recorded; after gpu_begin the device is as good as new. */
void refused(world *w, const strata_pass *pass, gpu_code code, const char *text);
void accepted(world *w, const strata_pass *pass);
/* A creation that has failed: the code, and words in its line. */
void failed(world *w, strata_result result, gpu_code code, const char *text);

#define IN_WORLD(test) cmocka_unit_test_setup_teardown(test, open_world, close_world)

extern const struct CMUnitTest creation_tests[];
extern const size_t creation_test_count;

#endif
