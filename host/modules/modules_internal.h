/* SPDX-License-Identifier: MIT
 *
 * What the files of host/modules share, with each other, the build tool strata-note and the unit
 * tests: the two sources of a modules_note (an ELF note's JSON, a C descriptor), the checks that
 * hold for both, and the JSON that the tool writes and the loader compares.
 *
 *     file --note_elf_read--> JSON --note_parse--> modules_note <--descriptor_note-- strata_module
 */
#ifndef STRATA_HOST_MODULES_INTERNAL_H
#define STRATA_HOST_MODULES_INTERNAL_H

#include "modules/modules.h"

#define NOTE_NAME     "Strata"  /* owner of the ELF note, in section .note.strata */
#define NOTE_TYPE     1u        /* its desc is JSON, UTF-8, without a terminator */
#define NOTE_SIZE_MAX 0x100000u /* bytes of JSON */

/* Memory that is freed at once; zero-initialised = empty. */
typedef struct note_block note_block;
typedef struct note_arena {
    note_block *blocks;
} note_arena;
void *note_alloc(note_arena *arena, size_t count, size_t size); /* zeroed; NULL when exhausted */
void note_arena_free(note_arena *arena);

/* Reads the note of a shared object of this machine's kind. Every offset and size is checked
 * against the file. NOT_FOUND: no Strata note; BAD_FILE: not such a file, truncated, malformed. The
 * caller frees *text, which is NUL-terminated. */
strata_result note_elf_read(const char *path, char **text, base_error *err);

/* JSON -> note, checked with note_check. Unknown members are ignored: a newer tool may write more.
 */
strata_result note_parse(const char *text, const char *path, note_arena *arena, modules_note *out,
                         base_error *err);

/* Descriptor -> note that points into it; struct sizes, NULL pointers and tails are checked here,
 * the rest with note_check. MODULE names the member that is wrong. */
strata_result descriptor_note(const strata_module *module, const char *path, note_arena *arena,
                              modules_note *out, base_error *err);

/* Syntax of ids, ranges of numbers, duplicates. MODULE or OVERFLOW. */
strata_result note_check(const modules_note *note, base_error *err);

/* Can this host run a module built with `abi` that asks for at least `min_host`? VERSION says why
 * not. */
strata_result note_check_version(uint32_t abi, uint32_t min_host, uint32_t host, base_error *err);

/* Note -> compact JSON, one line, the same bytes for the same note. The caller frees it. NULL when
 * memory is exhausted or a text is not UTF-8 (err says which). */
char *note_json(const modules_note *note, base_error *err);

#endif
