/* SPDX-License-Identifier: MIT
 *
 * host/modules: the ELF note reader against files that lie, the JSON of a note, and the rules that
 * a descriptor must keep.
 */
#define _GNU_SOURCE
#include "modules/modules_internal.h"
#include "unit/modules_fixture.h"

#include <elf.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmocka.h>

static char *good_note(void) {
    size_t size;
    unsigned char *data = fixture_read("fixture.so", &size);
    const char *path = fixture_write("good.so", data, size);
    free(data);
    char *text;
    base_error err = {0};
    assert_int_equal(note_elf_read(path, &text, &err), STRATA_OK);
    return text;
}

/* ---- ELF --------------------------------------------------------------------------------------
 */

/* Reads the note of a file (in memory) of these bytes; a text that is read is parsed too. */
static strata_result read_bytes(const void *data, size_t size, base_error *err) {
    char path[32], *text;
    int fd = memfd_create("bytes.so", MFD_CLOEXEC);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, data, size), size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    strata_result result = note_elf_read(path, &text, err);
    close(fd);
    if (result != STRATA_OK) {
        assert_null(text);
        assert_int_equal(err->result, result);
        assert_ptr_equal(strstr(err->text, path), err->text);
        return result;
    }
    note_arena arena = {0};
    modules_note note;
    result = note_parse(text, path, &arena, &note, err);
    assert_int_equal(err->result, result);
    note_arena_free(&arena);
    free(text);
    return result;
}

static void test_elf_good(void **state) {
    (void)state;
    char *text = good_note();
    assert_ptr_equal(strstr(text, "{\"id\":\"fixture\""), text);
    assert_string_equal(text + strlen(text) - 2, "]}");
    free(text);
}

static void test_elf_truncated(void **state) {
    (void)state;
    size_t size;
    unsigned char *data = fixture_read("fixture.so", &size);
    size_t note_end = (size_t)(fixture_note(data, size) - data);
    char *text = good_note();
    note_end += strlen(text);
    free(text);
    for (size_t length = 0; length < note_end; length += length < 256 ? 1 : 37) {
        base_error err = {0};
        assert_int_equal(read_bytes(data, length, &err), STRATA_ERROR_BAD_FILE);
    }
    free(data);
}

/* Every byte of the headers and of the note set to extreme values: a result, never a crash. */
static void test_elf_flipped(void **state) {
    (void)state;
    size_t size;
    unsigned char *data = fixture_read("fixture.so", &size);
    static const unsigned char values[] = {0x00, 0x7f, 0xff};
    size_t failures = 0, headers = sizeof(Elf64_Ehdr) + 12 * sizeof(Elf64_Phdr);
    for (size_t at = 0; at < headers + 24; at++) {
        for (size_t v = 0; v < BASE_COUNT(values); v++) {
            size_t place =
                at < headers ? at : (size_t)(fixture_note(data, size) - data) - 24 + (at - headers);
            unsigned char old = data[place];
            data[place] = values[v];
            base_error err = {0};
            failures += read_bytes(data, size, &err) != STRATA_OK;
            data[place] = old;
        }
    }
    assert_in_range(failures, 50, BASE_COUNT(values) * (headers + 24));
    free(data);
}

static void test_elf_kinds(void **state) {
    (void)state;
    size_t size;
    unsigned char *data = fixture_read("fixture.so", &size);
    Elf64_Ehdr *header = (Elf64_Ehdr *)(void *)data;
    base_error err = {0};
    header->e_type = ET_EXEC;
    assert_int_equal(read_bytes(data, size, &err), STRATA_ERROR_BAD_FILE);
    assert_non_null(strstr(err.text, "not a shared object"));
    header->e_type = ET_DYN;

    err = (base_error){0};
    header->e_phnum = 0xffff;
    assert_int_equal(read_bytes(data, size, &err), STRATA_ERROR_BAD_FILE);
    assert_non_null(strstr(err.text, "impossible number"));
    free(data);

    data = fixture_read("fixture.so", &size);
    header = (Elf64_Ehdr *)(void *)data;
    err = (base_error){0};
    header->e_phoff = UINT64_MAX - 8;
    assert_int_equal(read_bytes(data, size, &err), STRATA_ERROR_BAD_FILE);
    free(data);

    err = (base_error){0};
    assert_int_equal(read_bytes("#!/bin/sh\n", 10, &err), STRATA_ERROR_BAD_FILE);
    char *text;
    err = (base_error){0};
    assert_int_equal(note_elf_read("/nonexistent.so", &text, &err), STRATA_ERROR_NOT_FOUND);
    err = (base_error){0};
    assert_int_equal(note_elf_read("/tmp", &text, &err), STRATA_ERROR_BAD_FILE);
    assert_non_null(strstr(err.text, "not a regular file"));
}

/* The same owner and type with a size that reaches out of the segment, no size, and binary data. */
static void test_elf_note_sizes(void **state) {
    (void)state;
    size_t size;
    unsigned char *data = fixture_read("fixture.so", &size);
    unsigned char *note = fixture_note(data, size);
    Elf64_Nhdr *header = (Elf64_Nhdr *)(void *)(note - 8 - sizeof *header);
    uint32_t good = header->n_descsz;
    const uint32_t bad[] = {0, good + 64, 0x7fffffff, 0xfffffffc, 0xffffffff};
    for (size_t i = 0; i < BASE_COUNT(bad); i++) {
        base_error err = {0};
        header->n_descsz = bad[i];
        assert_int_equal(read_bytes(data, size, &err), STRATA_ERROR_BAD_FILE);
    }
    header->n_descsz = good;
    base_error err = {0};
    note[20] = '\0';
    assert_int_equal(read_bytes(data, size, &err), STRATA_ERROR_BAD_FILE);
    assert_non_null(strstr(err.text, "not text"));
    note[20] = 'x';
    err = (base_error){0};
    header->n_namesz = 0xffffffff;
    assert_int_equal(read_bytes(data, size, &err), STRATA_ERROR_BAD_FILE);
    header->n_namesz = 7;
    header->n_type = 2;
    err = (base_error){0};
    assert_int_equal(read_bytes(data, size, &err), STRATA_ERROR_NOT_FOUND);
    free(data);
}

/* ---- JSON -------------------------------------------------------------------------------------
 */

static void test_json_fields(void **state) {
    (void)state;
    char *text = good_note();
    note_arena arena = {0};
    modules_note note;
    base_error err = {0};
    assert_int_equal(note_parse(text, "fixture.so", &arena, &note, &err), STRATA_OK);
    assert_string_equal(note.id, "fixture");
    assert_string_equal(note.version, "1.2");
    assert_int_equal(note.abi_version, STRATA_ABI_VERSION);
    assert_int_equal(note.technique_count, 1);
    const modules_technique_note *t = &note.techniques[0];
    assert_ptr_equal(t->module, &note);
    assert_string_equal(t->stage, "resolve");
    assert_int_equal(t->slot_count, 3);
    assert_string_equal(t->slots[0]->slot, "fragments/1");
    assert_int_equal(t->slots[0]->layouts, 1);
    assert_int_equal(t->slots[1]->use, STRATA_SLOT_UPDATES);
    assert_int_equal(t->slots[2]->optional, 1);
    assert_int_equal(t->knob_count, 3);
    assert_true(t->knobs[0]->maximum == 64.0 && t->knobs[1]->preset == 0.1);
    assert_int_equal(t->knobs[0]->trades_accuracy, 1);
    assert_null(t->knobs[1]->unit);
    assert_string_equal(t->knobs[2]->choices[1], "small");
    assert_null(t->knobs[2]->choices[2]);
    assert_int_equal(t->promises->largest_depth, 64);
    assert_true(t->cost->per_fragment == 1.1);
    assert_string_equal(t->needs[0], "feature.subgroup_ballot");
    assert_null(t->needs[1]);
    assert_string_equal(t->prefers[1], "feature.int64_atomics");
    const modules_effect_note *e = &note.effects[0];
    assert_int_equal(e->flags, STRATA_EFFECT_SEQUENTIAL);
    assert_int_equal(e->transmittance_channels, 3);
    assert_null(e->reference);
    assert_string_equal(e->payload[1]->name, "index");
    assert_int_equal(e->payload[1]->exact, 1);
    assert_true(e->called_for_by[0]->threshold == 2.5);
    assert_int_equal(e->priority, 7);
    char *again = note_json(&note, &err);
    assert_string_equal(again, text);
    free(again);
    free(text);
    note_arena_free(&arena);
}

/* Replaces the first `from` in a good note by `to` and parses it. */
static strata_result parse_changed(const char *from, const char *to, base_error *err) {
    char *text = good_note();
    size_t at = 0;
    while (text[at] && strncmp(text + at, from, strlen(from)) != 0)
        at++;
    if (!text[at])
        fail_msg("the note has no %s", from);
    char *changed = base_format("%.*s%s%s", (int)at, text, to, text + at + strlen(from));
    note_arena arena = {0};
    modules_note note;
    strata_result result = note_parse(changed, "fixture.so", &arena, &note, err);
    note_arena_free(&arena);
    free(changed);
    free(text);
    return result;
}

static void test_json_changed(void **state) {
    (void)state;
    static const struct {
        const char *from, *to, *message; /* message NULL: the note is fine */
    } cases[] = {
        {"{\"id\"", "[\"id\"", "Strata note"},
        {"\"id\":\"fixture\",", "", "module: \"\" is not an id"},
        {"\"id\":\"fixture\"", "\"id\":1", "\"id\" is not a text"},
        {"\"id\":\"fixture\"", "\"id\":\"Fixture\"", "is not an id"},
        {"\"id\":\"fixture\"", "\"id\":\"9fixture\"", "is not an id"},
        {"\"id\":\"fixture\"", "\"id\":\"a\",\"id\":\"b\"", "duplicate"},
        {"\"id\":\"fixture\"", "\"id\":\"fixture\",\"novelty\":[{}]", NULL},
        {"\"version\":\"1.2\",", "", "version is missing"},
        {"\"abi_version\":65536", "\"abi_version\":-1", "32-bit"},
        {"\"abi_version\":65536", "\"abi_version\":4294967296", "32-bit"},
        {"\"abi_version\":65536", "\"abi_version\":1.5", "32-bit"},
        {"\"techniques\":[", "\"techniques\":[7,", "not an object"},
        {"\"techniques\":[", "\"others\":[", NULL},
        {"\"stage\":\"resolve\"", "\"stage\":\"dance\"", "unknown stage"},
        {"\"slots\":[", "\"slots\":[[],", "not an object"},
        {"fragments/1", "fragments", "is not a slot"},
        {"fragments/1", "fragments/", "is not a slot"},
        {"fragments/1", "fragments/1x", "is not a slot"},
        {"fragments/1", "color/1", "color/1 names the unknown layouts 0x1"},
        {"limit/1", "color/1", "names slot color/1 twice"},
        {"\"layouts\":1", "\"layouts\":0", "names no layout"},
        {"\"layouts\":1", "\"layouts\":3", NULL},
        {"\"layouts\":1", "\"layouts\":5", "unknown layouts 0x5"},
        {"\"layouts\":0", "\"layouts\":1", "unknown layouts 0x1"},
        {"\"optional\":0", "\"optional\":2", "optional is 0 or 1"},
        {"\"use\":1", "\"use\":4", "unknown use"},
        {"\"type\":0", "\"type\":3", "unknown type"},
        {"\"preset\":8.0", "\"preset\":65.0", "not within"},
        {"\"preset\":8.0", "\"preset\":8", NULL},
        {"\"preset\":8.0", "\"preset\":8.5", "is an integer"},
        {"\"preset\":1.0", "\"preset\":2.0", "the index of one"},
        {"\"choices\":[\"fast\"", "\"choices\":[\"small\"", "two choices"},
        {"\"choices\":[\"fast\"", "\"choices\":[null", "is not a text"},
        {"\"name\":\"k\"", "\"name\":\"mode\"", "two knobs mode"},
        {"\"trades_accuracy\":1", "\"trades_accuracy\":2", "trades_accuracy is 0 or 1"},
        {"\"name\":\"k\"", "\"name\":\"payload\"", "payload is a choice of float, half, unorm8"},
        {"\"name\":\"mode\"", "\"name\":\"payload\"", "payload is a choice of float, half"},
        {"\"stage\":\"resolve\"", "\"stage\":\"capture\"",
         "mode is a choice of contiguous, linked"},
        {"\"id\":\"fixture\",\"title\":\"N", "\"id\":\"scene\",\"title\":\"N",
         "no technique may have this id"},
        {"\"flags\":", "\"flags\":8,\"x\":", "unknown flags 0x8"},
        {"\"promises\"", "\"other\"", "promises is missing"},
        {"\"per_pixel\":", "\"per_pixel\":-", "negative"},
        {"\"frame\":", "\"frame\":1e999,\"x\":", "Strata note"},
        {"\"order\":1", "\"order\":3", "unknown promise"},
        {"\"transmittance_channels\":3", "\"transmittance_channels\":2", "1 or 3"},
        {"\"channels\":4", "\"channels\":5", "channels are 1..4"},
        {"\"tint\"", "\"gl_tint\"", "not a GLSL name"},
        {"\"tint\"", "\"index\"", "two fields index"},
        {"materials.blend", "materials blend", "is not an id"},
    };
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        base_error err = {0};
        strata_result result = parse_changed(cases[i].from, cases[i].to, &err);
        if (!cases[i].message) {
            if (result != STRATA_OK)
                fail_msg("%s: %s", cases[i].to, err.text);
            continue;
        }
        if (result == STRATA_OK || !strstr(err.text, cases[i].message))
            fail_msg("%s: expected \"%s\", got \"%s\"", cases[i].to, cases[i].message, err.text);
    }
}

static void test_json_long(void **state) {
    (void)state;
    char id[MODULES_ID_MAX + 2];
    memset(id, 'a', sizeof id);
    id[sizeof id - 1] = '\0';
    base_error err = {0};
    assert_int_equal(parse_changed("fixture", id, &err), STRATA_ERROR_MODULE);
    id[MODULES_ID_MAX] = '\0';
    err = (base_error){0};
    assert_int_equal(parse_changed("fixture", id, &err), STRATA_OK);

    base_text choices = {0};
    for (int i = 0; i < MODULES_ARRAY_MAX; i++)
        base_text_add(&choices, "\"c%d\",", i);
    char *many = base_format("\"choices\":[%s\"fast\"", choices.data);
    err = (base_error){0};
    assert_int_equal(parse_changed("\"choices\":[\"fast\"", many, &err), STRATA_ERROR_BAD_FILE);
    free(many);
    base_text_free(&choices);

    char *deep = base_calloc(100001, 1);
    memset(deep, '[', 100000);
    note_arena arena = {0};
    modules_note note;
    err = (base_error){0};
    assert_int_equal(note_parse(deep, "deep", &arena, &note, &err), STRATA_ERROR_BAD_FILE);
    note_arena_free(&arena);
    free(deep);
}

/* ---- versions ---------------------------------------------------------------------------------
 */

static void test_versions(void **state) {
    (void)state;
    static const struct {
        uint32_t abi, min_host, host;
        strata_result result;
    } cases[] = {
        {STRATA_VERSION(1, 0), STRATA_VERSION(1, 0), STRATA_VERSION(1, 0), STRATA_OK},
        {STRATA_VERSION(1, 0), STRATA_VERSION(1, 0), STRATA_VERSION(1, 9), STRATA_OK},
        {STRATA_VERSION(1, 9), STRATA_VERSION(1, 0), STRATA_VERSION(1, 0), STRATA_OK},
        {STRATA_VERSION(1, 9), STRATA_VERSION(1, 3), STRATA_VERSION(1, 3), STRATA_OK},
        {STRATA_VERSION(1, 9), STRATA_VERSION(1, 3), STRATA_VERSION(1, 2), STRATA_ERROR_VERSION},
        {STRATA_VERSION(1, 2), STRATA_VERSION(1, 3), STRATA_VERSION(1, 9), STRATA_ERROR_VERSION},
        {STRATA_VERSION(2, 0), STRATA_VERSION(1, 0), STRATA_VERSION(1, 0), STRATA_ERROR_VERSION},
        {STRATA_VERSION(0, 0), STRATA_VERSION(0, 0), STRATA_VERSION(1, 0), STRATA_ERROR_VERSION},
        {UINT32_MAX, UINT32_MAX, STRATA_VERSION(1, 0), STRATA_ERROR_VERSION},
        {STRATA_VERSION(1, 0), STRATA_VERSION(1, 0), STRATA_VERSION(2, 0), STRATA_ERROR_VERSION},
    };
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        base_error err = {0};
        assert_int_equal(note_check_version(cases[i].abi, cases[i].min_host, cases[i].host, &err),
                         cases[i].result);
        assert_int_equal(err.result, cases[i].result);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_elf_good),       cmocka_unit_test(test_elf_truncated),
        cmocka_unit_test(test_elf_flipped),    cmocka_unit_test(test_elf_kinds),
        cmocka_unit_test(test_elf_note_sizes), cmocka_unit_test(test_json_fields),
        cmocka_unit_test(test_json_changed),   cmocka_unit_test(test_json_long),
        cmocka_unit_test(test_versions),
    };
    return cmocka_run_group_tests_name("notes", tests, fixture_make_folder, fixture_remove_folder);
}
