/* SPDX-License-Identifier: MIT
 *
 * The CPU reference that the renderer is held to: plain C in double, sharing no code with the
 * shaders. A capture is one frame read back with its raw, unsorted records; fold.c folds them,
 * ray.c says which ones there should be. Tests only.
 */
#ifndef STRATA_TESTS_ORACLE_H
#define STRATA_TESTS_ORACLE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "render/render.h"

#define ORACLE_MAX_WORDS (2u * PLAN_MAX_PLANES)
#define ORACLE_UNIT      0x1p-24 /* half an ulp of 1 in float: the rounding of one operation */

/* gamma_m = m u / (1 - m u): m roundings in a row change a value by no more than this share of it
 * (Higham, Accuracy and Stability of Numerical Algorithms, lemma 3.1). */
double oracle_gamma(double m, double unit);

/* ---- what is rendered ------------------------------------------------------------------------ */

typedef struct oracle_case {
    const char *scene; /* "scene:NAME?K=V" or one of scenes.c: "own:NAME" */
    uint32_t width, height;
    const char *camera;     /* NULL: the scene's first, else an orbit */
    const char *setting[2]; /* "ID.KNOB=VALUE" or NULL */
    uint32_t outputs;       /* STRATA_OUTPUT_* beside colour */
    uint32_t shuffle;       /* not 0: draws and triangles are submitted in another order */
} oracle_case;

/* The beginning of a case. */
#define ORACLE_FRAME(name, w, h) .scene = name, .width = w, .height = h

/* An instance on the backend that *state names, NULL when it cannot be opened: the test is skipped
 * and the reason printed. */
strata *oracle_open(void **state);
/* Fails the test in its own words. The caller closes the scene. */
strata_scene *oracle_scene(strata *s, const char *name);
void oracle_render(strata *s, strata_scene *sc, const oracle_case *c);
/* A GLB of scenes.c in memory, NULL when there is none of this name. */
unsigned char *oracle_scene_build(const char *name, size_t *size);

/* ---- one frame, read back -------------------------------------------------------------------- */

typedef struct oracle_record {
    uint32_t key, order;
    uint32_t words[ORACLE_MAX_WORDS]; /* payload, word by word over its planes */
} oracle_record;

typedef struct oracle_capture {
    uint32_t width, height;
    const plan *plan; /* with scene: borrowed, until the next render */
    const scene *scene;
    scene_view view;
    float background[4];
    float *color, *behind, *depth; /* [height][width], row 0 = bottom; behind: the opaque part */
    size_t record_count;
    size_t *first;          /* [pixels + 1]: a pixel's records are first[p] .. first[p + 1] - 1 */
    oracle_record *records; /* as they lie in memory: unsorted within a pixel */
} oracle_capture;

/* Renders and reads back, checking on the way that ranges and records fit together: as many records
 * as the ranges say and the pool counted, each in exactly one range (or list). */
void oracle_capture_frame(strata *s, strata_scene *sc, const oracle_case *c, oracle_capture *out);
void oracle_capture_free(oracle_capture *c);

/* By (key, order), near first. */
void oracle_sort(oracle_record *records, size_t count);
float oracle_depth(const oracle_record *record); /* the depth that the key was made from */
uint32_t oracle_primitive(const oracle_record *record);
/* Whether the material is drawn as transparent when every effect is on. */
int oracle_transparent(const scene_material *material);

/* ---- fold.c ---------------------------------------------------------------------------------- */

/* A value of a record after decoding: what float arithmetic made of it is off by no more than
 * `error`. */
typedef struct oracle_value {
    double value, error;
} oracle_value;

/* What a record does to a walk: C' = C + T c, T' = T t for r, g, b. Alpha goes with a transmittance
 * that is common to all; under three it composes by itself. */
typedef struct oracle_element {
    oracle_value color[4], through[3];
} oracle_element;

/* One channel of a payload field, NAN when the payload has no such field. `rounded` is set to the
 * number of roundings that the shader's decoding makes. */
double oracle_payload(const plan_payload *payload, const oracle_record *record, const char *field,
                      uint32_t channel, int *rounded);
oracle_element oracle_decode(const plan *p, const oracle_record *record);

/* The exact colour of sorted records in front of `behind`, and how far a float fold in the order of
 * shaders/strata/fold.glsl may be off. `behind` NULL: the walk ends in transparent black. */
void oracle_fold(const plan *p, const oracle_record *sorted, size_t count, const float *behind,
                 oracle_value out[4]);
/* The same colour in long double, evaluated back to front; to check oracle_fold. */
void oracle_fold_backwards(const plan *p, const oracle_record *sorted, size_t count,
                           const float *behind, long double out[4]);

/* ---- exact.c --------------------------------------------------------------------------------- */

typedef struct oracle_exact {
    double *color; /* [height][width][4], row 0 = bottom */
    size_t channels;
    size_t *count; /* fragments of a pixel */
} oracle_exact;

/* Of a frame that is captured for it. */
oracle_exact oracle_exact_make(strata *s, strata_scene *sc, const oracle_case *c);
void oracle_exact_free(oracle_exact *e);

/* Renders with a certificate, against the same background; settings end at NULL. */
void oracle_certify(strata *s, strata_scene *sc, const oracle_case *c, const char *use,
                    const char *const settings[3], uint32_t bands);

typedef struct oracle_tally {
    double *slack; /* bound over error, ascending, of channels whose error is not zero */
    size_t slack_count;
    double worst, largest; /* error over bound; bound */
    uint64_t certified, uncertified;
} oracle_tally;

/* The last render against the exact picture: fails the test where an error is above its bound. */
oracle_tally oracle_hold(const strata *s, const oracle_exact *e, const char *what);
void oracle_tally_free(oracle_tally *t);

/* ---- ray.c ----------------------------------------------------------------------------------- */

/* Where a ray through a pixel's centre meets a primitive. */
typedef enum oracle_cover { ORACLE_OUTSIDE, ORACLE_EDGE, ORACLE_INSIDE } oracle_cover;

typedef struct oracle_hit {
    double depth, tolerance; /* of the fragment, and how far the rasteriser's may be off */
    oracle_cover cover;      /* EDGE: within the sub-pixel grid of the outline */
    uint32_t edges;          /* EDGE: bit k, edge opposite corner k; bit 3 near, bit 4 far plane */
} oracle_hit;

typedef struct oracle_shape {
    uint32_t primitive, instance;
    uint32_t transparent, disc, exact; /* exact: no rounding in its depth, which is constant */
    uint32_t exists;                   /* 0: a back that is not drawn, or failed by an alpha test */
    double height;                     /* of a triangle, the least, in pixels; 0: degenerate */
    double corner[3][4];               /* clip space, x and y in pixels times w */
    double error[3][4];                /* of the shader's corners */
    double weight[3][3];               /* barycentric weights over w as functions of (x, y, 1) */
    double plane[3];                   /* depth as such a function */
    double reach;                      /* largest window coordinate, pixels */
    double slope_error;                /* of the rasteriser's depth a pixel away */
    double box[4];                     /* pixels that it can touch: left, bottom, right, top */
    const float *position[3];          /* of the mesh's vertices */
} oracle_shape;

typedef struct oracle_shapes {
    oracle_shape *at;
    uint32_t count;
    uint32_t *first; /* [instances + 1]: number of an instance's first primitive */
} oracle_shapes;

void oracle_shapes_make(const scene *s, const scene_view *view, uint32_t width, uint32_t height,
                        oracle_shapes *out);
void oracle_shapes_free(oracle_shapes *shapes);
oracle_hit oracle_cast(const oracle_shape *shape, double x, double y);
/* Whether both give the same depth bits wherever both are: the same corners in the same order, or
 * the same constant depth without rounding. */
int oracle_same_depth(const oracle_shape *a, const oracle_shape *b);

/* ---- judge.c --------------------------------------------------------------------------------- */

/* What became of the fragments of a frame. */
typedef struct oracle_verdict {
    uint64_t judged;           /* fragments that must be there and are */
    uint64_t missing, surplus; /* that must be there and are not, or the other way */
    uint64_t misplaced;        /* depth beyond the tolerance */
    uint64_t disordered;       /* neighbours in the order of the keys, against the rays' */
    uint64_t opaque_wrong;     /* pixels whose opaque depth is not that of the rays */
    uint64_t edge, edge_drawn; /* within the grid of an outline; of those, captured */
    uint64_t hidden_or_not;    /* whose depth is too near the opaque one's to tell */
    uint64_t slivers; /* depths of captured edges of thin triangles, beyond the tolerance */
    uint64_t seams, seam_wrong; /* pixels on an edge that two triangles share; not counted once */
    uint64_t ties;              /* neighbours at the same depth, judged by primitive number */
    double worst_depth;         /* largest |depth - exact| over its tolerance */
    char first[256];            /* the first thing that is wrong */
} oracle_verdict;

void oracle_judge(const oracle_capture *c, oracle_verdict *out);

#endif
