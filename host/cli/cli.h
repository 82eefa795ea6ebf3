/* SPDX-License-Identifier: MIT
 *
 * The command line, a client of strata/host.h and of nothing else of the host: exit statuses, what
 * the verbs share, and one entry for each verb.
 */
#ifndef STRATA_CLI_H
#define STRATA_CLI_H

#include <argp.h>
#include <jansson.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "strata/host.h"

#define CLI_DONE    0
#define CLI_FAILED  1 /* one line on stderr says why */
#define CLI_USAGE   2
#define CLI_PARTIAL 3 /* done, but less than was asked for */

/* ---- verbs: argv[0] is "strata VERB"; they return an exit status
 * --------------------------------- */
int cli_render(int argc, char **argv);
int cli_plan(int argc, char **argv);
int cli_list(int argc, char **argv);
int cli_compare(int argc, char **argv);
int cli_scene(int argc, char **argv);
int cli_sweep(int argc, char **argv);

/* ---- failure (common.c)
 * -------------------------------------------------------------------------- */

/* "strata: LINE" on stderr, without control characters; returns `status`. */
int cli_fail(int status, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The line of the instance's last failure (s NULL: of strata_open) and the status that goes with
 * it: bad usage for INVALID_ARGUMENT, else failed. */
int cli_fail_result(strata *s, strata_result result);

void cli_warn(const json_t *object); /* its "warnings", a line each, unless STRATA_LOG is error */

/* ---- texts (common.c)
 * ---------------------------------------------------------------------------- */

typedef struct cli_text { /* zero-initialised = empty; free(data) */
    char *data;
    size_t length, capacity;
} cli_text;
strata_result cli_text_write(void *user, const char *bytes, size_t size); /* user: a cli_text */

/* Status CLI_DONE, or CLI_FAILED after a line. */
int cli_text_parse(const cli_text *text, json_t **out);
int cli_text_print(const cli_text *text);                  /* to stdout */
int cli_text_save(const cli_text *text, const char *path); /* beside, then renamed; "-" = stdout */

/* Whether a file could appear under `path` later: its folder exists and may be written to. Said
 * before long work, not after it. */
int cli_check_output(const char *path);
int cli_has_suffix(const char *path, const char *suffix);

/* A member as text, number or array; what is missing reads as "", 0 and empty. */
const char *cli_get(const json_t *object, const char *key);
double cli_number(const json_t *object, const char *key);
const json_t *cli_array(const json_t *object, const char *key);
const char *cli_count(double value, char text[40]); /* "12,345" or "1.5" */

/* Text from column `indent` on, broken between words at 100 columns; the cursor stands at `at`. */
void cli_wrap(FILE *out, int at, int indent, const char *text);

/* ---- options that render and plan share (options.c)
 * ---------------------------------------------- */

typedef struct cli_options {
    strata_open_options open;
    strata_render_options render;
    const char *scene;
    const char **settings; /* render.settings */
    double time;
    int has_time;
} cli_options;

extern const struct argp cli_options_argp;      /* a child; its input is a cli_options */
int cli_options_init(cli_options *o, int argc); /* room for as many settings as arguments */
void cli_options_free(cli_options *o);

/* Opens the instance and the scene, and sets the time. Status; both are NULL unless it is done. */
int cli_options_open(const cli_options *o, strata **s, strata_scene **scene);

/* Whole text as a number within [low, high]; 0 when it is not. */
int cli_parse_number(const char *text, double low, double high, double *out);
int cli_parse_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out);

/* ---- rendering and saving (sequence.c)
 * ---------------------------------------------- */

#define CLI_LINE 512u

typedef struct cli_outputs { /* names of files; NULL: not asked for */
    const char *color, *deep, *bound, *account;
} cli_outputs;

typedef struct cli_sequence {
    uint32_t frames;  /* 0: one picture; else names may hold a frame's number */
    const char *path; /* of the camera: a file's name or "orbit[:TURNS]"; NULL: it stands */
    double fps;       /* frames a second of scene and path; 0: the scene stands */
} cli_sequence;

/* 1: an orbit of so many turns, 0: something else, -1: no number stands after "orbit:". */
int cli_path_is_orbit(const char *text, double *turns);

/* Whether the outputs are named well and apart; 0 after saying what is wrong in line. */
int cli_check_names(const cli_outputs *outputs, uint32_t frames, char line[CLI_LINE]);
/* Whether they could be written, those of the first frame. Status. */
int cli_check_outputs(const cli_outputs *outputs, uint32_t frames);

/* Renders all frames and saves what is asked for: names with a number for each frame, others of the
 * last. Warnings to stderr, each once. Status. */
int cli_render_frames(strata *s, strata_scene *scene, const cli_options *common,
                      const cli_outputs *outputs, const cli_sequence *sequence);

/* ---- progress and interruption (progress.c) -------------------------------------------------- */

/* The first SIGINT, SIGTERM or SIGHUP asks to stop, the second ends the program. */
void cli_catch_interrupt(void);
int cli_interrupted(void);
strata_result cli_progress(void *user, double done); /* for strata_render_options.progress */
void cli_progress_line(const char *text);            /* in place of the bar */
void cli_progress_end(void);                         /* clears either */

#endif
