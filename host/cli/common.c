/* SPDX-License-Identifier: MIT
 *
 * What the verbs share: one line for a failure, texts that the library writes, files that appear
 * whole or not at all, and reading of JSON.
 */
#define _POSIX_C_SOURCE 200809L
#include "cli/cli.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define WIDTH 100 /* of wrapped text */

/* ---- failure --------------------------------------------------------------------------------- */

static void print_line(const char *line) {
    fputs("strata: ", stderr);
    for (; *line; line++)
        fputc((unsigned char)*line < 0x20 || *line == 0x7f ? '?' : *line, stderr);
    fputc('\n', stderr);
}

int cli_fail(int status, const char *format, ...) {
    char line[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    cli_progress_end();
    print_line(line);
    return status;
}

int cli_fail_result(strata *s, strata_result result) {
    const char *line = strata_error(s);
    if (result == STRATA_ERROR_CANCELLED)
        return cli_fail(CLI_FAILED, "stopped");
    return cli_fail(result == STRATA_ERROR_INVALID_ARGUMENT ? CLI_USAGE : CLI_FAILED, "%s",
                    line[0] ? line : "it failed without a reason");
}

void cli_warn(const json_t *object) {
    const json_t *warnings = cli_array(object, "warnings");
    const char *level = getenv("STRATA_LOG");
    if (level && (strcmp(level, "error") == 0 || strcmp(level, "0") == 0))
        return;
    for (size_t i = 0; i < json_array_size(warnings); i++) {
        const char *line = json_string_value(json_array_get(warnings, i));
        cli_fail(0, "warning: %s", line ? line : "");
    }
}

/* ---- texts ----------------------------------------------------------------------------------- */

strata_result cli_text_write(void *user, const char *bytes, size_t size) {
    cli_text *text = user;
    if (size > SIZE_MAX / 4 || text->length > SIZE_MAX / 4)
        return STRATA_ERROR_OUT_OF_HOST_MEMORY;
    if (text->length + size + 1 > text->capacity) {
        size_t capacity = (text->length + size + 1) * 2;
        char *data = realloc(text->data, capacity);
        if (!data)
            return STRATA_ERROR_OUT_OF_HOST_MEMORY;
        text->data = data;
        text->capacity = capacity;
    }
    memcpy(text->data + text->length, bytes, size);
    text->length += size;
    text->data[text->length] = '\0';
    return STRATA_OK;
}

int cli_text_parse(const cli_text *text, json_t **out) {
    json_error_t error;
    *out = json_loadb(text->data ? text->data : "", text->length, 0, &error);
    return *out ? CLI_DONE
                : cli_fail(CLI_FAILED, "the library's JSON is malformed: %s", error.text);
}

int cli_text_print(const cli_text *text) {
    if (text->length && fwrite(text->data, 1, text->length, stdout) != text->length)
        return cli_fail(CLI_FAILED, "standard output: cannot write: %s", strerror(errno));
    return CLI_DONE;
}

static int write_all(int fd, const char *data, size_t size) {
    while (size > 0) {
        ssize_t wrote = write(fd, data, size);
        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote < 0)
            return errno;
        data += wrote;
        size -= (size_t)wrote;
    }
    return 0;
}

/* Devices and pipes are written to; renaming over them would replace them. */
static int save_special(const cli_text *text, const char *path) {
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    int failed = fd < 0 ? errno : write_all(fd, text->data, text->length);
    if (fd >= 0 && close(fd) != 0 && !failed)
        failed = errno;
    return failed ? cli_fail(CLI_FAILED, "%s: cannot write: %s", path, strerror(failed)) : CLI_DONE;
}

int cli_text_save(const cli_text *text, const char *path) {
    char beside[4096];
    struct stat info;
    if (strcmp(path, "-") == 0)
        return cli_text_print(text);
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode))
        return save_special(text, path);
    int length = snprintf(beside, sizeof beside, "%s.%ld.part", path, (long)getpid());
    if (length < 0 || (size_t)length >= sizeof beside)
        return cli_fail(CLI_FAILED, "%.64s...: the path is too long", path);
    int fd = open(beside, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    int failed = fd < 0 ? errno : write_all(fd, text->data, text->length);
    if (fd >= 0 && close(fd) != 0 && !failed)
        failed = errno;
    if (!failed && rename(beside, path) != 0)
        failed = errno;
    if (!failed)
        return CLI_DONE;
    if (fd >= 0)
        unlink(beside);
    return cli_fail(CLI_FAILED, "%s: cannot write: %s", path, strerror(failed));
}

int cli_check_output(const char *path) {
    char folder[4096];
    struct stat info;
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) : 0;
    if (length >= sizeof folder)
        return cli_fail(CLI_FAILED, "%.64s...: the path is too long", path);
    memcpy(folder, path, length);
    folder[length] = '\0';
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return cli_fail(CLI_FAILED, "%s: cannot write: it is a folder", path);
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return CLI_DONE;
    if (access(slash ? (length ? folder : "/") : ".", W_OK | X_OK) != 0)
        return cli_fail(CLI_FAILED, "%s: cannot write: %s", path, strerror(errno));
    return CLI_DONE;
}

int cli_has_suffix(const char *path, const char *suffix) {
    size_t length = strlen(path), end = strlen(suffix);
    return length > end && strcmp(path + length - end, suffix) == 0;
}

/* ---- JSON ------------------------------------------------------------------------------------ */

const char *cli_get(const json_t *object, const char *key) {
    const char *value = json_string_value(json_object_get(object, key));
    return value ? value : "";
}

double cli_number(const json_t *object, const char *key) {
    return json_number_value(json_object_get(object, key));
}

const json_t *cli_array(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return json_is_array(value) ? value : NULL;
}

const char *cli_count(double value, char text[40]) {
    char digits[32];
    if (!(fabs(value) < 1e15) || floor(value) != value) {
        snprintf(text, 40, "%.3g", value);
        return text;
    }
    int length = snprintf(digits, sizeof digits, "%.0f", value), out = 0;
    int sign = digits[0] == '-';
    for (int i = 0; i < length; i++) {
        if (i > sign && (length - i) % 3 == 0)
            text[out++] = ',';
        text[out++] = digits[i];
    }
    text[out] = '\0';
    return text;
}

void cli_wrap(FILE *out, int at, int indent, const char *text) {
    int fresh = 1;
    while (*text) {
        int length = (int)strcspn(text, " ");
        if (!fresh && at + 1 + length > WIDTH) {
            fputc('\n', out);
            at = 0;
            fresh = 1;
        } else if (!fresh) {
            fputc(' ', out);
            at++;
        }
        if (at < indent) {
            fprintf(out, "%*s", indent - at, "");
            at = indent;
        }
        fprintf(out, "%.*s", length, text);
        at += length;
        fresh = 0;
        text += length;
        text += strspn(text, " ");
    }
    fputc('\n', out);
}
