/* SPDX-License-Identifier: MIT
 *
 * Measured points on disk: one JSON file a device in the folder `costs` of the cache. Anyone may
 * have written it: what is not exactly of this format is ignored.
 */
#include "plan/costs.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FORMAT       3 /* counts changes of what is stored and of what the terms mean */
#define LARGEST_FILE ((size_t)8 << 20)
#define LARGEST      1e15 /* term */
#define LONGEST_MS   1e7

static int make_path(const char *folder, const char *device, char *path, size_t size) {
    const int length = snprintf(path, size, "%s/costs/%016" PRIx64 ".json", folder,
                                base_hash(0, device, strlen(device)));
    return length > 0 && (size_t)length < size;
}

static int is_name(const char *text) {
    const size_t length = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_.");
    return length > 0 && !text[length] && length < sizeof((costs_technique *)0)->name;
}

static int read_number(const json_t *value, double most, double *out) {
    *out = json_number_value(value);
    return json_is_number(value) && isfinite(*out) && *out >= 0.0 && *out <= most;
}

static const char *read_point(const json_t *object, costs_point *point) {
    const json_t *terms = json_object_get(object, "terms");
    double frames;
    *point = (costs_point){0};
    if (json_array_size(terms) != COSTS_TERMS)
        return "a point has another number of terms";
    for (size_t i = 0; i < COSTS_TERMS; i++)
        if (!read_number(json_array_get(terms, i), LARGEST, &point->terms[i]))
            return "a term is not a number in range";
    if (!read_number(json_object_get(object, "ms"), LONGEST_MS, &point->ms) || !(point->ms > 0.0))
        return "a time is not a number in range";
    if (!read_number(json_object_get(object, "frames"), 1e6, &frames) || !(frames >= 1.0))
        return "frames is not a number in range";
    point->frames = (uint32_t)frames;
    return NULL;
}

static const char *read_technique(const json_t *object, costs *c) {
    const char *name = json_string_value(json_object_get(object, "technique")), *wrong;
    const json_t *points = json_object_get(object, "points");
    costs_technique *t = &c->techniques[c->count];
    if (!name || !is_name(name))
        return "a technique has no name";
    for (uint32_t i = 0; i < c->count; i++)
        if (strcmp(c->techniques[i].name, name) == 0)
            return "a technique is there twice";
    if (!json_is_array(points) || json_array_size(points) > COSTS_MOST_POINTS)
        return "a technique has no points, or too many";
    memcpy(t->name, name, strlen(name));
    for (t->count = 0; t->count < json_array_size(points); t->count++)
        if ((wrong = read_point(json_array_get(points, t->count), &t->points[t->count])))
            return wrong;
    c->count++;
    return NULL;
}

/* What is wrong with it, or NULL. */
static const char *read_all(const json_t *root, const char *device, costs *c) {
    const json_t *techniques = json_object_get(root, "techniques");
    const char *named = json_string_value(json_object_get(root, "device")), *wrong = NULL;
    if (json_integer_value(json_object_get(root, "format")) != FORMAT)
        return "it is of another version";
    if (!named || strcmp(named, device) != 0)
        return "it is of another device";
    if (!json_is_array(techniques) || json_array_size(techniques) > COSTS_MOST_TECHNIQUES)
        return "it has no techniques, or too many";
    c->techniques = base_calloc(json_array_size(techniques) + 1, sizeof *c->techniques);
    if (!c->techniques)
        return "there is no memory for it";
    for (size_t i = 0; i < json_array_size(techniques) && !wrong; i++)
        wrong = read_technique(json_array_get(techniques, i), c);
    return wrong;
}

strata_result costs_load(const char *folder, const char *device, costs *c, base_error *err) {
    char path[4096];
    unsigned char *data = NULL;
    size_t size = 0;
    base_error none = {0};
    json_error_t where;
    *c = (costs){0};
    if (strlen(device) >= sizeof c->device)
        return base_fail(err, STRATA_ERROR_OVERFLOW, "costs: the device's name is too long");
    if (folder && make_path(folder, device, path, sizeof path) &&
        base_file_read(path, LARGEST_FILE, &data, &size, &none) == STRATA_OK) {
        json_t *root = json_loadb((const char *)data, size, JSON_REJECT_DUPLICATES, &where);
        const char *wrong = root ? read_all(root, device, c) : "it is not JSON";
        if (wrong) {
            base_log(BASE_LOG_WARNING, "%s is ignored: %s", path, wrong);
            costs_free(c);
        }
        json_decref(root);
        free(data);
    }
    memcpy(c->device, device, strlen(device) + 1);
    return STRATA_OK;
}

static json_t *technique_json(const costs_technique *t) {
    json_t *points = json_array();
    for (uint32_t i = 0; i < t->count; i++) {
        json_t *terms = json_array();
        for (int k = 0; k < COSTS_TERMS; k++)
            json_array_append_new(terms, json_real(fmin(t->points[i].terms[k], LARGEST)));
        json_array_append_new(points,
                              json_pack("{s:f, s:i, s:o}", "ms", fmin(t->points[i].ms, LONGEST_MS),
                                        "frames", (int)t->points[i].frames, "terms", terms));
    }
    return json_pack("{s:s, s:o}", "technique", t->name, "points", points);
}

strata_result costs_save(const char *folder, const costs *c, base_error *err) {
    char path[4096], *text = NULL;
    base_output out;
    json_t *techniques = json_array();
    for (uint32_t i = 0; i < c->count; i++)
        json_array_append_new(techniques, technique_json(&c->techniques[i]));
    json_t *root = json_pack("{s:i, s:s, s:o}", "format", FORMAT, "device", c->device, "techniques",
                             techniques);
    text = root ? json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(root);
    if (!text || !make_path(folder, c->device, path, sizeof path)) {
        free(text);
        return base_fail(err, STRATA_ERROR_IO, "costs: the file cannot be made");
    }
    char *slash = strrchr(path, '/');
    *slash = '\0';
    strata_result r = base_make_folders(path, err);
    *slash = '/';
    if (r == STRATA_OK)
        r = base_output_open(&out, path, err);
    if (r == STRATA_OK) {
        r = base_output_write(&out, text, strlen(text), err);
        if (r == STRATA_OK)
            r = base_output_commit(&out, err);
        else
            base_output_abort(&out);
    }
    free(text);
    return r;
}
