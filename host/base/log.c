/* SPDX-License-Identifier: MIT
 *
 * Hash, clocks and the log of base.h. The log's level is read from the environment once; a line is
 * one write(2), so that lines of several threads do not mix.
 */
#define _POSIX_C_SOURCE 200809L
#include "base/base.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

uint64_t base_hash(uint64_t seed, const void *data, size_t size) {
    const unsigned char *bytes = data;
    uint64_t hash = seed ? seed : UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * UINT64_C(0x100000001b3);
    return hash;
}

static double clock_ms(clockid_t clock) {
    struct timespec now;
    if (clock_gettime(clock, &now) != 0)
        return 0.0;
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

double base_now_ms(void) {
    return clock_ms(CLOCK_MONOTONIC);
}

double base_cpu_ms(void) {
    return clock_ms(CLOCK_PROCESS_CPUTIME_ID);
}

static const char *const level_names[] = {"error", "warning", "info", "debug"};

static int level_from_environment(void) {
    const char *text = getenv("STRATA_LOG");
    if (text && text[0] >= '0' && text[0] <= '3' && text[1] == '\0')
        return text[0] - '0';
    for (int i = 0; text && i < (int)BASE_COUNT(level_names); i++)
        if (strcmp(text, level_names[i]) == 0)
            return i;
    return BASE_LOG_WARNING;
}

void base_log(base_level level, const char *format, ...) {
    static atomic_int kept = -1;
    int limit = atomic_load(&kept);
    if (limit < 0) {
        limit = level_from_environment();
        atomic_store(&kept, limit);
    }
    if ((int)level > limit || level < BASE_LOG_ERROR)
        return;

    char line[2048];
    int head = snprintf(line, sizeof line, "strata: %s: ", level_names[level]);
    va_list arguments;
    va_start(arguments, format);
    int body = vsnprintf(line + head, sizeof line - (size_t)head, format, arguments);
    va_end(arguments);
    if (head < 0 || body < 0)
        return;
    size_t length = strlen(line);
    if (line[length - 1] != '\n') {
        if (length > sizeof line - 2)
            length = sizeof line - 2;
        line[length++] = '\n';
    }
    for (const char *rest = line; length > 0;) {
        ssize_t wrote = write(STDERR_FILENO, rest, length);
        if (wrote <= 0)
            return;
        rest += wrote;
        length -= (size_t)wrote;
    }
}
