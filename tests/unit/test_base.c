/* SPDX-License-Identifier: MIT
 *
 * host/base: error lines, checked allocation, growing text, files that appear whole or not at all,
 * the hash against published values, the log's levels and lines.
 */
#define _POSIX_C_SOURCE 200809L
#include "base/base.h"

#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64];

static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/strata-base-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static const char *place(const char *name) {
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, 256, "%s/%s", folder, name);
    return path;
}

/* Number of entries in the folder whose name contains `part`. */
static int files_with(const char *part) {
    char command[256];
    int count = -1;
    snprintf(command, sizeof command, "ls '%s' | grep -c -- '%s'", folder, part);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    assert_int_equal(fscanf(pipe, "%d", &count), 1);
    pclose(pipe);
    return count;
}

static void write_file(const char *path, const char *text) {
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    fclose(file);
}

static void expect_file(const char *path, const char *text) {
    unsigned char *data;
    size_t size;
    base_error err = {0};
    assert_int_equal(base_file_read(path, 1000, &data, &size, &err), STRATA_OK);
    assert_int_equal(size, strlen(text));
    assert_memory_equal(data, text, size + 1);
    free(data);
}

/* ---- errors ---------------------------------------------------------------------------------- */

static void error_keeps_the_first_failure(void **state) {
    base_error err = {0};
    (void)state;
    assert_int_equal(base_fail(&err, STRATA_ERROR_IO, "%s %d", "first", 1), STRATA_ERROR_IO);
    assert_int_equal(base_fail(&err, STRATA_ERROR_SHADER, "second"), STRATA_ERROR_SHADER);
    assert_string_equal(err.text, "first 1");
    assert_int_equal(err.result, STRATA_ERROR_IO);
    assert_int_equal(base_fail(NULL, STRATA_ERROR_IO, "unheard"), STRATA_ERROR_IO);
}

static void error_is_one_printable_line(void **state) {
    base_error err = {0};
    (void)state;
    base_fail(&err, STRATA_ERROR_IO, "a\nb\tc\x1b[1m\x7f");
    assert_string_equal(err.text, "a?b?c?[1m?");
}

static void error_is_cut_between_characters(void **state) {
    char text[1200];
    (void)state;
    for (size_t shift = 0; shift < 4; shift++) {
        base_error err = {0};
        memset(text, 'x', sizeof text);
        for (size_t i = shift; i + 3 < sizeof text; i += 3)
            memcpy(text + i, "\xe2\x82\xac", 3); /* a euro sign */
        text[sizeof text - 1] = '\0';
        base_fail(&err, STRATA_ERROR_IO, "%s", text);
        size_t length = strlen(err.text);
        assert_true(length < sizeof err.text && length > sizeof err.text - 8);
        assert_string_equal(err.text + length - 3, "...");
        assert_int_equal((length - 3 - shift) % 3, 0);
    }
}

/* ---- memory and text ------------------------------------------------------------------------- */

static void allocation_refuses_overflow(void **state) {
    (void)state;
    volatile size_t huge = SIZE_MAX / 2;
    assert_null(base_calloc(huge, 4));
    void *old = base_calloc(4, 4);
    assert_non_null(old);
    assert_null(base_realloc(old, huge, 4));
    memset(old, 1, 16); /* still ours */
    free(old);
    void *none = base_calloc(0, 8);
    assert_non_null(none);
    free(none);
}

static void arrays_grow(void **state) {
    uint32_t *array = NULL;
    size_t capacity = 0;
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        uint32_t *larger = base_grow(array, &capacity, i, sizeof *array);
        assert_non_null(larger);
        assert_true(capacity > i);
        array = larger;
        array[i] = i * 3;
    }
    for (uint32_t i = 0; i < 1000; i++)
        assert_int_equal(array[i], i * 3);
    size_t full = SIZE_MAX / 2 + 1;
    assert_null(base_grow(array, &full, full, 1));
    free(array);
}

static void text_grows(void **state) {
    base_text text = {0};
    (void)state;
    for (int i = 0; i < 500; i++)
        base_text_add(&text, "%d,", i % 10);
    base_text_append(&text, "end\0!", 5);
    assert_int_equal(text.failed, 0);
    assert_int_equal(text.length, 1005);
    assert_memory_equal(text.data, "0,1,2,3,", 8);
    assert_memory_equal(text.data + 1000, "end\0!", 6);
    base_text_free(&text);
    assert_null(text.data);
    base_text_append(&text, "", 0);
    assert_string_equal(text.data, "");
    base_text_free(&text);
    char *made = base_format("%s-%03d", "a", 7);
    assert_string_equal(made, "a-007");
    free(made);
}

static void failed_text_stays_failed(void **state) {
    base_text text = {0};
    (void)state;
    base_text_append(&text, "abc", 3);
    text.length = SIZE_MAX - 1; /* as if it were that long */
    base_text_append(&text, "defg", 4);
    assert_int_equal(text.failed, 1);
    text.length = 3;
    base_text_add(&text, "more");
    assert_string_equal(text.data, "abc");
    base_text_free(&text);
}

/* ---- files ----------------------------------------------------------------------------------- */

static void reading_names_what_is_wrong(void **state) {
    unsigned char *data;
    size_t size;
    base_error err = {0};
    (void)state;
    write_file(place("five"), "12345");
    expect_file(place("five"), "12345");
    assert_int_equal(base_file_read(place("five"), 4, &data, &size, &err), STRATA_ERROR_BAD_FILE);
    assert_non_null(strstr(err.text, "five"));
    assert_null(data);
    err = (base_error){0};
    assert_int_equal(base_file_read(place("none"), 4, &data, &size, &err), STRATA_ERROR_NOT_FOUND);
    assert_non_null(strstr(err.text, "none: cannot open: No such file"));
    err = (base_error){0};
    assert_int_equal(base_file_read(folder, 4, &data, &size, &err), STRATA_ERROR_IO);
    assert_non_null(strstr(err.text, "not a regular file"));
    assert_int_equal(mkfifo(place("fifo"), 0600), 0);
    assert_int_equal(base_file_read(place("fifo"), 4, &data, &size, NULL), STRATA_ERROR_IO);
}

static void output_appears_on_commit_only(void **state) {
    base_output out;
    base_error err = {0};
    (void)state;
    write_file(place("image"), "old");
    assert_int_equal(base_output_open(&out, place("image"), &err), STRATA_OK);
    assert_int_equal(base_output_write(&out, "new", 3, &err), STRATA_OK);
    expect_file(place("image"), "old");
    assert_int_equal(files_with("image"), 2);
    assert_int_equal(base_output_commit(&out, &err), STRATA_OK);
    expect_file(place("image"), "new");
    assert_int_equal(files_with("image"), 1);
    base_output_abort(&out); /* nothing left to do */
    expect_file(place("image"), "new");
}

static void aborted_output_leaves_nothing(void **state) {
    base_output out, never = {0};
    base_error err = {0};
    (void)state;
    assert_int_equal(base_output_open(&out, place("gone"), &err), STRATA_OK);
    assert_int_equal(base_output_write(&out, "x", 1, &err), STRATA_OK);
    assert_int_equal(files_with("gone"), 1);
    base_output_abort(&out);
    base_output_abort(&out);
    assert_int_equal(files_with("gone"), 0);
    base_output_abort(&never); /* and standard input is still open */
    assert_true(fcntl(STDIN_FILENO, F_GETFD) >= 0);
}

static void output_refuses_folders(void **state) {
    base_output out;
    base_error err = {0};
    (void)state;
    assert_int_equal(base_output_open(&out, folder, &err), STRATA_ERROR_IO);
    assert_non_null(strstr(err.text, "Is a directory"));
    err = (base_error){0};
    assert_int_equal(base_output_open(&out, place("no/where"), &err), STRATA_ERROR_NOT_FOUND);
    assert_int_equal(base_output_open(&out, "", NULL), STRATA_ERROR_INVALID_ARGUMENT);
}

/* A pipe stands for devices: renaming a file over it would take its place. */
static void output_writes_into_pipes(void **state) {
    base_output out;
    base_error err = {0};
    struct stat info;
    char text[4] = "";
    (void)state;
    assert_int_equal(mkfifo(place("pipe"), 0600), 0);
    int reader = open(place("pipe"), O_RDONLY | O_NONBLOCK);
    assert_true(reader >= 0);
    assert_int_equal(base_output_open(&out, place("pipe"), &err), STRATA_OK);
    assert_int_equal(base_output_write(&out, "abc", 3, &err), STRATA_OK);
    assert_int_equal(base_output_commit(&out, &err), STRATA_OK);
    assert_int_equal(read(reader, text, 3), 3);
    assert_string_equal(text, "abc");
    close(reader);
    assert_int_equal(stat(place("pipe"), &info), 0);
    assert_true(S_ISFIFO(info.st_mode));
}

static void remove_all(int number) {
    (void)number;
    base_files_abort_all();
    _exit(7);
}

static void a_signal_removes_open_outputs(void **state) {
    int status = 0;
    (void)state;
    write_file(place("kept"), "kept");
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        base_output a, b, done;
        signal(SIGTERM, remove_all);
        if (base_output_open(&a, place("part-a"), NULL) ||
            base_output_open(&b, place("part-b"), NULL) ||
            base_output_open(&done, place("whole"), NULL) || base_output_commit(&done, NULL))
            _exit(1);
        raise(SIGTERM);
        _exit(2);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 7);
    assert_int_equal(files_with("part-"), 0);
    assert_int_equal(files_with("whole"), 1);
    assert_int_equal(files_with("kept"), 1);
}

static void folders_are_made(void **state) {
    struct stat info;
    base_error err = {0};
    (void)state;
    assert_int_equal(base_make_folders(place("a/b//c"), &err), STRATA_OK);
    assert_int_equal(base_make_folders(place("a/b/c"), &err), STRATA_OK);
    assert_int_equal(stat(place("a/b/c"), &info), 0);
    assert_true(S_ISDIR(info.st_mode));
    write_file(place("a/file"), "");
    assert_int_not_equal(base_make_folders(place("a/file/d"), &err), STRATA_OK);
    assert_non_null(strstr(err.text, "a/file"));
    assert_int_not_equal(base_make_folders(place("a/file"), NULL), STRATA_OK);
}

/* ---- hash, clock, log ------------------------------------------------------------------------ */

static void hash_is_fnv1a(void **state) {
    (void)state;
    assert_true(base_hash(0, "", 0) == UINT64_C(0xcbf29ce484222325));
    assert_true(base_hash(0, "a", 1) == UINT64_C(0xaf63dc4c8601ec8c));
    assert_true(base_hash(0, "foobar", 6) == UINT64_C(0x85944171f73967e8));
    assert_true(base_hash(base_hash(0, "foo", 3), "bar", 3) == UINT64_C(0x85944171f73967e8));
}

static void clocks_advance(void **state) {
    (void)state;
    double wall = base_now_ms(), cpu = base_cpu_ms();
    volatile double work = 0.0;
    while (base_cpu_ms() < cpu + 5.0)
        work += 1.0;
    assert_true(base_now_ms() > wall + 1.0);
}

/* What a child process with STRATA_LOG=level writes for one line of each level. */
static void logged(const char *level, char *text, size_t size) {
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDERR_FILENO);
        if (level)
            setenv("STRATA_LOG", level, 1);
        else
            unsetenv("STRATA_LOG");
        base_log(BASE_LOG_ERROR, "e%d", 1);
        base_log(BASE_LOG_WARNING, "w\n");
        base_log(BASE_LOG_INFO, "i");
        base_log(BASE_LOG_DEBUG, "%03000d", 0);
        _exit(0);
    }
    close(ends[1]);
    size_t length = 0;
    ssize_t got;
    while ((got = read(ends[0], text + length, size - 1 - length)) > 0)
        length += (size_t)got;
    text[length] = '\0';
    close(ends[0]);
    waitpid(child, NULL, 0);
}

static void log_keeps_its_level(void **state) {
    char text[8192];
    (void)state;
    logged(NULL, text, sizeof text);
    assert_string_equal(text, "strata: error: e1\nstrata: warning: w\n");
    logged("error", text, sizeof text);
    assert_string_equal(text, "strata: error: e1\n");
    logged("2", text, sizeof text);
    assert_string_equal(text, "strata: error: e1\nstrata: warning: w\nstrata: info: i\n");
    logged("debug", text, sizeof text);
    assert_int_equal(text[strlen(text) - 1], '\n');
    assert_non_null(strstr(text, "strata: debug: 0000"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(error_keeps_the_first_failure),
        cmocka_unit_test(error_is_one_printable_line),
        cmocka_unit_test(error_is_cut_between_characters),
        cmocka_unit_test(allocation_refuses_overflow),
        cmocka_unit_test(arrays_grow),
        cmocka_unit_test(text_grows),
        cmocka_unit_test(failed_text_stays_failed),
        cmocka_unit_test(reading_names_what_is_wrong),
        cmocka_unit_test(output_appears_on_commit_only),
        cmocka_unit_test(aborted_output_leaves_nothing),
        cmocka_unit_test(output_refuses_folders),
        cmocka_unit_test(output_writes_into_pipes),
        cmocka_unit_test(a_signal_removes_open_outputs),
        cmocka_unit_test(folders_are_made),
        cmocka_unit_test(hash_is_fnv1a),
        cmocka_unit_test(clocks_advance),
        cmocka_unit_test(log_keeps_its_level),
    };
    return cmocka_run_group_tests_name("base", tests, make_folder, remove_folder);
}
