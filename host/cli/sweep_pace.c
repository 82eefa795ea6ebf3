/* SPDX-License-Identifier: MIT
 *
 * How fast the device is while a configuration is measured. Machines are shared, clocks and heat
 * change: what was measured in a slow minute would be called slow. So the floor, all fragments
 * blended once, is rendered right before and right after the frames of each visit, the same picture
 * each time, and times are divided by how much slower than usual it was. An instance of its own
 * does that, so that the one that is measured prepares nothing anew in between.
 */
#include "cli/sweep.h"

#include <string.h>

#define FRAMES 3u /* their median is the pace */

void sweep_pace_end(sweep *w) {
    strata_scene_close(w->pace.scene);
    strata_close(w->pace.s);
    w->pace = (sweep_pace){0};
}

static const json_t *floor_of(const json_t *one) {
    const json_t *first = json_array_get(cli_array(one, "configurations"), 0);
    return strcmp(cli_get(first, "name"), "floor") == 0 ? first : NULL;
}

/* Where the device does not take it there is no pace from then on. */
static int render_floor(sweep *w) {
    const strata_result r = strata_render(w->pace.s, w->pace.scene, &w->pace.options);
    if (r == STRATA_ERROR_CANCELLED)
        return cli_fail(CLI_FAILED, "stopped; --resume goes on");
    if (r != STRATA_OK && r != STRATA_PARTIAL) {
        cli_fail(0,
                 "warning: times stay in the pace of the moment: the floor cannot be rendered "
                 "beside them: %.300s",
                 strata_error(w->pace.s));
        sweep_pace_end(w);
    }
    return CLI_DONE;
}

int sweep_pace_begin(sweep *w, size_t at_case, const sweep_place *place) {
    const json_t *one = json_array_get(json_object_get(w->root, "cases"), at_case);
    const json_t *floor = floor_of(one);
    const char *none[8];
    cli_options options = w->options->common;
    if (!floor)
        return CLI_DONE;
    options.scene = place->scene;
    const int status = cli_options_open(&options, &w->pace.s, &w->pace.scene);
    if (status != CLI_DONE)
        return status;
    w->pace.options = sweep_render_options(w, place, floor, none);
    w->pace.options.settings = NULL;
    w->pace.options.setting_count = 0;
    return render_floor(w);
}

static double median_frame(const json_t *account) {
    double values[FRAMES];
    size_t i, count = 0;
    const json_t *value;
    json_array_foreach(cli_array(account, "frame_ms"), i, value) {
        if (count < FRAMES)
            values[count++] = json_number_value(value);
    }
    return sweep_median(values, count);
}

int sweep_pace_take(sweep *w, double *ms) {
    json_t *account = NULL;
    *ms = 0;
    if (!w->pace.s)
        return CLI_DONE;
    w->pace.options.repeat = FRAMES;
    int status = render_floor(w);
    if (status == CLI_DONE && w->pace.s)
        status = sweep_account(w->pace.s, &account);
    *ms = median_frame(account);
    json_decref(account);
    return status;
}

static size_t count_of(const json_t *one) {
    size_t i, count = 0;
    const json_t *c;
    json_array_foreach(cli_array(one, "configurations"), i, c) {
        count += json_array_size(json_object_get(c, "pace_ms"));
    }
    return count;
}

double sweep_pace_usual(const json_t *one, double now) {
    double *values = calloc(count_of(one) + 1, sizeof *values);
    size_t i, k, count = 0;
    const json_t *c, *value;
    json_array_foreach(cli_array(one, "configurations"), i, c) {
        json_array_foreach(cli_array(c, "pace_ms"), k, value) {
            if (values && json_number_value(value) > 0)
                values[count++] = json_number_value(value);
        }
    }
    if (values && now > 0)
        values[count++] = now;
    const double usual = values ? sweep_median(values, count) : 0;
    free(values);
    return usual;
}
