/* SPDX-License-Identifier: MIT
 *
 * A results.json that is to be gone on with: read, and checked to be such a file, to answer the
 * same question, and to hold nothing that the rest of the sweep or its report would stumble over.
 */
#define _POSIX_C_SOURCE 200809L
#include "cli/sweep.h"

#include <string.h>
#include <sys/stat.h>

#define MAX_FILE ((off_t)256 << 20)

/* ---- what it holds --------------------------------------------------------------------------- */

static int is_text(const json_t *object, const char *key) {
    return json_is_string(json_object_get(object, key));
}

static int are_all(const json_t *list, int (*is)(const json_t *)) {
    size_t i;
    const json_t *value;
    if (!json_is_array(list))
        return 0;
    json_array_foreach(list, i, value) {
        if (!is(value))
            return 0;
    }
    return 1;
}

static int is_time(const json_t *value) {
    return json_is_number(value) && json_number_value(value) >= 0 &&
           json_number_value(value) < 1e12;
}

static int is_number_or_null(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) || json_is_null(value);
}

static int is_round(const json_t *value) {
    return json_array_size(value) > 0 && json_array_size(value) <= SWEEP_VISIT &&
           are_all(value, is_time);
}

static int is_object_or_null(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return !value || json_is_null(value) || json_is_object(value);
}

static int is_error(const json_t *error) {
    static const char *const figures[] = {"max",       "rmse",       "psnr",
                                          "differing", "violations", "uncertified_pixels"};
    for (size_t i = 0; i < sizeof figures / sizeof *figures; i++)
        if (!is_number_or_null(error, figures[i]))
            return 0;
    return is_number_or_null(json_object_get(error, "flip"), "mean");
}

static int is_object(const json_t *value) {
    return json_is_object(value);
}

/* Times and state go together: what failed may have some. */
static int is_state(const char *state, const json_t *rounds) {
    const size_t count = json_array_size(rounds);
    return (strcmp(state, "pending") == 0 && count == 0) ||
           (strcmp(state, "measured") == 0 && count > 0) || strcmp(state, "failed") == 0 ||
           strcmp(state, "refused") == 0;
}

/* What was found of one; what it is will be compared with the list of those that there are. */
static int is_configuration(const json_t *c) {
    const json_t *rounds = json_object_get(c, "rounds"), *cpu = json_object_get(c, "cpu_ms"),
                 *pace = json_object_get(c, "pace_ms");
    const json_t *error = json_object_get(c, "error"), *bound = json_object_get(c, "bound"),
                 *passes = json_object_get(c, "passes");
    return are_all(rounds, is_round) && are_all(cpu, is_time) &&
           json_array_size(rounds) == json_array_size(cpu) && are_all(pace, is_time) &&
           json_array_size(rounds) == json_array_size(pace) &&
           is_state(cli_get(c, "state"), rounds) && (!error || is_error(error)) &&
           (!bound || json_is_null(bound) || is_number_or_null(bound, "max")) &&
           (!passes || are_all(passes, is_object)) && is_object_or_null(c, "bytes");
}

/* Of this place; what is rendered anew is not looked at. */
static int is_case(const json_t *c, const json_t *place) {
    return json_equal(json_object_get(c, "scene"), json_object_get(place, "scene")) &&
           json_equal(json_object_get(c, "size"), json_object_get(place, "size")) &&
           are_all(json_object_get(c, "configurations"), is_configuration) &&
           is_text(json_object_get(c, "reference"), "use");
}

/* Of the first places, in their order. */
static int are_cases(const json_t *cases, const json_t *places) {
    size_t i;
    const json_t *one;
    if (!json_is_array(cases) || json_array_size(cases) > json_array_size(places))
        return 0;
    json_array_foreach(cases, i, one) {
        if (!is_case(one, json_array_get(places, i)))
            return 0;
    }
    return 1;
}

/* A sweep that begins now, as it would be in its file; NULL: out of memory. */
static json_t *begun(const sweep_options *o) {
    json_t *fresh = sweep_begin(o);
    char *text = fresh ? json_dumps(fresh, SWEEP_JSON) : NULL;
    json_t *read = text ? json_loads(text, 0, NULL) : NULL;
    free(text);
    json_decref(fresh);
    return read;
}

/* What is wrong with it, NULL: nothing. */
static const char *wrong_with(const json_t *root, const json_t *fresh) {
    if (!fresh)
        return "out of memory";
    if (strcmp(cli_get(root, "format"), SWEEP_FORMAT) != 0)
        return "it is no sweep of this version";
    const json_t *request = json_object_get(fresh, "request");
    if (!json_equal(request, json_object_get(root, "request")))
        return "it is of another scene, size, device or set of options";
    if (!json_equal(json_object_get(fresh, "machine"), json_object_get(root, "machine")))
        return "it was measured on another machine";
    if (!are_cases(json_object_get(root, "cases"), json_object_get(request, "cases")) ||
        !is_object_or_null(root, "device"))
        return "it is damaged";
    return NULL;
}

int sweep_load(const sweep_options *o, json_t **root) {
    char path[4096];
    struct stat info;
    json_error_t error;
    *root = NULL;
    snprintf(path, sizeof path, "%s/results.json", o->folder);
    if (stat(path, &info) != 0)
        return cli_fail(CLI_FAILED, "%s: there is none to go on with", path);
    if (!S_ISREG(info.st_mode) || info.st_size > MAX_FILE)
        return cli_fail(CLI_FAILED, "%s: it is no file of results", path);
    json_t *loaded = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    json_t *fresh = begun(o);
    const char *wrong = loaded ? wrong_with(loaded, fresh) : error.text;
    json_decref(fresh);
    if (wrong) {
        cli_fail(CLI_FAILED, "%s: cannot go on with it: %s", path, wrong);
        json_decref(loaded);
        return CLI_FAILED;
    }
    json_object_set_new(loaded, "complete", json_false());
    *root = loaded;
    return CLI_DONE;
}
