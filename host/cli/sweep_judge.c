/* SPDX-License-Identifier: MIT
 *
 * What a sweep found: medians as multiples of the floor, who is exact, the Pareto front, what must
 * hold and does not, and all of it in words.
 */
#include "cli/sweep.h"

#include <math.h>
#include <string.h>

enum { MAX_TIMES = 1024 };
#define LEAST_PACE 1e-3 /* less, or more than its inverse, is no machine's */

typedef struct judged { /* one case */
    json_t *root, *one;
    const json_t *configurations;
    double floor_ms; /* 0: not measured */
    double pace_ms;  /* of the device, usually; 0: unknown */
    int own_counts;  /* see is_candidate */
    double depth;    /* largest count of fragments in a pixel; infinite when unknown */
} judged;

/* ---- figures --------------------------------------------------------------------------------- */

static int by_value(const void *a, const void *b) {
    const double left = *(const double *)a, right = *(const double *)b;
    return left < right ? -1 : left > right;
}

double sweep_median(double *values, size_t count) {
    qsort(values, count, sizeof *values, by_value);
    return count == 0  ? 0
           : count % 2 ? values[count / 2]
                       : (values[count / 2 - 1] + values[count / 2]) / 2;
}

/* Times of each round divided by what stands for it in `pace`; NULL: as they are. */
static size_t flatten(const json_t *lists, const json_t *pace, double values[MAX_TIMES]) {
    size_t i, k, count = 0;
    const json_t *list, *value;
    json_array_foreach(lists, i, list) {
        const double slower = pace ? json_number_value(json_array_get(pace, i)) : 1;
        if (json_is_number(list) && count < MAX_TIMES)
            values[count++] = json_number_value(list) / slower;
        json_array_foreach(list, k, value) {
            if (count < MAX_TIMES)
                values[count++] = json_number_value(value) / slower;
        }
    }
    return count;
}

static int is_measured(const json_t *c) {
    return strcmp(cli_get(c, "state"), "measured") == 0;
}

static int is_floor(const json_t *c) {
    return strcmp(cli_get(c, "name"), "floor") == 0;
}

static int is_own(const json_t *c) {
    return !*cli_get(c, "use");
}

/* How many times as long as usual the floor took in each round; 1 where that is unknown. */
static void add_pace(const judged *j, json_t *c) {
    size_t i;
    const json_t *value;
    json_t *pace = json_array();
    json_array_foreach(cli_array(c, "pace_ms"), i, value) {
        const double times = json_number_value(value) / j->pace_ms; /* not a number without any */
        json_array_append_new(pace,
                              json_real(times > LEAST_PACE && times < 1 / LEAST_PACE ? times : 1));
    }
    json_object_set_new(c, "pace", pace);
}

static void add_times(json_t *c) {
    double values[MAX_TIMES];
    const json_t *pace = json_object_get(c, "pace");
    size_t count = flatten(json_object_get(c, "rounds"), pace, values);
    json_object_set_new(c, "frames", json_integer((json_int_t)count));
    const double middle = sweep_median(values, count);
    for (size_t i = 0; i < count; i++)
        values[i] = fabs(values[i] - middle);
    json_object_set_new(c, "ms", json_real(middle));
    json_object_set_new(c, "mad_ms", json_real(sweep_median(values, count)));
    count = flatten(json_object_get(c, "cpu_ms"), NULL, values);
    json_object_set_new(c, "cpu_frame_ms", json_real(sweep_median(values, count)));
}

static double depth_of(const json_t *one) {
    const json_t *depth = json_object_get(json_object_get(one, "fragments"), "max_per_pixel");
    const json_t *held = json_object_get(json_object_get(one, "complexity"), "held");
    const json_t *last = json_array_get(held, json_array_size(held) - 1);
    return json_is_number(depth)   ? json_number_value(depth)
           : json_array_size(held) ? json_number_value(json_array_get(last, 0))
                                   : INFINITY;
}

/* All fragments in their order, as they are: nothing but rounding is lost. */
static int is_exact(const judged *j, const json_t *c) {
    const double keeps = cli_number(c, "keeps"), holds = cli_number(c, "holds");
    return is_own(c) || (strcmp(cli_get(c, "payload"), "float") == 0 &&
                         strcmp(cli_get(c, "order"), "approximate") != 0 &&
                         !json_is_true(json_object_get(c, "ends_early")) &&
                         (keeps == 0 || keeps >= j->depth) && (holds == 0 || holds >= j->depth));
}

double sweep_measured(const json_t *c) {
    const json_t *max = json_object_get(json_object_get(c, "error"), "max");
    return json_is_number(max) ? json_number_value(max) : INFINITY;
}

/* Channels beyond the certificate: it is worth nothing. */
static double violations_of(const json_t *c) {
    return cli_number(json_object_get(c, "error"), "violations");
}

double sweep_certified(const json_t *c) {
    const json_t *max = json_object_get(json_object_get(c, "bound"), "max");
    return json_is_number(max) && violations_of(c) == 0 ? json_number_value(max) : INFINITY;
}

static int has_other_bits(const json_t *c) {
    return json_is_true(json_object_get(c, "bits")) && !(sweep_measured(c) == 0);
}

/* By what it promises, and the picture does not belie it. */
static int is_shown_exact(const judged *j, const json_t *c) {
    return is_exact(j, c) && violations_of(c) == 0 && !has_other_bits(c);
}

/* ---- the front ------------------------------------------------------------------------------- */

/* The plan's own choice is one of the others, and stands for itself only where it is not. */
static int is_candidate(const judged *j, const json_t *c) {
    return is_measured(c) && !is_floor(c) && (!is_own(c) || j->own_counts);
}

/* Whether nothing that folds is exact but what the plan chose: nothing folds, or --only left it
 * out. */
static int is_own_alone(const judged *j) {
    size_t i;
    const json_t *c;
    json_array_foreach(j->configurations, i, c) {
        if (is_measured(c) && !is_floor(c) && !is_own(c) && is_shown_exact(j, c))
            return !(j->floor_ms > 0);
    }
    return 1;
}

/* Nothing is as fast and as right, and better in one of the two. */
static int is_front(const judged *j, const json_t *c, double (*error_of)(const json_t *)) {
    const double ms = cli_number(c, "ms"), error = error_of(c);
    size_t i;
    const json_t *other;
    if (!is_candidate(j, c) || !isfinite(error))
        return 0;
    json_array_foreach(j->configurations, i, other) {
        const double theirs = error_of(other), time = cli_number(other, "ms");
        if (is_candidate(j, other) && time <= ms && theirs <= error &&
            (time < ms || theirs < error))
            return 0;
    }
    return 1;
}

static void add_figures(const judged *j) {
    size_t i;
    json_t *c;
    json_array_foreach(j->configurations, i, c) {
        json_object_set_new(c, "exact", json_boolean(!is_floor(c) && is_shown_exact(j, c)));
        json_object_set_new(c, "x_floor",
                            j->floor_ms > 0 && is_measured(c)
                                ? json_real(cli_number(c, "ms") / j->floor_ms)
                                : json_null());
        json_object_set_new(c, "front", json_boolean(is_front(j, c, sweep_measured)));
        json_object_set_new(c, "front_certified", json_boolean(is_front(j, c, sweep_certified)));
    }
}

/* The fastest whose error is at most so large; NULL: none. */
static const json_t *fastest(const judged *j, double (*error_of)(const json_t *), double most) {
    const json_t *best = NULL, *c;
    size_t i;
    json_array_foreach(j->configurations, i, c) {
        if (is_candidate(j, c) && error_of(c) <= most &&
            (!best || cli_number(c, "ms") < cli_number(best, "ms")))
            best = c;
    }
    return best;
}

static double exactness_of(const json_t *c) {
    return json_is_true(json_object_get(c, "exact")) ? 0 : INFINITY;
}

/* ---- what must hold -------------------------------------------------------------------------- */

static void violate(const judged *j, const json_t *c, const char *what, double figure) {
    json_t *line = json_sprintf("%s: %s: %s (%.4g)", cli_get(j->one, "scene"), cli_get(c, "name"),
                                what, figure);
    json_array_append_new(json_object_get(j->root, "violations"), line);
}

static void check(const judged *j, const json_t *c) {
    const json_t *error = json_object_get(c, "error");
    const int bits = json_is_true(json_object_get(c, "bits")), exact = is_exact(j, c);
    if (!json_is_object(error))
        return;
    if (violations_of(c) > 0)
        violate(j, c, "channels farther from the exact image than certified", violations_of(c));
    if (exact && has_other_bits(c))
        violate(j, c, "not the bits of the exact image, off by at most", sweep_measured(c));
    if (exact && !bits && cli_number(error, "uncertified_pixels") > 0)
        violate(j, c, "exact, but pixels are uncertified", cli_number(error, "uncertified_pixels"));
}

/* ---- in words -------------------------------------------------------------------------------- */

static void say(const judged *j, json_t *line) {
    json_array_append_new(json_object_get(j->one, "words"), line);
}

/* "3.1 x floor", or the time where there is no floor. */
static const char *cost_of(const judged *j, const json_t *c, char text[40]) {
    const double x = j->floor_ms > 0 ? cli_number(c, "ms") / j->floor_ms : 0;
    if (j->floor_ms > 0)
        snprintf(text, 40, x < 2 ? "%.2f x floor" : "%.1f x floor", x);
    else
        snprintf(text, 40, "%.3g ms", cli_number(c, "ms"));
    return text;
}

static void say_exact(const judged *j, const json_t *exact) {
    char cost[40];
    if (!exact) {
        say(j, json_string("No exact way was measured."));
        return;
    }
    if (j->floor_ms > 0)
        say(j, json_sprintf("Exact costs %s (%s): %.3g ms a frame.", cost_of(j, exact, cost),
                            cli_get(exact, "name"), cli_number(exact, "ms")));
    else
        say(j,
            json_sprintf("Exact costs %s a frame (%s); nothing is blended, so there is no floor.",
                         cost_of(j, exact, cost), cli_get(exact, "name")));
}

static void say_enough(const judged *j) {
    char cost[40];
    const json_t *certified = fastest(j, sweep_certified, SWEEP_ENOUGH),
                 *measured = fastest(j, sweep_measured, SWEEP_ENOUGH);
    if (certified && exactness_of(certified) == 0)
        say(j, json_string("An error of 1/255, certified, costs no less than exact."));
    else if (certified)
        say(j, json_sprintf("1/255, certified, costs %s (%s).", cost_of(j, certified, cost),
                            cli_get(certified, "name")));
    else
        say(j, json_string("Nothing has a certificate of 1/255 or better."));
    if (measured && measured != certified)
        say(j, json_sprintf("1/255, only as measured here, costs %s (%s).",
                            cost_of(j, measured, cost), cli_get(measured, "name")));
}

/* The same techniques with the same settings. */
static int is_same_plan(const json_t *a, const json_t *b) {
    size_t i;
    const json_t *one;
    if (json_array_size(a) == 0 || json_array_size(a) != json_array_size(b))
        return 0;
    json_array_foreach(a, i, one) {
        const json_t *other = json_array_get(b, i);
        if (strcmp(cli_get(one, "technique"), cli_get(other, "technique")) != 0 ||
            !json_equal(json_object_get(one, "settings"), json_object_get(other, "settings")))
            return 0;
    }
    return 1;
}

/* Of the configuration that the plan chose by itself; "" where none of those listed is it. */
static const char *name_of_own(const judged *j, const json_t *own) {
    size_t i;
    const json_t *c;
    json_array_foreach(j->configurations, i, c) {
        if (!is_own(c) && is_same_plan(json_object_get(own, "plan"), json_object_get(c, "plan")))
            return cli_get(c, "name");
    }
    return "";
}

static void say_own(const judged *j, const json_t *exact) {
    size_t i;
    const json_t *c;
    json_array_foreach(j->configurations, i, c) {
        const char *name = name_of_own(j, c);
        if (is_own(c) && is_measured(c) && exact && cli_number(exact, "ms") > 0)
            say(j,
                json_sprintf("The plan's own choice%s%s%s takes %.2f times as long as the fastest "
                             "exact way.",
                             *name ? " (" : "", name, *name ? ")" : "",
                             cli_number(c, "ms") / cli_number(exact, "ms")));
    }
}

/* The next slower one on the front after `last`, which may be NULL. */
static const json_t *next_on_front(const judged *j, const json_t *last) {
    const json_t *next = NULL, *c;
    size_t i;
    json_array_foreach(j->configurations, i, c) {
        if (json_is_true(json_object_get(c, "front")) &&
            (!last || cli_number(c, "ms") > cli_number(last, "ms")) &&
            (!next || cli_number(c, "ms") < cli_number(next, "ms")))
            next = c;
    }
    return next;
}

static void say_front(const judged *j) {
    cli_text text = {0};
    char part[256], cost[40];
    for (const json_t *c = next_on_front(j, NULL); c; c = next_on_front(j, c)) {
        const int length =
            snprintf(part, sizeof part, "%s%.150s (%s, off by %.2g)", text.length ? "; " : "",
                     cli_get(c, "name"), cost_of(j, c, cost), sweep_measured(c));
        cli_text_write(&text, part, (size_t)length);
    }
    if (text.length)
        say(j, json_sprintf("On the Pareto front of time and measured error: %s.", text.data));
    free(text.data);
}

static void say_counts(const judged *j, size_t violations) {
    size_t measured = 0, refused = 0, failed = 0, i;
    const json_t *c;
    json_array_foreach(j->configurations, i, c) {
        measured += (size_t)is_measured(c);
        refused += strcmp(cli_get(c, "state"), "refused") == 0;
        failed += strcmp(cli_get(c, "state"), "failed") == 0;
    }
    say(j, json_sprintf("%zu configurations measured, %zu refused by the device, %zu failed; %s",
                        measured, refused, failed,
                        violations ? "what does not hold is listed."
                                   : "every measured error is within its certificate, and exact "
                                     "ones are exact."));
    json_object_set_new(j->root, "failed",
                        json_integer((json_int_t)(cli_number(j->root, "failed") + (double)failed)));
}

/* ---- a case ---------------------------------------------------------------------------------- */

static void judge_case(json_t *root, json_t *one) {
    judged j = {.root = root,
                .one = one,
                .configurations = json_object_get(one, "configurations"),
                .pace_ms = sweep_pace_usual(one, 0),
                .depth = depth_of(one)};
    const size_t before = json_array_size(json_object_get(root, "violations"));
    size_t i;
    json_t *c;
    json_object_set_new(one, "words", json_array());
    json_array_foreach(j.configurations, i, c) {
        add_pace(&j, c);
        if (is_measured(c))
            add_times(c);
        if (is_floor(c) && is_measured(c))
            j.floor_ms = cli_number(c, "ms");
    }
    json_object_set_new(one, "pace_ms", j.pace_ms > 0 ? json_real(j.pace_ms) : json_null());
    json_object_set_new(one, "floor_ms", j.floor_ms > 0 ? json_real(j.floor_ms) : json_null());
    j.own_counts = is_own_alone(&j);
    add_figures(&j);
    json_array_foreach(j.configurations, i, c) {
        if (!is_floor(c))
            check(&j, c);
    }
    const json_t *exact = fastest(&j, exactness_of, 0);
    say_exact(&j, exact);
    say_enough(&j);
    say_own(&j, exact);
    say_front(&j);
    say_counts(&j, json_array_size(json_object_get(root, "violations")) - before);
}

void sweep_judge(json_t *root) {
    size_t i;
    json_t *one;
    json_object_set_new(root, "violations", json_array());
    json_object_set_new(root, "failed", json_integer(0));
    json_array_foreach(json_object_get(root, "cases"), i, one) {
        judge_case(root, one);
    }
}
