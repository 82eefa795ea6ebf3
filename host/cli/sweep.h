/* SPDX-License-Identifier: MIT
 *
 * strata sweep: what accuracy costs in time. The state of a sweep is its results.json (the shape is
 * in the guide), kept as one JSON value that grows and is saved after each configuration.
 *
 *     sweep.c          the command: options, cases, resuming
 *     sweep_case.c     one scene at one size: reference, errors, rounds of frames
 *     sweep_frame.c    one configuration: its certificate and error, its times
 *     sweep_pace.c     how fast the device is while they are taken
 *     sweep_results.c  the JSON: begun, saved
 *     sweep_load.c     the JSON: read again, and checked
 *     sweep_judge.c    multiples of the floor, the front, what must hold, in words
 *     report.c         report.html
 */
#ifndef STRATA_CLI_SWEEP_H
#define STRATA_CLI_SWEEP_H

#include "cli/cli.h"

#define SWEEP_FORMAT    "strata-sweep/3"
#define SWEEP_MAX_CASES 16
#define SWEEP_VISIT     3u     /* frames measured before another configuration has its turn */
#define SWEEP_WARMUP    2u     /* frames before them */
#define SWEEP_DISTURBED 1.25   /* of the usual pace: worth another visit */
#define SWEEP_SLOW      1000.0 /* ms of a frame: one before and one measured will do */
#define SWEEP_FAR       4.0    /* times as long as what is no less accurate: one visit will do */
#define SWEEP_PICTURE   256u   /* longest side of a picture in the report */
#define SWEEP_ENOUGH    (1.0 / 255) /* an error that a display of 8 bits does not show */

typedef struct sweep_place { /* one case: what is rendered */
    const char *scene;
    uint32_t width, height;
} sweep_place;

typedef struct sweep_options {
    cli_options common;
    const char *folder;
    const char *also[SWEEP_MAX_CASES]; /* scenes and sizes beside the first */
    const char **only;                 /* names hold one of these; none = all */
    sweep_place places[SWEEP_MAX_CASES];
    uint32_t also_count, only_count, place_count;
    uint32_t frames; /* of each configuration */
    int all, resume;
} sweep_options;

/* The floor of a case, rendered again and again by an instance of its own. */
typedef struct sweep_pace {
    strata *s; /* NULL: nothing is blended, or it failed */
    strata_scene *scene;
    strata_render_options options;
} sweep_pace;

typedef struct sweep {
    const sweep_options *options;
    json_t *root;
    strata *s;           /* of the case at work */
    strata_scene *scene; /* likewise */
    sweep_pace pace;     /* likewise */
    double began;        /* seconds, for the time left */
    double done, total;  /* visits */
} sweep;

double sweep_seconds(void);
uint32_t sweep_rounds(const sweep_options *o);
/* A line with the time left, on a terminal. */
void sweep_progress(const sweep *w, const char *what);
/* For strata_render: stops when interrupted, draws nothing. */
strata_result sweep_keep_going(void *user, double done);

/* ---- sweep_results.c ------------------------------------------------------------------------- */
#define SWEEP_JSON (JSON_INDENT(1) | JSON_REAL_PRECISION(9)) /* how it is written */
json_t *sweep_begin(const sweep_options *o); /* without cases; NULL: out of memory */
int sweep_save(const sweep *w);              /* whole or not at all. Status */
/* DIR/pictures/CASE-CONFIGURATION[-KIND].png; kind "" is the picture itself; 0: too long. */
int sweep_picture(const sweep_options *o, size_t at_case, size_t at, const char *kind,
                  char path[4096]);
/* A new object of a configuration as the library lists it. */
json_t *sweep_configuration(const sweep_options *o, const sweep_place *place, const json_t *listed);

/* ---- sweep_load.c ---------------------------------------------------------------------------- */
/* What of a file can be continued with these options: the root; else status after a line. */
int sweep_load(const sweep_options *o, json_t **root);

/* ---- sweep_case.c ---------------------------------------------------------------------------- */
/* Renders what is missing of case `at`. Status. */
int sweep_case(sweep *w, size_t at);

/* ---- sweep_frame.c --------------------------------------------------------------------------- */
/* A picture in memory. */
typedef struct sweep_image {
    uint32_t width, height;
    float *color, *bound; /* [height][width][4], as strata_read gives them */
} sweep_image;

void sweep_image_free(sweep_image *im);
/* The options of a configuration; settings: room for what its list has. */
strata_render_options sweep_render_options(const sweep *w, const sweep_place *place,
                                           const json_t *configuration, const char *settings[8]);
/* The account of the last render. Status. */
int sweep_account(strata *s, json_t **account);
/* Renders with a certificate. OK: *out is the caller's. */
strata_result sweep_render(sweep *w, const strata_render_options *options, sweep_image *out);
/* Error and bound of a configuration against the reference, into its object. Status; that it cannot
 * be rendered is noted there and no failure. */
int sweep_error(sweep *w, size_t at_case, size_t at, const sweep_place *place,
                const sweep_image *reference);
/* Times of one visit. As above. */
int sweep_time(sweep *w, size_t at_case, size_t at, const sweep_place *place, uint32_t round);
/* Closes the instance and opens another, after a failure. Status. */
int sweep_reopen(sweep *w, const sweep_place *place);

/* ---- sweep_pace.c ---------------------------------------------------------------------------- */
/* For the case at work, where the floor is among its configurations. Status. */
int sweep_pace_begin(sweep *w, size_t at_case, const sweep_place *place);
void sweep_pace_end(sweep *w);
/* *ms of a frame of the floor, now; 0: there is no pace. Status. */
int sweep_pace_take(sweep *w, double *ms);
/* The median of all that were taken of a case, in its configurations' "pace_ms", and of `now`
 * unless that is 0; 0: there is none. */
double sweep_pace_usual(const json_t *one, double now);

/* ---- sweep_judge.c --------------------------------------------------------------------------- */
double sweep_median(double *values, size_t count); /* sorts them; 0 of none */
/* The largest error, and the certificate; infinite: there is none, or somewhere none. */
double sweep_measured(const json_t *configuration);
double sweep_certified(const json_t *configuration);
/* Figures, front, words and "violations" of the whole, anew from what was measured. */
void sweep_judge(json_t *root);

/* ---- report.c -------------------------------------------------------------------------------- */
int sweep_report(const sweep *w); /* DIR/report.html. Status */

#endif
