/* SPDX-License-Identifier: MIT
 *
 * The binary interface does not move unseen: constants, sizes and offsets of abi/strata equal those
 * of offsets.golden, in C and in C++, with no padding that has no name. That the headers compile
 * alone is checked by the objects linked into this program (see CMakeLists.txt).
 *
 *     test_abi --write      writes offsets.golden anew, after a change that is meant
 */
#define _POSIX_C_SOURCE 200809L
#include "abi/layout.h"
#include "base/base.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char *layout_text(void (*print)(FILE *)) {
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    print(out);
    fclose(out);
    return text;
}

static char *source_text(const char *name) {
    const char *source = getenv("STRATA_TEST_SOURCE");
    char *path = base_format("%s/%s", source ? source : ".", name);
    unsigned char *data = NULL;
    size_t size;
    base_error err = {0};
    if (base_file_read(path, 1u << 20, &data, &size, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    free(path);
    return (char *)data;
}

/* Names the first line that differs, and in which struct. */
static void assert_equal_lines(const char *a, const char *what_a, const char *b,
                               const char *what_b) {
    char in[128] = "";
    while (*a || *b) {
        size_t length_a = strcspn(a, "\n"), length_b = strcspn(b, "\n");
        if (strncmp(a, "struct ", 7) == 0)
            snprintf(in, sizeof in, "%.*s", (int)length_a, a);
        if (length_a != length_b || memcmp(a, b, length_a) != 0)
            fail_msg("%s: %s has \"%.*s\", %s has \"%.*s\"; if the change is meant, run "
                     "test_abi --write",
                     in, what_a, (int)length_a, a, what_b, (int)length_b, b);
        a += length_a + (a[length_a] == '\n');
        b += length_b + (b[length_b] == '\n');
    }
}

static void test_golden(void **state) {
    (void)state;
    char *layout = layout_text(abi_layout_c), *golden = source_text("tests/abi/offsets.golden");
    assert_equal_lines(layout, "the header", golden, "offsets.golden");
    free(golden);
    free(layout);
}

static void test_cpp(void **state) {
    (void)state;
    char *c = layout_text(abi_layout_c), *cpp = layout_text(abi_layout_cpp);
    assert_equal_lines(c, "C", cpp, "C++");
    free(cpp);
    free(c);
}

/* Fields follow each other without a hole, so every byte has a name. */
static void test_padding(void **state) {
    (void)state;
    char *layout = layout_text(abi_layout_c), *rest;
    char type[128] = "", field[128];
    size_t size = 0, end = 0, holes = 0;
    for (char *line = strtok_r(layout, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        size_t offset, bytes;
        /* NOLINTBEGIN(cert-err34-c): this program wrote the numbers itself */
        if (sscanf(line, "struct %127s %zu", type, &size) == 2) {
            end = 0;
        } else if (line[0] == ' ' && sscanf(line, " %127s %zu %zu", field, &offset, &bytes) == 3) {
            if (offset != end)
                print_error("%s: %zu bytes without a name before %s\n", type, offset - end, field);
            holes += offset != end;
            end = offset + bytes;
            /* NOLINTEND(cert-err34-c) */
        } else if (strncmp(line, "end ", 4) == 0) {
            if (end != size)
                print_error("%s: %zu bytes without a name at its end\n", type, size - end);
            holes += end != size;
        }
    }
    free(layout);
    assert_int_equal(holes, 0);
}

/* Every struct begins with its size, but for handles and embedded GLSL, which never grow. */
static void test_struct_size(void **state) {
    (void)state;
    static const char *const fixed[] = {"strata_buffer", "strata_image", "strata_program",
                                        "strata_pool",   "strata_draws", "strata_glsl"};
    char *layout = layout_text(abi_layout_c), *rest;
    char type[128] = "";
    size_t count = 0;
    for (char *line = strtok_r(layout, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
        if (sscanf(line, "struct %127s", type) != 1)
            continue;
        int grows = 1;
        for (size_t i = 0; i < BASE_COUNT(fixed); i++)
            grows &= strcmp(fixed[i], type) != 0;
        line = strtok_r(NULL, "\n", &rest);
        if (grows && strcmp(line, "  struct_size 0 4") != 0)
            fail_msg("%s begins with \"%s\"", type, line);
        count++;
    }
    free(layout);
    assert_in_range(count, 30, 200);
}

/* Is `name` a whole argument of `macro` in abi.def? */
static int is_listed(const char *def, const char *macro, const char *name, size_t length) {
    char *entry = base_format("%s(%.*s)", macro, (int)length, name);
    int found = strstr(def, entry) != NULL;
    free(entry);
    return found;
}

static size_t check_lines(const char *header, const char *text, const char *def) {
    size_t found = 0;
    for (const char *line = text; line; line = strchr(line, '\n')) {
        line += *line == '\n';
        const char *type = strncmp(line, "typedef struct ", 15) == 0 ? line + 15
                           : strncmp(line, "struct ", 7) == 0        ? line + 7
                                                                     : NULL;
        if (type) {
            size_t length = strcspn(type, " ;");
            if (strncmp(type + length, " {", 2) == 0) {
                found++;
                if (!is_listed(def, "STRUCT", type, length))
                    fail_msg("%s: struct %.*s is not in abi.def", header, (int)length, type);
            }
        } else if (strncmp(line, "#define STRATA_", 15) == 0) {
            size_t length = strcspn(line + 8, " (\n");
            const char *value = line + 8 + length;
            /* Numbers only: no macros with parameters, texts or header guards. */
            if (value[0] == ' ' && strchr("(-0123456789", value[1])) {
                found++;
                if (!is_listed(def, "CONSTANT", line + 8, length))
                    fail_msg("%s: %.*s is not in abi.def", header, (int)length, line + 8);
            }
        }
    }
    return found;
}

static void test_complete(void **state) {
    (void)state;
    static const char *const headers[] = {"base.h",       "effect.h", "ext/gl.h",
                                          "ext/vulkan.h", "frame.h",  "gpu.h",
                                          "host.h",       "scene.h",  "technique.h"};
    char *def = source_text("tests/abi/abi.def"), *all = source_text("abi/strata/strata.h");
    size_t found = 0;
    for (size_t i = 0; i < BASE_COUNT(headers); i++) {
        char *path = base_format("abi/strata/%s", headers[i]);
        char *text = source_text(path);
        found += check_lines(path, text, def);
        if (!strstr(all, headers[i]))
            fail_msg("strata.h does not include %s", headers[i]);
        free(text);
        free(path);
    }
    assert_in_range(found, 100, 1000);
    free(all);
    free(def);
}

static int write_golden(void) {
    const char *source = getenv("STRATA_TEST_SOURCE");
    char *path = base_format("%s/tests/abi/offsets.golden", source ? source : ".");
    FILE *out = path ? fopen(path, "w") : NULL;
    free(path);
    if (!out) {
        perror("offsets.golden");
        return 1;
    }
    abi_layout_c(out);
    return fclose(out) == 0 ? 0 : 1;
}

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "--write") == 0)
        return write_golden();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_golden),   cmocka_unit_test(test_cpp),
        cmocka_unit_test(test_padding),  cmocka_unit_test(test_struct_size),
        cmocka_unit_test(test_complete),
    };
    return cmocka_run_group_tests_name("abi", tests, NULL, NULL);
}
