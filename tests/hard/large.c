/* SPDX-License-Identifier: MIT
 *
 * The hard cases that take seconds or more: 20,000 layers in every way, one pixel of 100,000
 * fragments, 4096 x 4096 pixels, a storage range that is exactly full. By hand:
 *
 *     hard_large [NAME] [--json FILE]    rows of this name, with * and ?; what each way took
 */
#include "hard/hard.h"
#include "named.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static FILE *figures;
static int told_before;

static void write_told(const hard_told *t) {
    fprintf(figures,
            "%s\n  {\"case\": \"%s\", \"backend\": \"%s\", \"use\": \"%s\", \"setting\": \"%s\", "
            "\"seconds\": %.3f, \"fragments\": %llu, \"max_per_pixel\": %llu, \"bands\": %u, "
            "\"retries\": %u, \"hash\": \"%016llx\"}",
            told_before ? "," : "", t->what, t->backend, t->use, t->setting, t->seconds,
            (unsigned long long)t->fragments, (unsigned long long)t->largest, t->bands, t->retries,
            (unsigned long long)t->hash);
    told_before = 1;
    fflush(figures);
}

static void check_row(void **state) {
    hard_check(*state);
}

static void sixteen_million_pixels(void **state) {
    picture reference = {0};
    (void)state;
    for (size_t b = 0; b < BASE_COUNT(hard_backends); b++) {
        strata *instance = picture_instance(hard_backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = hard_scene(instance, "crossing");
        hard_ways(instance, sc, "4096x4096", 64, 4096, 4096, &reference);
        strata_scene_close(sc);
    }
    picture_free(&reference);
}

int main(int argc, char **argv) {
    struct CMUnitTest *tests = calloc(hard_row_count + 1, sizeof *tests);
    const char *name = NULL;
    size_t count = 0;
    if (!tests)
        return 1;
    for (int i = 1; i < argc; i++)
        if (strcmp(argv[i], "--json") == 0 && i + 1 < argc)
            figures = fopen(argv[++i], "w");
        else
            name = argv[i];
    for (size_t i = 0; i < hard_row_count; i++)
        if ((hard_rows[i].holds & HARD_LARGE) || hard_rows[i].depth >= 1000)
            tests[count++] = (struct CMUnitTest){.name = hard_rows[i].name,
                                                 .test_func = check_row,
                                                 .initial_state = (void *)(uintptr_t)&hard_rows[i]};
    tests[count++] = (struct CMUnitTest){.name = "4096x4096", .test_func = sixteen_million_pixels};
    hard_thorough = 1;
    if (figures) {
        hard_tell = write_told;
        fputc('[', figures);
    }
    const int failed = named_run("large hard cases", name, tests, count);
    if (figures) {
        fputs("\n]\n", figures);
        fclose(figures);
    }
    picture_close();
    free(tests);
    return failed;
}
