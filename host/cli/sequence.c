/* SPDX-License-Identifier: MIT
 *
 * Rendering and saving for strata render: one picture, or the frames of a camera's path with
 * history kept between them; names with a frame's number in them, and one account of all frames.
 */
#include "cli/cli.h"
#include "cli/path.h"

#include <stdlib.h>
#include <string.h>

#define MAX_NAME   4096u
#define MAX_DIGITS 9

/* ---- names with a number --------------------------------------------------------------------- */

/* A name cut at its conversion "%d" or "%0Nd"; "%%" is a percent sign. */
typedef struct pattern {
    char before[MAX_NAME], after[MAX_NAME];
    int digits;  /* at least so many, with zeros in front */
    int numbers; /* 1, or 0: the name has no conversion */
} pattern;

/* At a percent sign: its length as a conversion, 0 when it is none. */
static size_t conversion(const char *text, int *digits) {
    size_t length = 1;
    *digits = 0;
    if (text[length] == '0') {
        length++;
        if (text[length] < '1' || text[length] > '0' + MAX_DIGITS)
            return 0;
        *digits = text[length++] - '0';
    }
    return text[length] == 'd' ? length + 1 : 0;
}

/* 0: a percent sign that begins neither, a second conversion, one in a folder's name, or too long.
 */
static int pattern_parse(const char *name, pattern *out) {
    size_t length = 0;
    char *part = out->before;
    out->numbers = out->digits = 0;
    if (strlen(name) >= MAX_NAME - 16)
        return 0;
    while (*name) {
        int digits;
        if (*name != '%') {
            part[length++] = *name++;
        } else if (name[1] == '%') {
            part[length++] = '%';
            name += 2;
        } else {
            const size_t skip = conversion(name, &digits);
            if (skip == 0 || out->numbers++ > 0 || strchr(name, '/'))
                return 0;
            out->digits = digits;
            part[length] = '\0';
            part = out->after;
            length = 0;
            name += skip;
        }
    }
    part[length] = '\0';
    if (!out->numbers)
        out->after[0] = '\0';
    return 1;
}

/* The name of a frame's file; "" when it is too long, which cannot be opened. */
static void pattern_name(const pattern *p, uint32_t frame, char name[MAX_NAME]) {
    const int digits = p->digits ? p->digits : 1;
    const int length =
        p->numbers ? snprintf(name, MAX_NAME, "%s%0*u%s", p->before, digits, frame, p->after)
                   : snprintf(name, MAX_NAME, "%s", p->before);
    if (length < 0 || (unsigned)length >= MAX_NAME)
        name[0] = '\0';
}

/* Whether one of the frames has this name. */
static int pattern_has(const pattern *p, const char *name, uint32_t frames) {
    char own[MAX_NAME];
    const size_t length = strlen(name), before = strlen(p->before), after = strlen(p->after);
    uint64_t frame = 0;
    for (size_t i = before; p->numbers && i + after < length && frame < frames; i++)
        frame = 10 * frame + (uint64_t)(name[i] - '0');
    if (frame >= frames)
        return 0;
    pattern_name(p, (uint32_t)frame, own);
    return strcmp(own, name) == 0;
}

/* Whether two outputs would overwrite each other, in one frame or one in another's; `name`: where.
 */
static int pattern_collide(const pattern *a, const pattern *b, uint32_t frames,
                           char name[MAX_NAME]) {
    for (uint32_t i = 0; i < (a->numbers ? frames : 1); i++) {
        pattern_name(a, i, name);
        if (pattern_has(b, name, frames))
            return 1;
    }
    return 0;
}

typedef struct output {
    const char *option, *path; /* path NULL: not asked for */
    uint32_t what;             /* STRATA_OUTPUT_*, 0: the account */
    pattern name;
} output;

enum { OUTPUTS = 4 };

/* 0: a name is no pattern; *bad is its output. Only sequences have patterns, and no account has. */
static int outputs_parse(const cli_outputs *given, uint32_t frames, output out[OUTPUTS],
                         const output **bad) {
    const output all[OUTPUTS] = {
        {.option = "-o", .path = given->color, .what = STRATA_OUTPUT_COLOR},
        {.option = "--deep", .path = given->deep, .what = STRATA_OUTPUT_DEEP},
        {.option = "--bound", .path = given->bound, .what = STRATA_OUTPUT_BOUND},
        {.option = "--account", .path = given->account}};
    for (int i = 0; i < OUTPUTS; i++) {
        *bad = &out[i];
        out[i] = all[i];
        if (!out[i].path)
            continue;
        if (frames > 0 && out[i].what && !pattern_parse(out[i].path, &out[i].name))
            return 0;
        if (frames == 0 || !out[i].what)
            snprintf(out[i].name.before, MAX_NAME, "%s", out[i].path);
    }
    return 1;
}

int cli_check_names(const cli_outputs *given, uint32_t frames, char line[CLI_LINE]) {
    output outputs[OUTPUTS];
    const output *bad;
    char name[MAX_NAME];
    if (!outputs_parse(given, frames, outputs, &bad)) {
        snprintf(line, CLI_LINE,
                 "%s %.200s: a frame's number is one %%d or %%0Nd (N from 1 to 9) after the last "
                 "'/', and %%%% a percent sign",
                 bad->option, bad->path);
        return 0;
    }
    for (int i = 0; i < OUTPUTS; i++)
        for (int k = i + 1; k < OUTPUTS; k++)
            if (outputs[i].path && outputs[k].path &&
                pattern_collide(&outputs[i].name, &outputs[k].name, frames ? frames : 1, name)) {
                snprintf(line, CLI_LINE, "%s and %s name the same file, %.200s", outputs[i].option,
                         outputs[k].option, name);
                return 0;
            }
    return 1;
}

int cli_check_outputs(const cli_outputs *given, uint32_t frames) {
    output outputs[OUTPUTS];
    const output *bad;
    char name[MAX_NAME];
    int status = CLI_DONE;
    outputs_parse(given, frames, outputs, &bad);
    for (int i = 0; i < OUTPUTS && status == CLI_DONE; i++) {
        if (!outputs[i].path || (!outputs[i].what && strcmp(outputs[i].path, "-") == 0))
            continue;
        pattern_name(&outputs[i].name, 0, name);
        status = cli_check_output(strlen(outputs[i].path) < MAX_NAME ? name : outputs[i].path);
    }
    return status;
}

/* ---- the account of all frames --------------------------------------------------------------- */

typedef struct tally {
    json_t *frames, *warnings; /* warnings: each once, in the order in which they came */
    json_t *last;              /* the account of the last frame */
    json_int_t retries, stalls;
} tally;

static void tally_free(tally *t) {
    json_decref(t->frames);
    json_decref(t->warnings);
    json_decref(t->last);
}

/* Says and keeps those that were not there yet. */
static void add_warnings(tally *t, const json_t *account) {
    const json_t *warnings = cli_array(account, "warnings");
    json_t *fresh = json_array();
    for (size_t i = 0; i < json_array_size(warnings); i++) {
        json_t *warning = json_array_get(warnings, i);
        size_t k = 0;
        while (k < json_array_size(t->warnings) &&
               !json_equal(json_array_get(t->warnings, k), warning))
            k++;
        if (k == json_array_size(t->warnings)) {
            json_array_append(t->warnings, warning);
            json_array_append(fresh, warning);
        }
    }
    json_t *told = json_pack("{s:o}", "warnings", fresh);
    cli_warn(told);
    json_decref(told);
}

/* An instance leaves that open while there may be frames to come. */
static void warn_of_budget(tally *t) {
    const json_t *budget = json_object_get(t->last, "budget");
    char line[80];
    if (!json_is_false(json_object_get(budget, "met")))
        return;
    snprintf(line, sizeof line, "the budget of %.3g ms is missed",
             json_number_value(json_object_get(budget, "asked_ms")));
    json_t *told = json_pack("{s:[s]}", "warnings", line);
    add_warnings(t, told);
    json_decref(told);
}

static int tally_frame(tally *t, strata *s, int keep, const char *file) {
    cli_text text = {0};
    const strata_result result = strata_account(s, cli_text_write, &text);
    json_decref(t->last);
    t->last = NULL;
    const int status =
        result == STRATA_OK ? cli_text_parse(&text, &t->last) : cli_fail_result(s, result);
    free(text.data);
    if (status != CLI_DONE)
        return status;
    add_warnings(t, t->last);
    t->retries += json_integer_value(json_object_get(t->last, "retries"));
    t->stalls += json_integer_value(json_object_get(t->last, "stalls"));
    if (!keep)
        return CLI_DONE;
    json_t *frame = json_copy(json_array_get(cli_array(t->last, "frames"), 0));
    json_object_set(frame, "passes", json_object_get(t->last, "passes"));
    json_object_set(frame, "bound", json_object_get(t->last, "bound"));
    json_object_set_new(frame, "file", file ? json_string(file) : json_null());
    return json_array_append_new(t->frames, frame) == 0 ? CLI_DONE
                                                        : cli_fail(CLI_FAILED, "out of memory");
}

/* The last frame's, with what is of all frames. */
static int tally_save(tally *t, const char *path) {
    if (json_array_size(t->frames) > 0) {
        json_t *ms = json_array();
        for (size_t i = 0; i < json_array_size(t->frames); i++)
            json_array_append(ms, json_object_get(json_array_get(t->frames, i), "ms"));
        json_object_set_new(t->last, "frame_ms", ms);
        json_object_set(t->last, "frames", t->frames);
        json_object_set(t->last, "warnings", t->warnings);
        json_object_set_new(t->last, "retries", json_integer(t->retries));
        json_object_set_new(t->last, "stalls", json_integer(t->stalls));
    }
    cli_text text = {0};
    char *json = json_dumps(t->last, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    const int written = json && cli_text_write(&text, json, strlen(json)) == STRATA_OK &&
                        cli_text_write(&text, "\n", 1) == STRATA_OK;
    const int status = written ? cli_text_save(&text, path) : cli_fail(CLI_FAILED, "out of memory");
    free(json);
    free(text.data);
    return status;
}

/* ---- one frame after the other --------------------------------------------------------------- */

typedef struct run {
    strata *s;
    strata_scene *scene;
    const cli_options *common;
    const cli_sequence *sequence;
    uint32_t frame, frames;
    cli_path path; /* no keys: the camera of the options */
    double turns;
    output outputs[OUTPUTS];
    tally tally;
    int partial; /* a frame is less than was asked for */
} run;

static strata_result run_progress(void *user, double done) {
    const run *r = user;
    return cli_progress(NULL, (r->frame + done) / r->frames);
}

static int run_camera(void *user, const char *name, strata_camera_pose *out, char line[PATH_LINE]) {
    const run *r = user;
    const strata_render_options *o = &r->common->render;
    *out = (strata_camera_pose){.struct_size = sizeof *out};
    const strata_result result = strata_scene_camera(r->scene, name, o->width ? o->width : 800,
                                                     o->height ? o->height : 600, out);
    if (result != STRATA_OK)
        snprintf(line, PATH_LINE, "%s", strata_error(r->s));
    return result == STRATA_OK;
}

/* "orbit[:TURNS]", whole or not, backwards when negative. */
int cli_path_is_orbit(const char *text, double *turns) {
    *turns = 0;
    if (strncmp(text, "orbit", 5) != 0 || (text[5] && text[5] != ':'))
        return 0;
    *turns = 1;
    return text[5] && !cli_parse_number(text + 6, -1000, 1000, turns) ? -1 : 1;
}

static int run_begin(run *r) {
    char line[PATH_LINE];
    uint32_t frame;
    const char *file = r->sequence->path;
    if (!file || cli_path_is_orbit(file, &r->turns))
        return CLI_DONE;
    if (!path_read(file, run_camera, r, &r->path, line))
        return cli_fail(CLI_FAILED, "%s", line);
    if (path_meets_target(&r->path, r->frames, r->sequence->fps, &frame))
        return cli_fail(CLI_FAILED, "%.200s: in frame %u the eye is at its target", file, frame);
    return CLI_DONE;
}

/* Those with a number in their name of each frame, the others of the last. */
static int save_frame(run *r, char name[MAX_NAME]) {
    strata_result result = STRATA_OK;
    for (int i = 0; i < OUTPUTS && result == STRATA_OK; i++) {
        const output *o = &r->outputs[i];
        if (!o->path || !o->what || (!o->name.numbers && r->frame + 1 < r->frames))
            continue;
        pattern_name(&o->name, r->frame, name);
        result = strata_save(r->s, o->what, name);
    }
    pattern_name(&r->outputs[0].name, r->frame, name);
    return result == STRATA_OK ? CLI_DONE : cli_fail_result(r->s, result);
}

static int render_frame(run *r) {
    const cli_sequence *q = r->sequence;
    strata_render_options options = r->common->render;
    strata_camera_pose pose;
    char name[MAX_NAME];
    strata_result result = STRATA_OK;
    options.progress = run_progress;
    options.user = r;
    options.continues = r->frame > 0;
    options.angle = 360.0 * r->turns * r->frame / r->frames;
    if (r->path.count > 0) {
        pose = path_pose(&r->path, path_time(&r->path, r->frame, r->frames, q->fps));
        options.pose = &pose;
    }
    if (q->fps > 0)
        result = strata_scene_set_time(r->scene, r->common->time + r->frame / q->fps);
    if (result == STRATA_OK)
        result = strata_render(r->s, r->scene, &options);
    if (result != STRATA_OK && result != STRATA_PARTIAL)
        return cli_fail_result(r->s, result);
    if (cli_interrupted())
        return cli_fail(CLI_FAILED, "stopped");
    r->partial |= result == STRATA_PARTIAL;
    int status = save_frame(r, name);
    if (status == CLI_DONE) {
        const int saved = r->outputs[0].name.numbers || r->frame + 1 == r->frames;
        status =
            tally_frame(&r->tally, r->s, q->frames > 0 && r->outputs[3].path, saved ? name : NULL);
    }
    return status;
}

int cli_render_frames(strata *s, strata_scene *scene, const cli_options *common,
                      const cli_outputs *outputs, const cli_sequence *sequence) {
    const output *bad;
    run *r = calloc(1, sizeof *r);
    if (!r)
        return cli_fail(CLI_FAILED, "out of memory");
    *r = (run){.s = s,
               .scene = scene,
               .common = common,
               .sequence = sequence,
               .frames = sequence->frames ? sequence->frames : 1,
               .tally = {.frames = json_array(), .warnings = json_array()}};
    outputs_parse(outputs, sequence->frames, r->outputs, &bad);
    int status = run_begin(r);
    for (; r->frame < r->frames && status == CLI_DONE; r->frame++)
        status = render_frame(r);
    cli_progress_end();
    if (status == CLI_DONE)
        warn_of_budget(&r->tally);
    if (status == CLI_DONE && outputs->account)
        status = tally_save(&r->tally, outputs->account);
    if (status == CLI_DONE && r->partial)
        status = cli_fail(CLI_PARTIAL, "done, but less than was asked for: see the account");
    tally_free(&r->tally);
    path_free(&r->path);
    free(r);
    return status;
}
