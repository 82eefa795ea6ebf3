/* SPDX-License-Identifier: MIT
 *
 * json_get FILE [PATH]: checks that FILE is exactly one JSON object, and prints the value at PATH
 * ("techniques/0/technique"; "#" at the end counts an array). Status 1 when either is not so.
 */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const json_t *step(const json_t *value, const char *key) {
    if (json_is_array(value))
        return json_array_get(value, strtoul(key, NULL, 10));
    return json_object_get(value, key);
}

static int print(const json_t *value) {
    if (!value)
        return 1;
    if (json_is_string(value))
        return puts(json_string_value(value)) < 0;
    if (json_is_real(value))
        return printf("%.9g\n", json_real_value(value)) < 0;
    return json_dumpf(value, stdout, JSON_ENCODE_ANY | JSON_COMPACT | JSON_SORT_KEYS) != 0 ||
           puts("") < 0;
}

int main(int argc, char **argv) {
    json_error_t error;
    json_t *root = argc < 2 ? NULL : json_load_file(argv[1], JSON_REJECT_DUPLICATES, &error);
    if (!json_is_object(root)) {
        fprintf(stderr, "json_get: %s: %s\n", argc < 2 ? "" : argv[1],
                root ? "no object" : error.text);
        json_decref(root);
        return 1;
    }
    const json_t *value = root;
    char *path = argc > 2 ? argv[2] : NULL;
    int status = 0;
    for (char *key = path ? strtok(path, "/") : NULL; key && value; key = strtok(NULL, "/")) {
        if (strcmp(key, "#") == 0) {
            status = printf("%zu\n", json_array_size(value)) < 0;
            path = NULL;
            break;
        }
        value = step(value, key);
    }
    if (path)
        status = print(value);
    json_decref(root);
    return status;
}
