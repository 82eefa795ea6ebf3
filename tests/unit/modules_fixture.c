/* SPDX-License-Identifier: MIT
 *
 * Changed copies of the test module, for test_notes.c and test_modules.c.
 */
#define _GNU_SOURCE
#include "unit/modules_fixture.h"

#include "base/base.h"

#include <dirent.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

char fixture_folder[64];

int fixture_make_folder(void **state) {
    (void)state;
    snprintf(fixture_folder, sizeof fixture_folder, "/tmp/strata-modules-XXXXXX");
    return mkdtemp(fixture_folder) ? 0 : -1;
}

void fixture_empty_folder(void) {
    DIR *folder = opendir(fixture_folder);
    assert_non_null(folder);
    for (struct dirent *file = readdir(folder); file; file = readdir(folder))
        if (file->d_name[0] != '.')
            unlinkat(dirfd(folder), file->d_name, 0);
    closedir(folder);
}

int fixture_remove_folder(void **state) {
    (void)state;
    fixture_empty_folder();
    return rmdir(fixture_folder);
}

unsigned char *fixture_read(const char *name, size_t *size) {
    char path[4096];
    snprintf(path, sizeof path, "%s/tests/modules/%s", getenv("STRATA_TEST_BUILD"), name);
    unsigned char *data;
    base_error err = {0};
    if (base_file_read(path, 1u << 24, &data, size, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return data;
}

const char *fixture_write(const char *name, const void *data, size_t size) {
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", fixture_folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    return path;
}

unsigned char *fixture_note(unsigned char *module, size_t size) {
    unsigned char *note = memmem(module, size, "{\"id\":\"fixture\"", 15);
    assert_non_null(note);
    return note;
}

void fixture_replace(unsigned char *module, size_t size, const char *from, const char *to) {
    unsigned char *note = fixture_note(module, size);
    assert_int_equal(strlen(from), strlen(to));
    unsigned char *at = memmem(note, size - (size_t)(note - module), from, strlen(from));
    assert_non_null(at);
    memcpy(at, to, strlen(to));
}
