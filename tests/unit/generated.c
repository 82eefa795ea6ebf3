/* SPDX-License-Identifier: MIT
 *
 * One line of text to a procedural scene; see generated.h.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/generated.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

scene *generated(const char *text) {
    char copy[256], *words[16], *rest = NULL;
    uint32_t count = 0;
    scene *s = NULL;
    base_error err = {0};
    snprintf(copy, sizeof copy, "%s", text);
    for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        words[count++] = word;
    strata_result result =
        scene_generate(words[0], (const char *const *)words + 1, count - 1, &s, &err);
    if (result != STRATA_OK)
        fail_msg("%s: %s", text, err.text);
    return s;
}
