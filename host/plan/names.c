/* SPDX-License-Identifier: MIT
 *
 * Ids that people type: lists of them, what exists when one does not, and the nearest to a typing
 * error.
 */
#include "plan/plan_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LONGEST_NAME 63u

strata_result plan_split(const char *list, const char *option,
                         strata_result (*each)(void *user, const char *id), void *user,
                         base_error *err) {
    const char *rest = list;
    for (;;) {
        char id[LONGEST_NAME + 1];
        const char *end = strchr(rest, ',');
        const char *stop = end ? end : rest + strlen(rest);
        const char *next = stop;
        while (rest < stop && *rest == ' ')
            rest++;
        while (stop > rest && stop[-1] == ' ')
            stop--;
        if (rest == stop)
            return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s '%s': an id is missing",
                             option, list);
        size_t length = (size_t)(stop - rest);
        if (length > LONGEST_NAME)
            length = LONGEST_NAME;
        memcpy(id, rest, length);
        id[length] = '\0';
        strata_result result = each(user, id);
        if (result != STRATA_OK || !end)
            return result;
        rest = next + 1;
    }
}

/* Edits (insert, delete, replace, swap of neighbours) from a to b; names are at most LONGEST_NAME
 * long, longer ones are as far as can be. */
static unsigned distance(const char *a, const char *b) {
    unsigned rows[3][LONGEST_NAME + 2];
    unsigned *before = rows[0], *last = rows[1], *row = rows[2];
    size_t m = strlen(a), n = strlen(b);
    if (m > LONGEST_NAME || n > LONGEST_NAME)
        return LONGEST_NAME;
    for (unsigned j = 0; j <= n; j++)
        before[j] = last[j] = j;
    for (size_t i = 1; i <= m; i++) {
        row[0] = (unsigned)i;
        for (size_t j = 1; j <= n; j++) {
            unsigned best = last[j - 1] + (a[i - 1] != b[j - 1]);
            if (last[j] + 1 < best)
                best = last[j] + 1;
            if (row[j - 1] + 1 < best)
                best = row[j - 1] + 1;
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] &&
                before[j - 2] + 1 < best)
                best = before[j - 2] + 1;
            row[j] = best;
        }
        unsigned *oldest = before;
        before = last;
        last = row;
        row = oldest;
    }
    return last[n];
}

void plan_suggest(const char *name, const char *const *names, uint32_t count, char *out,
                  size_t size) {
    unsigned nearest = (unsigned)(strlen(name) < 6 ? 2 : 1 + strlen(name) / 3) + 1;
    const char *found = NULL;
    for (uint32_t i = 0; i < count; i++) {
        unsigned d = distance(name, names[i]);
        if (d < nearest && d < strlen(name)) {
            nearest = d;
            found = names[i];
        }
    }
    out[0] = '\0';
    if (found)
        snprintf(out, size, " (did you mean '%s'?)", found);
}

void plan_join(const char *const *names, uint32_t count, char *out, size_t size) {
    size_t length = 0;
    snprintf(out, size, "none");
    for (uint32_t i = 0; i < count; i++) {
        size_t need = strlen(names[i]) + (i ? 2 : 0);
        if (length + need + 5 > size) {
            snprintf(out + length, size - length, "...");
            return;
        }
        length += (size_t)snprintf(out + length, size - length, "%s%s", i ? ", " : "", names[i]);
    }
}

/* One line: what is unknown, the nearest, and all there are. */
static strata_result unknown(const char *option, const char *kind, const char *id,
                             const char *const *names, uint32_t count, base_error *err) {
    char near[96], all[256];
    plan_suggest(id, names, count, near, sizeof near);
    plan_join(names, count, all, sizeof all);
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s: there is no %s '%s'%s; installed: %s",
                     option, kind, id, near, all);
}

strata_result plan_unknown_technique(const plan_work *w, const char *option, const char *id) {
    for (uint32_t i = 0; i < w->out->effect_count; i++)
        if (strcmp(w->out->effects[i].effect->id, id) == 0)
            return base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT,
                             "%s: '%s' is an effect, not a technique; effects are chosen by "
                             "--effects and have no knobs",
                             option, id);
    const char **names = base_calloc(w->count, sizeof *names);
    if (!names)
        return base_fail(w->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
    for (uint32_t i = 0; i < w->count; i++)
        names[i] = w->candidates[i].note->id;
    strata_result result = unknown(option, "technique", id, names, w->count, w->err);
    free(names);
    return result;
}

strata_result plan_unknown_effect(const plan *p, const char *option, const char *id,
                                  base_error *err) {
    const char **names = base_calloc(p->effect_count, sizeof *names);
    if (!names)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
    for (uint32_t i = 0; i < p->effect_count; i++)
        names[i] = p->effects[i].effect->id;
    strata_result result = unknown(option, "effect", id, names, p->effect_count, err);
    free(names);
    return result;
}

strata_result plan_warn(plan_work *w, const char *format, ...) {
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    plan *p = w->out;
    for (uint32_t i = 0; i < p->warning_count; i++)
        if (strcmp(p->warnings[i], line) == 0)
            return STRATA_OK;
    char **lines = base_realloc(p->warnings, p->warning_count + 1u, sizeof *lines);
    if (lines)
        p->warnings = lines;
    char *copy = lines ? base_strdup(line) : NULL;
    if (!copy)
        return base_fail(w->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
    lines[p->warning_count++] = copy;
    return STRATA_OK;
}
