/* SPDX-License-Identifier: MIT
 *
 * What the loader's tests share: a scratch folder, and changed copies of the test module.
 */
#ifndef STRATA_TESTS_MODULES_FIXTURE_H
#define STRATA_TESTS_MODULES_FIXTURE_H

#include <stddef.h>

/* A scratch folder, as cmocka's group set-up and tear-down. */
extern char fixture_folder[64];
int fixture_make_folder(void **state);
int fixture_remove_folder(void **state);
void fixture_empty_folder(void);

/* The bytes of a file of the build's tests/modules ("fixture.so"); the caller frees. */
unsigned char *fixture_read(const char *name, size_t *size);

/* Writes a file into the scratch folder; the path is valid until the next call. */
const char *fixture_write(const char *name, const void *data, size_t size);

/* Replaces the first `from` in the module's note by `to`, of the same length. */
void fixture_replace(unsigned char *module, size_t size, const char *from, const char *to);

/* The first of the note's bytes (JSON). */
unsigned char *fixture_note(unsigned char *module, size_t size);

#endif
