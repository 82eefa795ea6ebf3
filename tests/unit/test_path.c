/* SPDX-License-Identifier: MIT
 *
 * host/cli/path: poses at keys are the keys', cuts are not blended over, curves pass evenly; frames
 * begin and end at the ends; and files that say nonsense are refused with their place.
 */
#define _GNU_SOURCE

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "cli/path.h"

#define COUNT(a) (sizeof(a) / sizeof *(a))

static char file[] = "/tmp/strata-path-XXXXXX";

static void write_text(const char *text, size_t size) {
    FILE *out = fopen(file, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(text, 1, size, out), size);
    assert_int_equal(fclose(out), 0);
}

/* Knows "front" and "flat" (orthographic). */
static int camera(void *user, const char *name, strata_camera_pose *out, char line[PATH_LINE]) {
    (void)user;
    *out = (strata_camera_pose){.struct_size = sizeof *out, .eye = {7, 8, 9}, .up = {0, 0, 1}};
    out->height = strcmp(name, "flat") == 0 ? 2 : 0;
    if (strcmp(name, "front") == 0 || out->height > 0)
        return 1;
    snprintf(line, PATH_LINE, "no camera '%s'", name);
    return 0;
}

static cli_path read_text(const char *text) {
    char line[PATH_LINE] = "";
    cli_path p;
    write_text(text, strlen(text));
    if (!path_read(file, camera, NULL, &p, line))
        fail_msg("%s", line);
    return p;
}

/* `text` refused with a line that begins with the file's name and has `said`. */
static void refused(const char *text, size_t size, const char *said) {
    char line[PATH_LINE] = "";
    cli_path p;
    write_text(text, size);
    if (path_read(file, camera, NULL, &p, line))
        fail_msg("taken: %.200s", text);
    if (strncmp(line, file, strlen(file)) != 0 || !strstr(line, said) || strchr(line, '\n'))
        fail_msg("'%s' does not say '%s'", line, said);
    assert_null(p.keys);
}

static void same_pose(const strata_camera_pose *a, const strata_camera_pose *b) {
    assert_memory_equal(a, b, sizeof *a);
}

#define KEYS                                                                                       \
    "\"keys\":["                                                                                   \
    "{\"time\":-1,\"eye\":[0.1,0.2,0.3],\"target\":[1,1,1]},"                                      \
    "{\"time\":0.7,\"eye\":[3,-1,0.7],\"target\":[0,1,1],\"up\":[0.3,1,0],\"yfov\":33.3},"         \
    "{\"time\":1.1,\"camera\":\"front\",\"cut\":true},"                                            \
    "{\"time\":3.3,\"eye\":[1e3,1e-3,7],\"target\":[0,0,0],\"near\":0.1,\"far\":9},"               \
    "{\"time\":4,\"eye\":[1,2,7],\"target\":[0,0,0],\"near\":0.05,\"far\":5}]"

static void keys_are_exact(void **state) {
    static const char *const texts[] = {"{" KEYS "}", "{\"curve\":\"smooth\"," KEYS "}"};
    (void)state;
    for (size_t t = 0; t < COUNT(texts); t++) {
        cli_path p = read_text(texts[t]);
        assert_int_equal(p.count, 5);
        for (size_t i = 0; i < p.count; i++) {
            const strata_camera_pose pose = path_pose(&p, p.keys[i].time);
            same_pose(&pose, &p.keys[i].pose);
        }
        const strata_camera_pose before = path_pose(&p, -1e9), after = path_pose(&p, 1e9);
        same_pose(&before, &p.keys[0].pose);
        same_pose(&after, &p.keys[4].pose);
        const strata_camera_pose between = path_pose(&p, 3.5); /* sees what either key sees */
        assert_true(between.near == 0.05 && between.far == 9);
        path_free(&p);
    }
}

static void cuts_are_not_blended(void **state) {
    static const char *const texts[] = {"{" KEYS "}", "{\"curve\":\"smooth\"," KEYS "}"};
    (void)state;
    for (size_t t = 0; t < COUNT(texts); t++) {
        cli_path p = read_text(texts[t]);
        const strata_camera_pose middle = path_pose(&p, 0.9);
        const strata_camera_pose last = path_pose(&p, nextafter(1.1, 0));
        same_pose(&middle, &p.keys[1].pose);
        same_pose(&last, &p.keys[1].pose);
        path_free(&p);
    }
    /* nor does a curve bend towards what lies behind one: from key 0 to 1 it is a straight line */
    cli_path p = read_text("{\"curve\":\"smooth\"," KEYS "}");
    const strata_camera_pose quarter = path_pose(&p, -1 + 0.25 * 1.7);
    for (int i = 0; i < 3; i++) {
        const double a = p.keys[0].pose.eye[i], b = p.keys[1].pose.eye[i];
        assert_true(fabs(quarter.eye[i] - (a + (b - a) * 0.25)) < 1e-12);
    }
    const strata_camera_pose behind = path_pose(&p, 2);
    p.keys[1].pose.eye[0] = p.keys[1].pose.target[1] = 1000;
    const strata_camera_pose same = path_pose(&p, 2);
    same_pose(&behind, &same);
    path_free(&p);
}

static void lines_are_linear(void **state) {
    (void)state;
    cli_path p = read_text("{" KEYS "}");
    const strata_camera_pose pose = path_pose(&p, -1 + 0.5 * 1.7), *a = &p.keys[0].pose,
                             *b = &p.keys[1].pose;
    for (int i = 0; i < 3; i++) {
        assert_true(fabs(pose.eye[i] - (a->eye[i] + b->eye[i]) / 2) < 1e-12);
        assert_true(fabs(pose.target[i] - (a->target[i] + b->target[i]) / 2) < 1e-12);
        assert_true(fabs(pose.up[i] - (a->up[i] + b->up[i]) / 2) < 1e-12);
    }
    assert_true(fabs(pose.yfov - (45 + 33.3) / 2) < 1e-12);
    assert_true(pose.near == 0 && pose.far == 0);
    path_free(&p);
}

/* On x = t^2 the chord's slope at inner keys is the parabola's where times are even; and evenly
 * spaced points on a line, at uneven times of the same speed, stay on it at that speed. */
static void curves_keep_their_slope(void **state) {
    (void)state;
    cli_path p = read_text("{\"curve\":\"smooth\",\"keys\":["
                           "{\"time\":0,\"eye\":[0,0,5],\"target\":[0,0,0]},"
                           "{\"time\":1,\"eye\":[1,2,5],\"target\":[0,0,0]},"
                           "{\"time\":2,\"eye\":[4,4,5],\"target\":[0,0,0]},"
                           "{\"time\":3,\"eye\":[9,6,5],\"target\":[0,0,0]}]}");
    for (int i = 0; i <= 8; i++) {
        const double t = 1 + i / 8.0;
        const strata_camera_pose pose = path_pose(&p, t);
        assert_true(fabs(pose.eye[0] - t * t) < 1e-12);
        assert_true(fabs(pose.eye[1] - 2 * t) < 1e-12);
        assert_true(fabs(pose.eye[2] - 5) < 1e-12);
    }
    path_free(&p);
    p = read_text("{\"curve\":\"smooth\",\"keys\":["
                  "{\"time\":0,\"eye\":[0,0,5],\"target\":[0,0,0]},"
                  "{\"time\":0.5,\"eye\":[1,0,5],\"target\":[0,0,0]},"
                  "{\"time\":3,\"eye\":[6,0,5],\"target\":[0,0,0]}]}");
    for (int i = 0; i <= 24; i++)
        assert_true(fabs(path_pose(&p, i / 8.0).eye[0] - i / 4.0) < 1e-12);
    path_free(&p);
}

static void frames_span_the_path(void **state) {
    (void)state;
    cli_path p = read_text("{" KEYS "}");
    assert_true(path_time(&p, 0, 1, 0) == -1);
    for (uint32_t frames = 2; frames < 100; frames++) {
        assert_true(path_time(&p, 0, frames, 0) == -1);
        assert_true(path_time(&p, frames - 1, frames, 0) == 4);
    }
    assert_true(path_time(&p, 1, 3, 0) == 1.5);
    assert_true(path_time(&p, 5, 9, 10) == -0.5);
    p.keys[0].time = -1e8; /* so that the sum of first and length is not the last */
    p.keys[4].time = 0.1;
    assert_true(path_time(&p, 8, 9, 0) == 0.1);
    path_free(&p);
}

static void meetings_are_found(void **state) {
    uint32_t frame;
    (void)state;
    cli_path p = read_text("{\"keys\":[{\"time\":0,\"eye\":[1,0,0],\"target\":[-1,0,0]},"
                           "{\"time\":1,\"eye\":[-1,0,0],\"target\":[1,0,0]}]}");
    assert_int_equal(path_meets_target(&p, 4, 0, &frame), 0);
    assert_int_equal(path_meets_target(&p, 5, 0, &frame), 1);
    assert_int_equal(frame, 2);
    path_free(&p);
}

/* ---- what is refused ------------------------------------------------------------------------- */

#define POSE "\"eye\":[0,0,1],\"target\":[0,0,0]"

static void nonsense_is_refused(void **state) {
    static const struct {
        const char *text, *said;
    } cases[] = {
        {"", "line 1"},
        {"[]", "expected an object"},
        {"1", "line 1"},
        {"{", "line 1"},
        {"{}", "keys: expected an array"},
        {"{\"keys\":[]}", "at least one key"},
        {"{\"keys\":{}}", "keys: expected an array"},
        {"{\"keys\":[1]}", "key 0: expected an object"},
        {"{\"keys\":[{" POSE "}]}", "key 0: time is missing"},
        {"{\"keys\":[{\"time\":\"0\"," POSE "}]}", "key 0: time: expected a number"},
        {"{\"keys\":[{\"time\":NaN," POSE "}]}", "line 1, column"},
        {"{\"keys\":[{\"time\":1e999," POSE "}]}", "line 1, column"},
        {"{\"keys\":[{\"time\":2e9," POSE "}]}", "key 0: time: 2e+09 is not from"},
        {"{\"keys\":[{\"time\":0," POSE "},{\"time\":0," POSE "}]}", "key 1: time: 0 is not after"},
        {"{\"keys\":[{\"time\":1," POSE "},{\"time\":0," POSE "}]}", "key 1: time: 0 is not after"},
        {"{\"keys\":[{\"time\":0,\"eye\":[0,0,1]}]}", "key 0: expected eye and target, or camera"},
        {"{\"keys\":[{\"time\":0,\"target\":[0,0,1]}]}", "key 0: expected eye and target"},
        {"{\"keys\":[{\"time\":0,\"eye\":[0,1],\"target\":[0,0,0]}]}",
         "key 0: eye: expected three"},
        {"{\"keys\":[{\"time\":0,\"eye\":[0,1,2,3],\"target\":[0,0,0]}]}", "key 0: eye: expected"},
        {"{\"keys\":[{\"time\":0,\"eye\":[0,1,null],\"target\":[0,0,0]}]}", "key 0: eye: expected"},
        {"{\"keys\":[{\"time\":0,\"eye\":[0,1,1e30],\"target\":[0,0,0]}]}", "key 0: eye: expected"},
        {"{\"keys\":[{\"time\":0,\"eye\":{},\"target\":[0,0,0]}]}", "key 0: eye: expected three"},
        {"{\"keys\":[{\"time\":0,\"eye\":[0,0,0],\"target\":[0,0,0]}]}", "key 0: target: the eye"},
        {"{\"keys\":[{\"time\":0,\"eye\":[1e-300,0,0],\"target\":[0,0,0]}]}", "target: the eye"},
        {"{\"keys\":[{\"time\":0," POSE ",\"up\":[0,0,0]}]}", "key 0: up: it has no direction"},
        {"{\"keys\":[{\"time\":0," POSE ",\"yfov\":0}]}", "key 0: yfov: 0 is not from"},
        {"{\"keys\":[{\"time\":0," POSE ",\"yfov\":180}]}", "key 0: yfov: 180 is not from"},
        {"{\"keys\":[{\"time\":0," POSE ",\"height\":-1}]}", "key 0: height: -1 is not"},
        {"{\"keys\":[{\"time\":0," POSE ",\"near\":-1}]}", "key 0: near: -1 is not"},
        {"{\"keys\":[{\"time\":0," POSE ",\"near\":1,\"far\":1}]}", "key 0: far: it is not beyond"},
        {"{\"keys\":[{\"time\":0," POSE ",\"cut\":1}]}", "key 0: cut: expected true or false"},
        {"{\"keys\":[{\"time\":0," POSE ",\"fov\":1}]}", "key 0: unknown member 'fov'"},
        {"{\"keys\":[{\"time\":0," POSE ",\"camera\":\"front\"}]}", "key 0: eye: the camera says"},
        {"{\"keys\":[{\"time\":0,\"camera\":7}]}", "key 0: camera: expected a name"},
        {"{\"keys\":[{\"time\":0,\"camera\":\"back\"}]}", "key 0: camera: no camera 'back'"},
        {"{\"keys\":[{\"time\":0," POSE "},{\"time\":1,\"camera\":\"flat\"}]}",
         "key 1: orthographic and perspective"},
        {"{\"keys\":[{\"time\":0,\"time\":1," POSE "}]}", "line 1, column"},
        {"{\"keys\":[{\"time\":0," POSE "}]} x", "line 1, column"},
        {"{\"key\":[]}", "unknown member 'key'"},
        {"{\"curve\":\"bent\",\"keys\":[{\"time\":0," POSE "}]}", "curve: expected"},
        {"{\"curve\":1,\"keys\":[{\"time\":0," POSE "}]}", "curve: expected"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT(cases); i++)
        refused(cases[i].text, strlen(cases[i].text), cases[i].said);
    cli_path p = read_text("{\"keys\":[{\"time\":0," POSE "},{\"time\":1,\"cut\":true,\"camera\":"
                           "\"flat\"}]}"); /* apart by a cut they may follow each other */
    path_free(&p);
}

static void floods_are_refused(void **state) {
    (void)state;
    const size_t size = ((size_t)16 << 20) + 2;
    char *text = malloc(size);
    assert_non_null(text);
    memset(text, '[', size); /* deeper than any parser's stack */
    refused(text, 1 << 20, "line 1, column");
    memset(text, ' ', size);
    refused(text, size, "at most 16 MiB");
    text[0] = '\0';
    refused(text, 4, "line 1");
    free(text);
}

/* Every prefix of a path, and every byte of it replaced, is taken whole or refused in one line. */
static void damage_is_survived(void **state) {
    static const char text[] = "{\"curve\":\"smooth\"," KEYS "}";
    char copy[sizeof text], line[PATH_LINE];
    cli_path p;
    (void)state;
    for (size_t i = 0; i + 1 < sizeof text; i++)
        for (int kind = 0; kind < 4; kind++) {
            memcpy(copy, text, sizeof text);
            copy[i] = "\"9-["[kind];
            write_text(copy, kind == 3 ? i : sizeof text - 1);
            line[0] = '\0';
            if (path_read(file, camera, NULL, &p, line))
                for (uint32_t frame = 0; frame < 7; frame++) {
                    const strata_camera_pose pose = path_pose(&p, path_time(&p, frame, 7, 0));
                    assert_true(isfinite(pose.eye[0]) && isfinite(pose.target[2]));
                }
            else
                assert_true(line[0] && !strchr(line, '\n'));
            path_free(&p);
        }
}

static void files_are_named(void **state) {
    char line[PATH_LINE];
    cli_path p;
    (void)state;
    assert_int_equal(path_read("/nowhere/path.json", camera, NULL, &p, line), 0);
    assert_non_null(strstr(line, "/nowhere/path.json: No such file"));
    assert_int_equal(path_read("/tmp", camera, NULL, &p, line), 0);
    assert_non_null(strstr(line, "/tmp: Is a directory"));
}

static int make_file(void **state) {
    (void)state;
    const int fd = mkstemp(file);
    return fd < 0 ? -1 : close(fd);
}

static int remove_file(void **state) {
    (void)state;
    return unlink(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_are_exact),       cmocka_unit_test(cuts_are_not_blended),
        cmocka_unit_test(lines_are_linear),     cmocka_unit_test(curves_keep_their_slope),
        cmocka_unit_test(frames_span_the_path), cmocka_unit_test(meetings_are_found),
        cmocka_unit_test(nonsense_is_refused),  cmocka_unit_test(floods_are_refused),
        cmocka_unit_test(damage_is_survived),   cmocka_unit_test(files_are_named),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
