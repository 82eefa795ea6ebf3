/* SPDX-License-Identifier: MIT
 *
 * What every part of the host leans on: one error value, growable text and arrays, whole-file
 * reading and writing beside-then-rename, a hash, a clock, and the log. Below everything else in
 * cli -> render -> {plan, modules, scene} -> gpu; knows nothing about rendering.
 */
#ifndef STRATA_HOST_BASE_H
#define STRATA_HOST_BASE_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "strata/base.h"

#define BASE_COUNT(a) (sizeof(a) / sizeof((a)[0]))

/* ---- errors ---------------------------------------------------------------------------------
 * One bounded line and the result that goes with it. A function that can fail takes a `base_error *`
 * as its last parameter, fills it once, and returns the same result. The first failure is kept. */
typedef struct base_error {
    strata_result result;
    char text[512];
} base_error;

/* Formats the line (control characters become '?', over-long text ends in "..."), returns `result`.
 * Does nothing but return `result` when err is NULL or already holds a failure. */
strata_result base_fail(base_error *err, strata_result result, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* ---- memory ---------------------------------------------------------------------------------
 * All return NULL on overflow of count * size and on exhaustion; the caller reports
 * STRATA_ERROR_OUT_OF_HOST_MEMORY. Freed with free(). */
void *base_calloc(size_t count, size_t size);
void *base_realloc(void *old, size_t count, size_t size); /* old stays valid on failure */
char *base_strdup(const char *text);
char *base_format(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Makes room for one more element in a growing array: doubles *capacity as needed. Returns the
 * (possibly moved) array or NULL, in which case the old one is untouched. */
void *base_grow(void *array, size_t *capacity, size_t count, size_t size);

/* ---- structs of the ABI ---------------------------------------------------------------------
 * Copies what both sides know of a struct that begins with its size into the `size` bytes at `out`,
 * whose struct_size becomes `size`; what the caller's version lacks stays as it was. Returns 0, and
 * copies nothing, when struct_size is not set or a part that this version does not know is not zero. */
int base_take(void *out, size_t size, const void *given);

/* ---- growing text --------------------------------------------------------------------------- */
typedef struct base_text { /* zero-initialised = empty; free with base_text_free */
    char *data;            /* NUL-terminated once anything was added; NULL while empty */
    size_t length, capacity;
    int failed; /* an allocation failed: contents are incomplete, further additions do nothing */
} base_text;

void base_text_add(base_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
void base_text_append(base_text *text, const char *bytes, size_t length);
void base_text_free(base_text *text);

/* ---- files ----------------------------------------------------------------------------------
 * Reads a whole regular file of at most `limit` bytes; one NUL follows the data and is not counted.
 * Errors name the path and the system's reason. The caller frees *data. */
strata_result base_file_read(const char *path, size_t limit, unsigned char **data, size_t *size,
                             base_error *err);

/* A file that appears whole or not at all: opened beside `path` under a unique name, renamed over it
 * by commit, removed by abort. Signal-safe removal of whatever is still open: base_files_abort_all. */
typedef struct base_output {
    char path[4096], temporary[4096];
    int fd;
} base_output;
strata_result base_output_open(base_output *out, const char *path, base_error *err);
strata_result base_output_write(base_output *out, const void *data, size_t size, base_error *err);
strata_result base_output_commit(base_output *out, base_error *err); /* fsync-free; closes */
void base_output_abort(base_output *out);                            /* idempotent */
void base_files_abort_all(void); /* async-signal-safe */

/* Creates every missing folder of `path` (mode 0777 & umask). */
strata_result base_make_folders(const char *path, base_error *err);

/* ---- hash, clock, log ----------------------------------------------------------------------- */
uint64_t base_hash(uint64_t seed, const void *data, size_t size); /* FNV-1a, 64 bit */
double base_now_ms(void);                                         /* monotonic */
double base_cpu_ms(void);                                         /* of this process, all threads */

typedef enum base_level { BASE_LOG_ERROR, BASE_LOG_WARNING, BASE_LOG_INFO, BASE_LOG_DEBUG } base_level;

/* One line to stderr ("strata: ..."), kept when level <= the level of STRATA_LOG (error, warning,
 * info, debug or 0..3; default warning). Thread-safe per line. */
void base_log(base_level level, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
