/* SPDX-License-Identifier: MIT
 *
 * The table of hard cases: a scene "hard:NAME" a row, what must hold of its pictures, and the
 * mutation of the implementation that the row finds. README.md says how to read it.
 */
#ifndef STRATA_TESTS_HARD_H
#define STRATA_TESTS_HARD_H

#include <stddef.h>
#include <stdint.h>

#include "oracle/oracle.h"
#include "techniques/picture.h"

/* What holds, beside the same bits in every exact way, order of submission, number of bands and on
 * both backends, which holds for all. */
enum {
    HARD_SPLIT = 1, /* meshes cut in two, and put together: the same bits */
    HARD_TRANSLATE =
        2,           /* scene and eye moved along the image plane by powers of two: the same bits */
    HARD_ROTATE = 4, /* the camera turned by 90 degrees turns the picture, bit for bit */
    HARD_FOLD = 8,   /* certificates hold against the fold oracle, for every payload */
    HARD_RAY = 16,   /* exactly the fragments that the ray oracle meets, in its order */
    HARD_FILE = 32,  /* written and loaded again: the same bits */
    HARD_REFUSED = 64, /* it is not rendered, and the line names the mesh */
    HARD_LARGE = 128,  /* takes seconds or more: in hard_large only */
    HARD_ALL = HARD_SPLIT | HARD_TRANSLATE | HARD_ROTATE | HARD_FOLD | HARD_RAY | HARD_FILE
};

enum { HARD_ANY = -1 };

typedef struct hard_row {
    const char *name; /* of the scene */
    unsigned holds;
    int32_t depth;     /* the most fragments in one pixel; HARD_ANY where a driver's edges decide */
    int64_t fragments; /* in all */
    uint32_t orders;   /* of submission, beside those that each way has of its own */
    void (*also)(strata *instance, strata_scene *sc, const struct hard_row *row);
    const char *kills; /* the mutation, of tests/mutants/hard.txt */
} hard_row;

extern const hard_row hard_rows[];
extern const size_t hard_row_count;

/* A row of capacity: a limit of the implementation rather than a scene. */
typedef struct hard_limit {
    const char *name;
    void (*check)(void **state);
    const char *kills;
} hard_limit;

extern const hard_limit hard_limits[];
extern const size_t hard_limit_count;

extern const char *const hard_backends[2];
extern uint32_t hard_thorough; /* 1: also the ways that take long */

/* ---- check.c ----------------------------------------------------------------------------------
 */

/* Everything that the row says, on both backends. */
void hard_check(const hard_row *row);

/* Every exact way that holds pictures so deep gives the first one's bits; that one is rendered into
 * *reference where it is empty. */
void hard_ways(strata *instance, strata_scene *sc, const char *what, uint32_t depth, uint32_t width,
               uint32_t height, picture *reference);

/* What a program tells of each way that was rendered whole; NULL: nothing. */
typedef struct hard_told {
    const char *what, *backend, *use, *setting;
    double seconds;
    uint64_t fragments, largest, hash;
    uint32_t bands, retries;
} hard_told;
extern void (*hard_tell)(const hard_told *told);

const scene_hard_case *hard_case(const char *name); /* fails where there is none */

/* By abuffer and ppc, with these options; free with picture_free. */
picture hard_render(strata *instance, strata_scene *sc, strata_render_options options);
strata_scene *hard_scene(strata *instance, const char *name); /* "layers-1" */

/* ---- quads.c: the picture is the fold of the scene's quads -------------------------------------
 */
void hard_quads(strata *instance, strata_scene *sc, const hard_row *row);

/* ---- edit.c: the same triangles in the same order ----------------------------------------------
 */

void hard_split(scene *s); /* every mesh becomes two, drawn one after the other */
void hard_merge(scene *s); /* neighbours of one material and place become one mesh */
/* Positions become multiples of 2^-14, and instances stay where they are. */
void hard_round(scene *s);

#endif
