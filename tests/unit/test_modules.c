/* SPDX-License-Identifier: MIT
 *
 * host/modules: scanning and opening real shared objects (changed copies of the test module), and
 * descriptors that break a rule.
 */
#define _GNU_SOURCE
#include "modules/modules_internal.h"
#include "unit/modules_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* A scan of the scratch folder after a copy of `module`, changed in its note, was put there. */
static modules *scan_changed(const char *module, const char *from, const char *to) {
    size_t size;
    unsigned char *data = fixture_read(module, &size);
    if (from)
        fixture_replace(data, size, from, to);
    fixture_empty_folder();
    fixture_write("changed.so", data, size);
    free(data);
    modules *m;
    base_error err = {0};
    if (modules_scan(fixture_folder, &m, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return m;
}

static int is_mapped(const char *name) {
    FILE *maps = fopen("/proc/self/maps", "r");
    char line[4096];
    int found = 0;
    assert_non_null(maps);
    while (fgets(line, sizeof line, maps))
        found |= strstr(line, name) != NULL;
    fclose(maps);
    return found;
}

static void test_open(void **state) {
    (void)state;
    modules *m = scan_changed("fixture.so", NULL, NULL);
    assert_int_equal(modules_count(m), 1);
    assert_int_equal(modules_refused_count(m), 0);
    assert_null(modules_note_at(m, 1));
    uint32_t count = 1;
    modules_opened(m, &count);
    assert_int_equal(count, 0);
    assert_false(is_mapped("changed.so"));

    const strata_technique *technique;
    const strata_effect *effect;
    base_error err = {0};
    assert_int_equal(modules_open_technique(m, "fixture", &technique, &err), STRATA_OK);
    assert_int_equal(technique->state_size, 16);
    assert_int_equal(modules_open_effect(m, "fixture", &effect, &err), STRATA_OK);
    assert_int_equal(effect->priority, 7);
    assert_non_null(strstr(effect->glsl->text, "fixture_event"));
    assert_string_equal(effect->glsl->path, "tests/modules/fixture.glsl");
    const char *const *opened = modules_opened(m, &count);
    assert_int_equal(count, 1);
    assert_string_equal(opened[0], "fixture");
    assert_true(is_mapped("changed.so"));

    assert_int_equal(modules_open_technique(m, "fixtur", &technique, &err), STRATA_ERROR_NOT_FOUND);
    assert_null(technique);
    modules_free(m);
    assert_false(is_mapped("changed.so"));
}

/* A note that says other things than the descriptor: listed, and refused when it is opened. */
static void test_note_differs(void **state) {
    (void)state;
    static const char *const changes[][2] = {
        {"a tint", "a hint"},
        {"\"per_pixel\":0.2", "\"per_pixel\":0.3"},
        {"\"priority\":7", "\"priority\":8"},
        {"small", "smell"},
        {"feature.int64", "feature.int32"},
    };
    for (size_t i = 0; i < BASE_COUNT(changes); i++) {
        modules *m = scan_changed("fixture.so", changes[i][0], changes[i][1]);
        assert_int_equal(modules_count(m), 1);
        const strata_technique *technique;
        base_error err = {0};
        assert_int_equal(modules_open_technique(m, "fixture", &technique, &err),
                         STRATA_ERROR_MODULE);
        assert_null(technique);
        assert_non_null(strstr(err.text, "the note differs"));
        assert_non_null(strstr(err.text, "changed.so"));
        assert_int_equal(modules_count(m), 0);
        assert_int_equal(modules_refused_count(m), 1);
        assert_null(modules_find_technique(m, "fixture"));
        assert_false(is_mapped("changed.so"));
        uint32_t opened;
        modules_opened(m, &opened);
        assert_int_equal(opened, 0);
        modules_free(m);
    }
}

/* Versions that no host of this ABI can serve are refused before anything is opened. */
static void test_note_version(void **state) {
    (void)state;
    modules *m =
        scan_changed("fixture.so", "\"min_host_version\":65536", "\"min_host_version\":99999");
    assert_int_equal(modules_count(m), 0);
    assert_int_equal(modules_refused_count(m), 1);
    assert_non_null(strstr(modules_refused_at(m, 0)->reason, "at least ABI 1.34463"));
    assert_null(modules_refused_at(m, 1));
    modules_free(m);
    m = scan_changed("fixture.so", "\"abi_version\":65536", "\"abi_version\":    2");
    assert_int_equal(modules_count(m), 0);
    assert_non_null(strstr(modules_refused_at(m, 0)->reason, "built for ABI 0.2"));
    modules_free(m);
}

/* A file with a good note and no descriptor in it; dlerror's words are passed on. */
static void test_symbol_missing(void **state) {
    (void)state;
    modules *m = scan_changed("hollow.so", NULL, NULL);
    assert_int_equal(modules_count(m), 1);
    const strata_effect *effect;
    base_error err = {0};
    assert_int_equal(modules_open_effect(m, "fixture", &effect, &err), STRATA_ERROR_MODULE);
    assert_non_null(strstr(err.text, "undefined symbol: strata_module_v1"));
    modules_free(m);
}

/* A module that is cut off behind its note. The dynamic linker would map it and die. */
static void test_truncated(void **state) {
    (void)state;
    size_t size;
    unsigned char *data = fixture_read("fixture.so", &size);
    fixture_empty_folder();
    size_t note = (size_t)(fixture_note(data, size) - data);
    assert_true(note + 4000 < size);
    fixture_write("cut.so", data, note + 4000);
    fixture_write("empty.so", data, 0);
    free(data);
    modules *m;
    base_error err = {0};
    assert_int_equal(modules_scan(fixture_folder, &m, &err), STRATA_OK);
    assert_int_equal(modules_count(m), 0);
    assert_int_equal(modules_refused_count(m), 2);
    assert_non_null(strstr(modules_refused_at(m, 0)->reason, "cut off"));
    modules_free(m);
}

/* Of two with one id the first counts; the same file under two names counts once; what is no module
 * is listed as refused; folders come in the path's order. */
static void test_search(void **state) {
    (void)state;
    size_t size;
    unsigned char *data = fixture_read("fixture.so", &size);
    fixture_empty_folder();
    fixture_write("b.so", data, size);
    fixture_write("a.so", data, size);
    fixture_write(".hidden.so", data, size);
    fixture_write("a.txt", data, size);
    fixture_write("junk.so", "junk", 4);
    free(data);
    char link_path[512], path[512];
    snprintf(link_path, sizeof link_path, "%s/c.so", fixture_folder);
    assert_int_equal(symlink("a.so", link_path), 0);
    snprintf(path, sizeof path, "%s::%s/", fixture_folder, fixture_folder);
    modules *m;
    base_error err = {0};
    assert_int_equal(modules_scan(path, &m, &err), STRATA_OK);
    assert_int_equal(modules_count(m), 1);
    assert_non_null(strstr(modules_note_at(m, 0)->path, "/a.so"));
    assert_int_equal(modules_refused_count(m), 4); /* b and junk, in both folders */
    assert_non_null(strstr(modules_refused_at(m, 0)->reason, "already found at"));
    assert_string_equal(modules_refused_at(m, 1)->reason,
                        "the ELF header reaches beyond the end of the file");
    modules_free(m);

    assert_int_equal(modules_scan("/nonexistent", &m, &err), STRATA_ERROR_NOT_FOUND);
    assert_null(m);
    assert_non_null(strstr(err.text, "/nonexistent"));
    assert_int_equal(setenv("STRATA_MODULE_PATH", fixture_folder, 1), 0);
    err = (base_error){0};
    assert_int_equal(modules_scan(NULL, &m, &err), STRATA_OK);
    assert_int_equal(modules_count(m), 1);
    modules_free(m);
    char hidden[512];
    snprintf(hidden, sizeof hidden, "%s/.hidden.so", fixture_folder);
    unlink(hidden);
}

static void test_refuse(void **state) {
    (void)state;
    modules *m = scan_changed("fixture.so", NULL, NULL);
    const modules_note *note = modules_note_at(m, 0);
    const strata_technique *technique;
    base_error err = {0};
    assert_int_equal(modules_open_technique(m, "fixture", &technique, &err), STRATA_OK);
    assert_int_equal(modules_refuse(m, "fixture", "it lost the device twice", &err), STRATA_OK);
    assert_int_equal(modules_count(m), 0);
    assert_null(modules_find_effect(m, "fixture"));
    assert_string_equal(modules_refused_at(m, 0)->reason, "it lost the device twice");
    assert_string_equal(note->id, "fixture"); /* and what was handed out stays readable */
    assert_string_equal(technique->id, "fixture");
    assert_int_equal(modules_refuse(m, "fixture", "again", &err), STRATA_ERROR_NOT_FOUND);
    modules_free(m);
}

/* ---- descriptors that break a rule -------------------------------------------------------------
 */

/* Copies of the test module's structs, joined up again, for a case to break. */
typedef struct parts {
    strata_module module;
    strata_technique technique;
    strata_effect effect;
    strata_knob knob;
    strata_slot_use slot;
    strata_promises promises;
    strata_glsl glsl;
    const strata_technique *techniques[1];
    const strata_effect *effects[1];
    const strata_knob *knobs[1];
    const strata_slot_use *slots[1];
    unsigned char tail[512]; /* `module` again, with room behind it */
} parts;

static void make_parts(parts *p, const strata_technique *technique, const strata_effect *effect) {
    *p = (parts){.technique = *technique,
                 .effect = *effect,
                 .knob = *technique->knobs[0],
                 .slot = *technique->slots[1],
                 .promises = *technique->promises,
                 .glsl = *effect->glsl,
                 .techniques = {&p->technique},
                 .effects = {&p->effect},
                 .knobs = {&p->knob},
                 .slots = {&p->slot}};
    p->technique.knobs = p->knobs;
    p->technique.knob_count = 1;
    p->technique.slots = p->slots;
    p->technique.slot_count = 1;
    p->technique.promises = &p->promises;
    p->effect.glsl = &p->glsl;
    p->module = (strata_module){.struct_size = sizeof(strata_module),
                                .abi_version = STRATA_ABI_VERSION,
                                .min_host_version = STRATA_VERSION(1, 0),
                                .id = "parts",
                                .title = "parts",
                                .version = "1",
                                .licence = "MIT",
                                .techniques = p->techniques,
                                .technique_count = 1,
                                .effects = p->effects,
                                .effect_count = 1};
}

enum breakage {
    SOUND,
    MODULE_SMALL,
    MODULE_HUGE,
    MODULE_FLAGS,
    MODULE_NO_ID,
    MODULE_EMPTY,
    MODULE_COUNT,
    MODULE_NULL_ARRAY,
    TECHNIQUE_NULL,
    TECHNIQUE_SMALL,
    TECHNIQUE_ID_LONG,
    NO_CREATE,
    NO_ESTIMATE,
    NO_VERIFY,
    KNOB_SMALL,
    KNOB_NULL,
    KNOB_NAN,
    SLOT_NULL_NAME,
    NO_PROMISES,
    EFFECT_NO_GLSL,
    EFFECT_NO_TEXT,
    EFFECT_BAD_ID,
    BREAKAGES
};

static const char long_id[] =
    "a123456789012345678901234567890123456789012345678901234567890123"; /* 64 */

static void break_parts(parts *p, enum breakage what) {
    switch (what) {
    case MODULE_SMALL:
        p->module.struct_size = 8;
        break;
    case MODULE_HUGE:
        p->module.struct_size = 0xfffffff0u;
        break;
    case MODULE_FLAGS:
        p->module.flags = 1;
        break;
    case MODULE_NO_ID:
        p->module.id = NULL;
        break;
    case MODULE_EMPTY:
        p->module.technique_count = p->module.effect_count = 0;
        break;
    case MODULE_COUNT:
        p->module.technique_count = 0x40000000u;
        break;
    case MODULE_NULL_ARRAY:
        p->module.effects = NULL;
        break;
    case TECHNIQUE_NULL:
        p->techniques[0] = NULL;
        break;
    case TECHNIQUE_SMALL:
        p->technique.struct_size -= 8;
        break;
    case TECHNIQUE_ID_LONG:
        p->technique.id = long_id;
        break;
    case NO_CREATE:
        p->technique.create = NULL;
        break;
    case NO_ESTIMATE:
        p->technique.estimate = NULL;
        break;
    case NO_VERIFY:
        p->technique.verify = NULL;
        break;
    case KNOB_SMALL:
        p->knob.struct_size = 4;
        break;
    case KNOB_NULL:
        p->knobs[0] = NULL;
        break;
    case KNOB_NAN:
        p->knob.preset = strtod("nan", NULL);
        break;
    case SLOT_NULL_NAME:
        p->slot.slot = NULL;
        break;
    case NO_PROMISES:
        p->technique.promises = NULL;
        break;
    case EFFECT_NO_GLSL:
        p->effect.glsl = NULL;
        break;
    case EFFECT_NO_TEXT:
        p->glsl.text = NULL;
        break;
    case EFFECT_BAD_ID:
        p->effect.id = "Bad Id";
        break;
    case SOUND:
    case BREAKAGES:
        break;
    }
}

static void test_descriptors(void **state) {
    (void)state;
    modules *m = scan_changed("fixture.so", NULL, NULL);
    const strata_technique *technique;
    const strata_effect *effect;
    base_error err = {0};
    assert_int_equal(modules_open_technique(m, "fixture", &technique, &err), STRATA_OK);
    assert_int_equal(modules_open_effect(m, "fixture", &effect, &err), STRATA_OK);
    for (int what = SOUND; what < BREAKAGES; what++) {
        parts p;
        make_parts(&p, technique, effect);
        break_parts(&p, (enum breakage)what);
        note_arena arena = {0};
        modules_note note;
        err = (base_error){0};
        strata_result result = descriptor_note(&p.module, "parts.so", &arena, &note, &err);
        int sound = what == SOUND || what == NO_VERIFY || what == NO_ESTIMATE;
        if ((result == STRATA_OK) != sound)
            fail_msg("case %d: result %d, \"%s\"", what, result, err.text);
        assert_int_equal(err.result, result);
        note_arena_free(&arena);
    }
    modules_free(m);
}

/* A struct of a later minor: longer, fine while what is unknown is zero. */
static void test_tail(void **state) {
    (void)state;
    modules *m = scan_changed("fixture.so", NULL, NULL);
    const strata_technique *technique;
    const strata_effect *effect;
    base_error err = {0};
    assert_int_equal(modules_open_technique(m, "fixture", &technique, &err), STRATA_OK);
    assert_int_equal(modules_open_effect(m, "fixture", &effect, &err), STRATA_OK);
    parts p;
    make_parts(&p, technique, effect);
    p.module.struct_size = (uint32_t)sizeof p.tail;
    union {
        unsigned char bytes[sizeof p.tail];
        strata_module module;
    } longer = {.module = p.module};
    note_arena arena = {0};
    modules_note note;
    assert_int_equal(descriptor_note(&longer.module, "x", &arena, &note, &err), STRATA_OK);
    longer.bytes[sizeof(strata_module) + 8] = 1;
    assert_int_equal(descriptor_note(&longer.module, "x", &arena, &note, &err),
                     STRATA_ERROR_VERSION);
    note_arena_free(&arena);
    modules_free(m);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_open),         cmocka_unit_test(test_note_differs),
        cmocka_unit_test(test_note_version), cmocka_unit_test(test_symbol_missing),
        cmocka_unit_test(test_truncated),    cmocka_unit_test(test_search),
        cmocka_unit_test(test_refuse),       cmocka_unit_test(test_descriptors),
        cmocka_unit_test(test_tail),
    };
    return cmocka_run_group_tests_name("modules", tests, fixture_make_folder,
                                       fixture_remove_folder);
}
