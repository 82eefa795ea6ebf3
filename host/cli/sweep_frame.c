/* SPDX-License-Identifier: MIT
 *
 * One configuration of a sweep: rendered once with a certificate and held against the exact image,
 * and rendered without one for its time. What it cannot render is noted, with the reason, and its
 * instance replaced, so that the others are measured as if it had not been there.
 */
#define _POSIX_C_SOURCE 200809L
#include "cli/sweep.h"

#include <math.h>
#include <string.h>
#include <time.h>

void sweep_image_free(sweep_image *im) {
    free(im->color);
    free(im->bound);
    *im = (sweep_image){0};
}

static json_t *case_at(const sweep *w, size_t at_case) {
    return json_array_get(json_object_get(w->root, "cases"), at_case);
}

static json_t *configuration_at(const sweep *w, size_t at_case, size_t at) {
    return json_array_get(json_object_get(case_at(w, at_case), "configurations"), at);
}

strata_render_options sweep_render_options(const sweep *w, const sweep_place *place,
                                           const json_t *configuration, const char *settings[8]) {
    strata_render_options options = w->options->common.render;
    const json_t *list = cli_array(configuration, "settings");
    options.width = place->width;
    options.height = place->height;
    options.use = *cli_get(configuration, "use") ? cli_get(configuration, "use") : NULL;
    options.settings = settings;
    options.setting_count = 0;
    for (size_t i = 0; i < json_array_size(list) && i < 8; i++)
        settings[options.setting_count++] = json_string_value(json_array_get(list, i));
    options.progress = sweep_keep_going;
    return options;
}

int sweep_account(strata *s, json_t **account) {
    cli_text text = {0};
    *account = NULL;
    const strata_result r = strata_account(s, cli_text_write, &text);
    const int status = r == STRATA_OK ? cli_text_parse(&text, account) : cli_fail_result(s, r);
    free(text.data);
    return status;
}

/* ---- failures -------------------------------------------------------------------------------- */

int sweep_reopen(sweep *w, const sweep_place *place) {
    cli_options options = w->options->common;
    options.scene = place->scene;
    strata_scene_close(w->scene);
    strata_close(w->s);
    w->scene = NULL;
    w->s = NULL;
    return cli_options_open(&options, &w->s, &w->scene);
}

/* What a device has not is refused; all else failed. */
static int note_failure(sweep *w, const sweep_place *place, json_t *c, strata_result r,
                        const char *reason) {
    const int refused = r == STRATA_ERROR_UNSUPPORTED || r == STRATA_ERROR_INVALID_ARGUMENT;
    if (r == STRATA_ERROR_CANCELLED)
        return cli_fail(CLI_FAILED, "stopped; --resume goes on");
    json_object_set_new(c, "state", json_string(refused ? "refused" : "failed"));
    json_object_set_new(c, "reason", json_string(reason[0] ? reason : "without a reason"));
    return sweep_reopen(w, place);
}

/* The plan may have done without a technique that failed: then this was not measured. */
static int ran_as_asked(const json_t *account, const json_t *c, char missing[64]) {
    const char *use = cli_get(c, "use");
    while (*use) {
        const size_t length = strcspn(use, ",");
        int found = 0;
        size_t i;
        const json_t *planned;
        snprintf(missing, 64, "%.*s", (int)length, use);
        json_array_foreach(cli_array(account, "plan"), i, planned) {
            found |= strcmp(cli_get(planned, "technique"), missing) == 0;
        }
        if (!found)
            return 0;
        use += length + (use[length] == ',');
    }
    return 1;
}

static strata_result check_plan(const json_t *account, const json_t *c, char reason[256]) {
    char missing[64];
    if (ran_as_asked(account, c, missing))
        return STRATA_OK;
    const json_t *warning = json_array_get(cli_array(account, "warnings"), 0);
    const char *line = json_string_value(warning);
    snprintf(reason, 256, "%s did not run%s%.180s", missing, line ? ": " : "", line ? line : "");
    return STRATA_ERROR_MODULE;
}

/* ---- error and certificate ------------------------------------------------------------------- */

strata_result sweep_render(sweep *w, const strata_render_options *options, sweep_image *out) {
    *out = (sweep_image){.width = options->width, .height = options->height};
    strata_result r = strata_render(w->s, w->scene, options);
    if (r != STRATA_OK && r != STRATA_PARTIAL)
        return r;
    const size_t size = (size_t)out->width * out->height * 4 * sizeof(float);
    out->color = malloc(size);
    out->bound = malloc(size);
    r = out->color && out->bound ? STRATA_OK : STRATA_ERROR_OUT_OF_HOST_MEMORY;
    if (r == STRATA_OK)
        r = strata_read(w->s, STRATA_OUTPUT_COLOR, out->color, size);
    if (r == STRATA_OK && (options->outputs & STRATA_OUTPUT_BOUND))
        r = strata_read(w->s, STRATA_OUTPUT_BOUND, out->bound, size);
    if (r != STRATA_OK)
        sweep_image_free(out);
    return r;
}

/* Channels farther from the reference than both certificates together allow, and pixels that have
 * none. The reference's own is its rounding. */
static void add_checks(json_t *error, const sweep_image *im, const sweep_image *reference) {
    double violations = 0, uncertified = 0, tightest = INFINITY;
    for (size_t p = 0; p < (size_t)im->width * im->height; p++) {
        int unknown = 0;
        for (size_t i = 4 * p; i < 4 * p + 4; i++) {
            const double bound = (double)im->bound[i], theirs = (double)reference->bound[i];
            const double apart = fabs((double)im->color[i] - (double)reference->color[i]);
            unknown |= !isfinite(bound);
            if (!isfinite(bound))
                continue;
            violations += !(apart <= bound + (isfinite(theirs) ? theirs : 0));
            if (apart > 0 && bound / apart < tightest)
                tightest = bound / apart;
        }
        uncertified += unknown;
    }
    json_object_set_new(error, "violations", json_integer((json_int_t)violations));
    json_object_set_new(error, "uncertified_pixels", json_integer((json_int_t)uncertified));
    json_object_set_new(error, "tightest", isfinite(tightest) ? json_real(tightest) : json_null());
}

static int compare(sweep *w, size_t at_case, size_t at, const sweep_image *im,
                   const sweep_image *reference, json_t **error) {
    char heat[4096], flip[4096], picture[4096];
    cli_text text = {0};
    const strata_compare_options options = {
        .struct_size = sizeof options, .longest = SWEEP_PICTURE, .heat = heat, .flip = flip};
    const int fits = sweep_picture(w->options, at_case, at, "heat", heat) &
                     sweep_picture(w->options, at_case, at, "flip", flip) &
                     sweep_picture(w->options, at_case, at, "", picture);
    if (!fits)
        return cli_fail(CLI_FAILED, "%.64s...: the path is too long", w->options->folder);
    strata_result r = strata_compare_pixels(w->s, im->width, im->height, reference->color,
                                            im->color, &options, cli_text_write, &text);
    if (r == STRATA_OK)
        r = strata_save_pixels(w->s, im->width, im->height, im->color, SWEEP_PICTURE, picture);
    const int status = r == STRATA_OK ? cli_text_parse(&text, error) : cli_fail_result(w->s, r);
    free(text.data);
    return status;
}

static void add_account(json_t *c, const json_t *account) {
    double total = 0;
    const char *key;
    json_t *value;
    json_t *bytes = json_object_get(account, "bytes");
    json_object_foreach(bytes, key, value) {
        if (strcmp(key, "scene") != 0 && strcmp(key, "host") != 0)
            total += json_number_value(value);
    }
    json_object_set(c, "bytes", bytes);
    json_object_set_new(c, "memory", json_integer((json_int_t)total));
    json_object_set(c, "plan", json_object_get(account, "plan"));
}

int sweep_error(sweep *w, size_t at_case, size_t at, const sweep_place *place,
                const sweep_image *reference) {
    json_t *c = configuration_at(w, at_case, at), *account = NULL, *error = NULL;
    const char *settings[8];
    char reason[256] = "";
    sweep_image im;
    strata_render_options options = sweep_render_options(w, place, c, settings);
    options.outputs = STRATA_OUTPUT_BOUND;
    strata_result r = sweep_render(w, &options, &im);
    if (r != STRATA_OK)
        return note_failure(w, place, c, r, strata_error(w->s));
    int status = sweep_account(w->s, &account);
    if (status == CLI_DONE && (r = check_plan(account, c, reason)) != STRATA_OK)
        status = note_failure(w, place, c, r, reason);
    else if (status == CLI_DONE)
        status = compare(w, at_case, at, &im, reference, &error);
    if (error) {
        add_checks(error, &im, reference);
        json_object_set_new(c, "error", error);
        json_object_set(c, "bound", json_object_get(account, "bound"));
        add_account(c, account);
    }
    json_decref(account);
    sweep_image_free(&im);
    return status;
}

/* ---- time ------------------------------------------------------------------------------------ */

static double cpu_ms(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static void keep_times(json_t *c, const json_t *account, double cpu, double pace) {
    const json_t *frames = cli_array(account, "frame_ms");
    json_array_append_new(json_object_get(c, "rounds"), json_deep_copy(frames));
    json_array_append_new(json_object_get(c, "cpu_ms"), json_real(cpu));
    json_array_append_new(json_object_get(c, "pace_ms"), json_real(pace));
    json_object_set(c, "passes", json_object_get(account, "passes"));
    json_object_set(c, "plan", json_object_get(account, "plan")); /* the plan's own may change */
    json_object_set_new(c, "state", json_string("measured"));
}

/* Of the last frame, as long as the device worked at it: the first one compiles, too. */
static double last_ms(const json_t *account) {
    const json_t *frames = cli_array(account, "frames");
    const json_t *last = json_array_get(frames, json_array_size(frames) - 1);
    const char *key = json_is_number(json_object_get(last, "gpu_ms")) ? "gpu_ms" : "ms";
    return cli_number(last, key);
}

/* Through the angles to come, so that what a technique learns is learned before; one frame of those
 * that take long. */
static strata_result warm_up(sweep *w, strata_render_options options, uint32_t frames, int *slow,
                             int *status) {
    const double from = options.angle;
    strata_result r = STRATA_OK;
    for (uint32_t i = 0; i < SWEEP_WARMUP && r == STRATA_OK && !*slow; i++) {
        json_t *account = NULL;
        options.angle = from + (double)(i * frames) / SWEEP_WARMUP;
        r = strata_render(w->s, w->scene, &options);
        if (r == STRATA_PARTIAL)
            r = STRATA_OK;
        if (r == STRATA_OK && (*status = sweep_account(w->s, &account)) != CLI_DONE)
            return r;
        *slow = r == STRATA_OK && last_ms(account) > SWEEP_SLOW;
        json_decref(account);
    }
    return r;
}

/* Then a degree a frame, so that nothing is cached by accident; `pace` before and after them. */
static strata_result measure(sweep *w, strata_render_options *options, const json_t *one,
                             double *cpu, double *pace, int *status) {
    double after = 0;
    *status = sweep_pace_take(w, pace);
    if (*status != CLI_DONE)
        return STRATA_OK;
    const double usual = sweep_pace_usual(one, *pace), begin = cpu_ms();
    options->turn = 1;
    options->learn = !(usual > 0 && *pace > SWEEP_DISTURBED * usual);
    options->pace = *pace > 0 && usual > 0 ? *pace / usual : 1;
    const strata_result r = strata_render(w->s, w->scene, options);
    *cpu = (cpu_ms() - begin) / options->repeat;
    if (r == STRATA_OK || r == STRATA_PARTIAL)
        *status = sweep_pace_take(w, &after);
    *pace = *pace > 0 && after > 0 ? (*pace + after) / 2 : 0;
    return r;
}

int sweep_time(sweep *w, size_t at_case, size_t at, const sweep_place *place, uint32_t round) {
    json_t *c = configuration_at(w, at_case, at), *account = NULL;
    const char *settings[8];
    char reason[256] = "";
    double cpu = 0, pace = 0;
    const uint32_t left = w->options->frames - round * SWEEP_VISIT;
    const uint32_t frames = left < SWEEP_VISIT ? left : SWEEP_VISIT;
    strata_render_options options = sweep_render_options(w, place, c, settings);
    int slow = 0, status = CLI_DONE;
    options.angle = round * SWEEP_VISIT;
    strata_result r = warm_up(w, options, frames, &slow, &status);
    if (status != CLI_DONE)
        return status;
    options.repeat = slow ? 1 : frames;
    if (r == STRATA_OK)
        r = measure(w, &options, case_at(w, at_case), &cpu, &pace, &status);
    if (status != CLI_DONE)
        return status;
    if (r != STRATA_OK && r != STRATA_PARTIAL)
        return note_failure(w, place, c, r, strata_error(w->s));
    status = sweep_account(w->s, &account);
    if (status == CLI_DONE && (r = check_plan(account, c, reason)) != STRATA_OK)
        status = note_failure(w, place, c, r, reason);
    else if (status == CLI_DONE)
        keep_times(c, account, cpu, pace);
    json_decref(account);
    return status;
}
