/* SPDX-License-Identifier: MIT
 *
 * Reading of paths, strictly: what is not understood is refused with its place. Then the pose at a
 * time: linear between keys, or for eye and target a Catmull-Rom curve over uneven times.
 */
#include "cli/path.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_FILE   ((size_t)16 << 20) /* bytes */
#define MAX_TIME   1e9
#define MAX_NUMBER 1e29 /* a curve through such keys stays within the 1e30 of poses */
#define YFOV       45.0

typedef struct reader {
    const char *file;
    size_t key; /* that is being read */
    path_camera_fn camera;
    void *user;
    char *line;
} reader;

static int refuse(const reader *r, const char *format, ...) __attribute__((format(printf, 2, 3)));
static int refuse(const reader *r, const char *format, ...) {
    va_list arguments;
    const int at = snprintf(r->line, PATH_LINE, "%.200s: ", r->file);
    va_start(arguments, format);
    vsnprintf(r->line + at, PATH_LINE - (size_t)at, format, arguments);
    va_end(arguments);
    return 0;
}

/* ---- members of a key ------------------------------------------------------------------------ */

static int read_number(const reader *r, const json_t *key, const char *name, double low,
                       double high, double *out) {
    const json_t *value = json_object_get(key, name);
    if (!value)
        return 1;
    if (!json_is_number(value))
        return refuse(r, "key %zu: %s: expected a number", r->key, name);
    *out = json_number_value(value);
    if (!(*out >= low && *out <= high))
        return refuse(r, "key %zu: %s: %.9g is not from %.9g to %.9g", r->key, name, *out, low,
                      high);
    return 1;
}

static int read_vector(const reader *r, const json_t *key, const char *name, double out[3]) {
    const json_t *value = json_object_get(key, name);
    if (!value)
        return 1;
    int right = json_is_array(value) && json_array_size(value) == 3;
    for (size_t i = 0; i < 3 && right; i++) {
        const json_t *number = json_array_get(value, i);
        out[i] = json_number_value(number);
        right = json_is_number(number) && fabs(out[i]) <= MAX_NUMBER;
    }
    return right ? 1 : refuse(r, "key %zu: %s: expected three numbers within 1e29", r->key, name);
}

static int read_flag(const reader *r, const json_t *key, const char *name, int *out) {
    const json_t *value = json_object_get(key, name);
    if (value && !json_is_boolean(value))
        return refuse(r, "key %zu: %s: expected true or false", r->key, name);
    *out = json_is_true(value);
    return 1;
}

static int known_members(const reader *r, const json_t *object, const char *const *names,
                         const char *place) {
    const char *name;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)object, name, value) {
        size_t i = 0;
        while (names[i] && strcmp(names[i], name) != 0)
            i++;
        if (!names[i])
            return refuse(r, "%sunknown member '%.64s'", place, name);
    }
    return 1;
}

static int read_named(const reader *r, const json_t *key, strata_camera_pose *pose) {
    static const char *const others[] = {"eye", "target", "up", "yfov", "height", "near", "far"};
    char line[PATH_LINE];
    const char *name = json_string_value(json_object_get(key, "camera"));
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        if (json_object_get(key, others[i]))
            return refuse(r, "key %zu: %s: the camera says that", r->key, others[i]);
    if (!name)
        return refuse(r, "key %zu: camera: expected a name", r->key);
    return r->camera(r->user, name, pose, line)
               ? 1
               : refuse(r, "key %zu: camera: %.250s", r->key, line);
}

static int read_pose(const reader *r, const json_t *key, strata_camera_pose *pose) {
    *pose = (strata_camera_pose){.struct_size = sizeof *pose, .up = {0, 1, 0}, .yfov = YFOV};
    if (json_object_get(key, "camera"))
        return read_named(r, key, pose);
    if (!json_object_get(key, "eye") || !json_object_get(key, "target"))
        return refuse(r, "key %zu: expected eye and target, or camera", r->key);
    if (!read_vector(r, key, "eye", pose->eye) || !read_vector(r, key, "target", pose->target) ||
        !read_vector(r, key, "up", pose->up) ||
        !read_number(r, key, "yfov", 1e-3, 179.0, &pose->yfov) ||
        !read_number(r, key, "height", 0, MAX_NUMBER, &pose->height) ||
        !read_number(r, key, "near", 0, MAX_NUMBER, &pose->near) ||
        !read_number(r, key, "far", 0, MAX_NUMBER, &pose->far))
        return 0;
    if (pose->up[0] == 0 && pose->up[1] == 0 && pose->up[2] == 0)
        return refuse(r, "key %zu: up: it has no direction", r->key);
    if (pose->far != 0 && pose->far <= pose->near)
        return refuse(r, "key %zu: far: it is not beyond near", r->key);
    return 1;
}

static int apart(const strata_camera_pose *pose) {
    double sum = 0;
    for (int i = 0; i < 3; i++)
        sum += (pose->eye[i] - pose->target[i]) * (pose->eye[i] - pose->target[i]);
    return sum > 0;
}

static int read_key(const reader *r, const json_t *key, path_key *out) {
    static const char *const names[] = {"time", "eye",    "target", "up",  "yfov", "height",
                                        "near", "camera", "cut",    "far", NULL};
    char place[32];
    const path_key *before = r->key > 0 ? out - 1 : NULL;
    snprintf(place, sizeof place, "key %zu: ", r->key);
    if (!json_is_object(key))
        return refuse(r, "key %zu: expected an object", r->key);
    if (!known_members(r, key, names, place))
        return 0;
    if (!json_object_get(key, "time"))
        return refuse(r, "key %zu: time is missing", r->key);
    if (!read_number(r, key, "time", -MAX_TIME, MAX_TIME, &out->time) ||
        !read_flag(r, key, "cut", &out->cut) || !read_pose(r, key, &out->pose))
        return 0;
    if (before && !(out->time > before->time))
        return refuse(r, "key %zu: time: %.9g is not after the key before, at %.9g", r->key,
                      out->time, before->time);
    if (!apart(&out->pose))
        return refuse(r, "key %zu: target: the eye is there", r->key);
    if (before && !out->cut && (before->pose.height > 0) != (out->pose.height > 0))
        return refuse(r, "key %zu: orthographic and perspective do not blend: cut here", r->key);
    return 1;
}

/* ---- the file -------------------------------------------------------------------------------- */

static int read_root(reader *r, const json_t *root, cli_path *out) {
    static const char *const names[] = {"curve", "keys", NULL};
    const json_t *keys = json_object_get(root, "keys"), *curve = json_object_get(root, "curve");
    const char *name = curve ? json_string_value(curve) : "linear";
    if (!json_is_object(root))
        return refuse(r, "expected an object with keys");
    if (!known_members(r, root, names, ""))
        return 0;
    if (!name || (strcmp(name, "linear") != 0 && strcmp(name, "smooth") != 0))
        return refuse(r, "curve: expected \"linear\" or \"smooth\"");
    if (!json_is_array(keys) || json_array_size(keys) == 0)
        return refuse(r, "keys: expected an array of at least one key");
    out->smooth = strcmp(name, "smooth") == 0;
    out->keys = calloc(json_array_size(keys), sizeof *out->keys);
    if (!out->keys)
        return refuse(r, "out of memory");
    for (r->key = 0; r->key < json_array_size(keys); r->key++)
        if (!read_key(r, json_array_get(keys, r->key), &out->keys[r->key]))
            return 0;
    out->count = r->key;
    return 1;
}

typedef struct source {
    FILE *stream;
    size_t size;
    int failed; /* errno */
} source;

static size_t feed(void *buffer, size_t size, void *user) {
    source *s = user;
    const size_t count = fread(buffer, 1, size, s->stream);
    if (count == 0 && ferror(s->stream))
        s->failed = errno;
    s->size += count;
    return s->size > MAX_FILE || s->failed ? (size_t)-1 : count;
}

int path_read(const char *file, path_camera_fn camera, void *user, cli_path *out,
              char line[PATH_LINE]) {
    reader r = {.file = file, .camera = camera, .user = user, .line = line};
    source from = {.stream = fopen(file, "rbe")};
    json_error_t error;
    *out = (cli_path){0};
    if (!from.stream)
        return refuse(&r, "%s", strerror(errno));
    json_t *root =
        json_load_callback(feed, &from, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &error);
    fclose(from.stream);
    if (from.failed)
        refuse(&r, "%s", strerror(from.failed));
    else if (from.size > MAX_FILE)
        refuse(&r, "a path has at most 16 MiB");
    else if (!root)
        refuse(&r, "line %d, column %d: %.200s", error.line, error.column, error.text);
    const int done = root && read_root(&r, root, out);
    json_decref(root);
    if (!done)
        path_free(out);
    return done;
}

void path_free(cli_path *p) {
    free(p->keys);
    *p = (cli_path){0};
}

/* ---- the pose at a time ---------------------------------------------------------------------- */

static double mix(double a, double b, double u) {
    return a + (b - a) * u;
}

/* The curve's change over a segment of `length` seconds at key i, if it kept its slope: that of the
 * chord through the neighbours, or of the segment itself where the curve ends or a cut is. */
static double change(const cli_path *p, size_t i, size_t segment, size_t offset, double length) {
    const int first = i == 0 || p->keys[i].cut;
    const int last = i + 1 == p->count || p->keys[i + 1].cut;
    const size_t a = first || last ? segment : i - 1, b = first || last ? segment + 1 : i + 1;
    const double from = *(const double *)((const char *)&p->keys[a].pose + offset);
    const double to = *(const double *)((const char *)&p->keys[b].pose + offset);
    return (to - from) * (length / (p->keys[b].time - p->keys[a].time));
}

static double curve(const cli_path *p, size_t segment, size_t offset, double u) {
    const path_key *a = &p->keys[segment], *b = a + 1;
    const double from = *(const double *)((const char *)&a->pose + offset);
    const double to = *(const double *)((const char *)&b->pose + offset);
    if (!p->smooth)
        return mix(from, to, u);
    const double length = b->time - a->time, v = 1 - u;
    return from * (v * v * (1 + 2 * u)) + to * (u * u * (1 + 2 * v)) +
           change(p, segment, segment, offset, length) * (u * v * v) -
           change(p, segment + 1, segment, offset, length) * (u * u * v);
}

strata_camera_pose path_pose(const cli_path *p, double time) {
    size_t low = 0, high = p->count; /* the last key that is not after time, or the first */
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (p->keys[middle].time <= time)
            low = middle;
        else
            high = middle;
    }
    const path_key *a = &p->keys[low], *b = a + 1;
    strata_camera_pose pose = a->pose;
    if (time <= a->time || low + 1 == p->count || b->cut)
        return pose;
    const double u = (time - a->time) / (b->time - a->time);
    for (size_t i = 0; i < 3; i++) {
        pose.eye[i] = curve(p, low, offsetof(strata_camera_pose, eye) + i * sizeof(double), u);
        pose.target[i] =
            curve(p, low, offsetof(strata_camera_pose, target) + i * sizeof(double), u);
        pose.up[i] = mix(pose.up[i], b->pose.up[i], u);
    }
    pose.yfov = mix(pose.yfov, b->pose.yfov, u);
    pose.height = mix(pose.height, b->pose.height, u);
    pose.near = fmin(pose.near, b->pose.near);
    pose.far = pose.far > 0 && b->pose.far > 0 ? fmax(pose.far, b->pose.far) : 0;
    return pose;
}

double path_time(const cli_path *p, uint32_t frame, uint32_t frames, double fps) {
    const double first = p->keys[0].time, last = p->keys[p->count - 1].time;
    if (fps > 0)
        return first + frame / fps;
    return frame == 0            ? first
           : frame + 1 == frames ? last
                                 : mix(first, last, frame / (frames - 1.0));
}

int path_meets_target(const cli_path *p, uint32_t frames, double fps, uint32_t *frame) {
    for (*frame = 0; *frame < frames; ++*frame) {
        const strata_camera_pose pose = path_pose(p, path_time(p, *frame, frames, fps));
        if (!apart(&pose))
            return 1;
    }
    return 0;
}
