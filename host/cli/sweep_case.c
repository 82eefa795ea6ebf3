/* SPDX-License-Identifier: MIT
 *
 * One scene at one size of a sweep: the exact image, the configurations that there are, the error
 * of each, and then rounds of frames in which each has its turn, in an order that is shuffled anew.
 */
#include "cli/sweep.h"

#include <string.h>

static json_t *case_at(const sweep *w, size_t at) {
    return json_array_get(json_object_get(w->root, "cases"), at);
}

/* ---- what there is to measure ---------------------------------------------------------------- */

static int is_wanted(const sweep_options *o, const json_t *configuration) {
    for (uint32_t i = 0; i < o->only_count; i++)
        if (strstr(cli_get(configuration, "name"), o->only[i]))
            return 1;
    return o->only_count == 0;
}

/* What is always measured: all fragments blended once, and what the plan does by itself. */
static json_t *own_choice(void) {
    return json_pack("{s:s, s:[], s:s, s:i, s:i, s:s, s:b, s:b}", "use", "", "settings", "order",
                     "exact", "keeps", 0, "holds", 0, "payload", "float", "ends_early", 0, "bits",
                     0);
}

static json_t *choose(const sweep_options *o, const sweep_place *place, const json_t *listed) {
    json_t *chosen = json_array(), *own = own_choice();
    size_t i;
    const json_t *one;
    json_array_append_new(chosen, sweep_configuration(o, place, own));
    json_decref(own);
    json_array_foreach(cli_array(listed, "configurations"), i, one) {
        json_t *c = sweep_configuration(o, place, one);
        const int is_floor = strcmp(cli_get(c, "name"), "floor") == 0;
        if (is_floor)
            json_array_insert(chosen, 0, c);
        else if (is_wanted(o, c))
            json_array_append(chosen, c);
        json_decref(c);
    }
    return chosen;
}

/* A name that is mistyped would measure less than was meant, and say nothing. */
static void warn_of_idle_names(const sweep_options *o, const char *scene, const json_t *chosen) {
    for (uint32_t i = 0; i < o->only_count; i++) {
        size_t k, found = 0;
        const json_t *one;
        json_array_foreach(chosen, k, one) {
            found += strstr(cli_get(one, "name"), o->only[i]) != NULL;
        }
        if (!found)
            cli_fail(0, "warning: --only '%.100s': no way to render %.200s is named so", o->only[i],
                     scene);
    }
}

static int list_configurations(sweep *w, const sweep_place *place, json_t **listed) {
    cli_text text = {0};
    const char *settings[8];
    json_t *none = json_object();
    strata_render_options options = sweep_render_options(w, place, none, settings);
    const strata_result r = strata_configurations(w->s, w->scene, &options,
                                                  (uint32_t)w->options->all, cli_text_write, &text);
    const int status = r == STRATA_OK ? cli_text_parse(&text, listed) : cli_fail_result(w->s, r);
    json_decref(none);
    free(text.data);
    return status;
}

/* But for what was found of it. */
static int same_configuration(const json_t *kept, json_t *chosen) {
    static const char found[] = " state reason rounds cpu_ms pace_ms ";
    const char *key;
    json_t *value;
    json_object_foreach(chosen, key, value) {
        char word[64];
        snprintf(word, sizeof word, " %s ", key);
        if (!strstr(found, word) && !json_equal(value, json_object_get(kept, key)))
            return 0;
    }
    return 1;
}

/* Whether a sweep that is gone on with had the same ones: names and knobs of modules change. */
static int same_configurations(const json_t *kept, const json_t *chosen) {
    size_t i;
    json_t *one;
    if (json_array_size(kept) != json_array_size(chosen))
        return 0;
    json_array_foreach(chosen, i, one) {
        if (!same_configuration(json_array_get(kept, i), one))
            return 0;
    }
    return 1;
}

/* What the exact image is made with: the first capture and resolve whose bits are promised, ""
 * where there is none. The plan's own choice may round differently, and changes with what is
 * learnt. */
static json_t *exact_way(const json_t *listed) {
    size_t i;
    const json_t *one;
    json_array_foreach(cli_array(listed, "configurations"), i, one) {
        if (strchr(cli_get(one, "use"), ',') && json_is_true(json_object_get(one, "bits")) &&
            strcmp(cli_get(one, "order"), "exact") == 0 && cli_number(one, "keeps") == 0 &&
            cli_number(one, "holds") == 0 && strcmp(cli_get(one, "payload"), "float") == 0 &&
            !json_is_true(json_object_get(one, "ends_early")))
            return json_pack("{s:O, s:O}", "use", json_object_get(one, "use"), "settings",
                             json_object_get(one, "settings"));
    }
    return json_pack("{s:s, s:[]}", "use", "", "settings");
}

static int same_way(const json_t *kept, const json_t *chosen) {
    return json_equal(json_object_get(kept, "use"), json_object_get(chosen, "use")) &&
           json_equal(json_object_get(kept, "settings"), json_object_get(chosen, "settings"));
}

static int prepare(sweep *w, size_t at, const sweep_place *place) {
    json_t *listed = NULL, *kept = case_at(w, at);
    int status = list_configurations(w, place, &listed);
    if (status != CLI_DONE)
        return status;
    json_t *chosen = choose(w->options, place, listed), *exact = exact_way(listed);
    warn_of_idle_names(w->options, place->scene, chosen);
    if (!kept)
        json_array_append_new(json_object_get(w->root, "cases"),
                              json_pack("{s:s, s:[i,i], s:O, s:O, s:O}", "scene", place->scene,
                                        "size", (int)place->width, (int)place->height,
                                        "configurations", chosen, "refused",
                                        json_object_get(listed, "refused"), "reference", exact));
    else if (!same_configurations(json_object_get(kept, "configurations"), chosen) ||
             !same_way(json_object_get(kept, "reference"), exact))
        status = cli_fail(CLI_FAILED,
                          "%s/results.json: cannot go on with it: other modules are "
                          "installed now",
                          w->options->folder);
    else
        json_object_set(kept, "refused", json_object_get(listed, "refused"));
    json_decref(exact);
    json_decref(chosen);
    json_decref(listed);
    return status;
}

/* ---- the exact image ------------------------------------------------------------------------- */

static int check_device(sweep *w, const json_t *account) {
    json_t *here = json_object_get(account, "device"), *kept = json_object_get(w->root, "device");
    if (json_is_object(kept) && !json_equal(kept, here))
        return cli_fail(CLI_FAILED, "%s/results.json: cannot go on with it: it was measured on %s",
                        w->options->folder, cli_get(kept, "name"));
    json_object_set(w->root, "device", here);
    return CLI_DONE;
}

/* "abuffer + ppc": what folds in a plan, as the account tells. */
static json_t *folded_by(const json_t *account) {
    char name[256] = "";
    size_t i, length = 0;
    const json_t *planned;
    json_array_foreach(cli_array(account, "plan"), i, planned) {
        const char *stage = cli_get(planned, "stage");
        if (length < sizeof name && (strcmp(stage, "capture") == 0 ||
                                     strcmp(stage, "resolve") == 0 || strcmp(stage, "stream") == 0))
            length += (size_t)snprintf(name + length, sizeof name - length, "%s%s",
                                       length ? " + " : "", cli_get(planned, "technique"));
    }
    return json_string(name);
}

/* How many fragments pixels hold; none where the deep image cannot be had (sub-pixels, memory). */
static void add_complexity(sweep *w, const strata_render_options *exact, json_t *one) {
    strata_render_options options = *exact;
    json_t *account = NULL;
    options.outputs = STRATA_OUTPUT_DEEP | STRATA_OUTPUT_DEPTH;
    json_object_set_new(one, "complexity", json_null());
    if (options.samples <= 1 && strata_render(w->s, w->scene, &options) == STRATA_OK &&
        sweep_account(w->s, &account) == CLI_DONE)
        json_object_set(one, "complexity", json_object_get(account, "complexity"));
    json_decref(account);
}

static int render_reference(sweep *w, size_t at, const sweep_place *place, sweep_image *out) {
    json_t *one = case_at(w, at), *way = json_object_get(one, "reference"), *account = NULL;
    const char *settings[8];
    char path[4096];
    sweep_progress(w, "the exact image");
    strata_render_options options = sweep_render_options(w, place, way, settings);
    options.outputs = STRATA_OUTPUT_BOUND;
    const strata_result r = sweep_render(w, &options, out);
    if (r != STRATA_OK)
        return cli_fail_result(w->s, r);
    int status = sweep_account(w->s, &account);
    if (status == CLI_DONE)
        status = check_device(w, account);
    if (status == CLI_DONE && sweep_picture(w->options, at, 0, "exact", path) &&
        strata_save_pixels(w->s, out->width, out->height, out->color, SWEEP_PICTURE, path) !=
            STRATA_OK)
        status = cli_fail(CLI_FAILED, "%s", strata_error(w->s));
    if (status == CLI_DONE) {
        json_object_set(one, "fragments", json_object_get(account, "fragments"));
        json_object_set_new(way, "name", folded_by(account));
        json_object_set(way, "bound", json_object_get(account, "bound"));
        add_complexity(w, &options, one);
    }
    json_decref(account);
    return status;
}

/* ---- errors, then rounds --------------------------------------------------------------------- */

static int is_open(const json_t *configuration) {
    const char *state = cli_get(configuration, "state");
    return strcmp(state, "failed") != 0 && strcmp(state, "refused") != 0;
}

static int measure_errors(sweep *w, size_t at, const sweep_place *place,
                          const sweep_image *reference) {
    const json_t *list = json_object_get(case_at(w, at), "configurations");
    int status = CLI_DONE;
    for (size_t i = 0; i < json_array_size(list) && status == CLI_DONE; i++) {
        const json_t *c = json_array_get(list, i);
        w->done++;
        if (!is_open(c) || json_is_object(json_object_get(c, "error")))
            continue;
        sweep_progress(w, cli_get(c, "name"));
        status = sweep_error(w, at, i, place, reference);
        if (status == CLI_DONE)
            status = sweep_save(w);
    }
    return status;
}

/* The same order for the same round, whoever goes on with it. */
static void shuffle(size_t *order, size_t count, uint32_t round) {
    uint32_t state = round * 2654435761u + 1;
    for (size_t i = 0; i < count; i++)
        order[i] = i;
    for (size_t i = count; i > 1; i--) {
        state = state * 1664525u + 1013904223u;
        const size_t j = (state >> 8) % i, swap = order[i - 1];
        order[i - 1] = order[j];
        order[j] = swap;
    }
}

static int visit(sweep *w, size_t at, size_t configuration, const sweep_place *place,
                 uint32_t round) {
    const json_t *list = json_object_get(case_at(w, at), "configurations");
    char what[160];
    snprintf(what, sizeof what, "round %u of %u: %.120s", round + 1, sweep_rounds(w->options),
             cli_get(json_array_get(list, configuration), "name"));
    sweep_progress(w, what);
    const int status = sweep_time(w, at, configuration, place, round);
    return status == CLI_DONE ? sweep_save(w) : status;
}

/* Those whose pace was far from the usual one, once more: to divide by it is no exact science. */
static int visit_again(sweep *w, size_t at, const sweep_place *place, uint32_t round) {
    static const char *const found[] = {"rounds", "cpu_ms", "pace_ms"};
    const json_t *one = case_at(w, at), *list = json_object_get(one, "configurations");
    const double usual = sweep_pace_usual(one, 0);
    int status = CLI_DONE;
    for (size_t i = 0; i < json_array_size(list) && status == CLI_DONE; i++) {
        const json_t *c = json_array_get(list, i);
        const json_t *pace = json_array_get(json_object_get(c, "pace_ms"), round);
        if (!is_open(c) || json_array_size(json_object_get(c, "pace_ms")) != round + 1 ||
            !(json_number_value(pace) > SWEEP_DISTURBED * usual))
            continue;
        for (size_t k = 0; k < sizeof found / sizeof *found; k++)
            json_array_remove(json_object_get(c, found[k]), round);
        status = visit(w, at, i, place, round);
    }
    return status;
}

static double first_visit(const json_t *c) {
    double values[SWEEP_VISIT];
    size_t i, count = 0;
    const json_t *value;
    json_array_foreach(json_array_get(cli_array(c, "rounds"), 0), i, value) {
        if (count < SWEEP_VISIT)
            values[count++] = json_number_value(value);
    }
    return sweep_median(values, count);
}

/* How much slower the device was at the first visit of one than at that of another. */
static double slower_at(const json_t *one, const json_t *other) {
    const double pace = json_number_value(json_array_get(cli_array(one, "pace_ms"), 0)),
                 theirs = json_number_value(json_array_get(cli_array(other, "pace_ms"), 0));
    return pace > 0 && theirs > 0 ? pace / theirs : 1;
}

/* Whether another is much faster, and no less accurate. */
static int is_far(const json_t *list, const json_t *c) {
    const double ms = first_visit(c), measured = sweep_measured(c), certified = sweep_certified(c);
    size_t i;
    const json_t *other;
    if (!*cli_get(c, "use"))
        return 0; /* the plan's own choice is what the others are beside */
    json_array_foreach(list, i, other) {
        const double theirs = first_visit(other);
        if (is_open(other) && strcmp(cli_get(other, "name"), "floor") != 0 && theirs > 0 &&
            ms > SWEEP_FAR * theirs * slower_at(c, other) && sweep_measured(other) <= measured &&
            sweep_certified(other) <= certified)
            return 1;
    }
    return 0;
}

/* Whether it is to be measured in this round. */
static int has_turn(const json_t *list, const json_t *c, uint32_t round) {
    const size_t visits = json_array_size(json_object_get(c, "rounds"));
    return is_open(c) && visits <= round && !(visits > 0 && is_far(list, c));
}

static int measure_round(sweep *w, size_t at, const sweep_place *place, uint32_t round) {
    const json_t *list = json_object_get(case_at(w, at), "configurations");
    const size_t count = json_array_size(list);
    size_t *order = calloc(count + 1, sizeof *order);
    int status = order ? CLI_DONE : cli_fail(CLI_FAILED, "out of memory");
    uint32_t visits = 0;
    if (order)
        shuffle(order, count, round);
    for (size_t i = 0; i < count && status == CLI_DONE; i++) {
        const json_t *c = json_array_get(list, order[i]);
        w->done++;
        if (!has_turn(list, c, round))
            continue;
        visits++;
        status = visit(w, at, order[i], place, round);
    }
    free(order);
    return status == CLI_DONE && visits > 0 ? visit_again(w, at, place, round) : status;
}

static int has_visits(const sweep *w, size_t at) {
    const json_t *list = json_object_get(case_at(w, at), "configurations"), *c;
    size_t i;
    json_array_foreach(list, i, c) {
        if (has_turn(list, c, sweep_rounds(w->options) - 1))
            return 1;
    }
    return 0;
}

/* Of this case as it is known, and as much for each one to come. */
static void expect_visits(sweep *w, size_t at) {
    const size_t count = json_array_size(json_object_get(case_at(w, at), "configurations"));
    const double visits = (double)count * (1 + sweep_rounds(w->options));
    w->total = w->done + visits * (double)(w->options->place_count - at);
}

int sweep_case(sweep *w, size_t at) {
    const sweep_place *place = &w->options->places[at];
    sweep_image reference = {0};
    int status = sweep_reopen(w, place);
    if (status == CLI_DONE)
        status = prepare(w, at, place);
    if (status == CLI_DONE) {
        expect_visits(w, at);
        status = render_reference(w, at, place, &reference);
    }
    if (status == CLI_DONE)
        status = measure_errors(w, at, place, &reference);
    if (status == CLI_DONE && has_visits(w, at))
        status = sweep_pace_begin(w, at, place);
    for (uint32_t round = 0; round < sweep_rounds(w->options) && status == CLI_DONE; round++)
        status = measure_round(w, at, place, round);
    sweep_pace_end(w);
    sweep_image_free(&reference);
    strata_scene_close(w->scene);
    strata_close(w->s);
    w->scene = NULL;
    w->s = NULL;
    return status;
}
