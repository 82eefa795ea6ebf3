/* SPDX-License-Identifier: MIT
 *
 * host/plan: what a plan says of its techniques' settings, of effects and materials, of the layout
 * of a fragment record, and all of it as JSON.
 */
#include "unit/plan_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- settings, layout, effects --------------------------------------------------------------- */

static void settings_are_resolved(void **state) {
    (void)state;
    static const struct {
        request r;
        double mode, payload, threshold;
        uint32_t layout, bytes;
    } rows[] = {
        {{FOR("abuffer ppc over", "b")}, 0, 0, 0.25, 0, 24},
        {{FOR("abuffer ppc over", "b"), .settings = {"abuffer.payload=half"}}, 0, 1, 0.25, 0, 16},
        {{FOR("abuffer ppc over", "b"), .settings = {"abuffer.payload=unorm8"}}, 0, 2, 0.25, 0, 12},
        {{FOR("abuffer fpc over", "b"), .settings = {"abuffer.mode=linked"}}, 1, 0, 0.25, 1, 32},
        {{FOR("abuffer walker over", "b")}, 1, 0, 0.25, 1, 32},
        {{FOR("abuffer fpc over", "b")}, 0, 0, 0.25, 0, 24}, /* the preset, where both would do */
        {{FOR("abuffer ppc over", "b"),
          .settings = {"abuffer.threshold=.5", "abuffer.threshold=1e-1"}},
         0,
         0,
         0.1,
         0,
         24},
        {{FOR("abuffer ppc over", "b"), .settings = {"abuffer.threshold=+1"}}, 0, 0, 1, 0, 24},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        const plan_technique *t = plan_find(p, "abuffer");
        assert_non_null(t);
        assert_int_equal(t->settings.struct_size, sizeof t->settings);
        assert_int_equal(t->settings.count, 3);
        assert_true(t->settings.values[0] == rows[i].mode);
        assert_true(t->settings.values[1] == rows[i].payload);
        assert_true(t->settings.values[2] == rows[i].threshold);
        assert_int_equal(p->layout, rows[i].layout);
        assert_int_equal(p->payload.precision, (uint32_t)rows[i].payload);
        assert_int_equal(p->bytes_per_fragment, rows[i].bytes);
        assert_int_equal(p->captures, 1);
        assert_null(plan_find(p, "peel"));
        plan_free(p);
    }
}

/* How many fragments of a pixel the fold keeps is what its knob k says, where it promises that. */
static void the_nearest_are_as_many_as_k(void **state) {
    (void)state;
    static const struct {
        request r;
        uint32_t nearest;
    } rows[] = {
        {{FOR("abuffer ppc over", "b")}, 0},
        {{FOR("kplus ppc over", "b"), .tolerance = 0.1}, 8},
        {{FOR("kplus ppc over", "b"), .use = "kplus", .settings = {"kplus.k=1"}}, 1},
        {{FOR("kplus ppc over", "b"), .use = "kplus", .settings = {"kplus.k=64"}}, 64},
        {{FOR("kplus ppc over", "b"), .use = "kplus", .settings = {"kplus.k=0"}}, 0},
        {{FOR("kplus abuffer ppc over", "b"), .settings = {"kplus.k=3"}}, 0},
        {{FOR("kbuffer over", "b"), .use = "kbuffer"}, 0}, /* without such a knob */
        {{FOR("window over", "b"), .use = "window"}, 0},   /* its k says something else */
        {{FOR("surface kplus ppc over", "o"), .tolerance = 0.1}, 0},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        if (p->nearest != rows[i].nearest)
            fail_msg("row %zu: %u", i, p->nearest);
        plan_free(p);
    }
}

static uint64_t small_range(void *user, const char *id) {
    return strcmp(id, "limit.storage_range") == 0 ? *(const uint64_t *)user : 1;
}

static void bands_are_expected(void **state) {
    (void)state;
    static const struct {
        uint64_t memory, range; /* for 1,000 records of 24 bytes, 8 of them keys */
        uint32_t bands;
    } rows[] = {{0, 0, 1},    {24000, 0, 1},   {23999, 0, 2}, {8000, 0, 3},      {0, 8000, 1},
                {0, 7999, 2}, {8000, 1000, 8}, {1, 1, 24000}, {1000000, 80, 100}};
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        strata_scene_stats stats;
        plan *p = NULL;
        base_error err = {0};
        uint64_t range = rows[i].range;
        kit_make(&k, "abuffer ppc over");
        kit_scene("b", &d, &stats);
        plan_input in = {.demand = &d,
                         .modules = (const modules_note *const *)k.list,
                         .module_count = k.count,
                         .stats = &stats,
                         .fact = small_range,
                         .user = &range,
                         .memory = rows[i].memory};
        assert_int_equal(plan_make(&in, &p, &err), STRATA_OK);
        assert_int_equal(p->expected_bands, rows[i].bands);
        plan_free(p);
    }
}

static void opaque_scenes_plan_no_fragments(void **state) {
    (void)state;
    kit k;
    demand d;
    plan *p = get(&(request){FOR(ALL, "o")}, &k, &d);
    assert_int_equal(p->transparent, 0);
    assert_int_equal(p->captures, 0);
    assert_int_equal(p->expected_bands, 0);
    assert_int_equal(p->bytes_per_fragment, 0);
    assert_int_equal(p->payload.plane_count, 0);
    assert_int_equal(p->transmittance_channels, 0);
    plan_free(p);
}

static void streams_capture_nothing(void **state) {
    (void)state;
    kit k;
    demand d;
    plan *p = get(&(request){FOR("peel range over", "b"), .use = "peel,range"}, &k, &d);
    assert_int_equal(p->transparent, 1);
    assert_int_equal(p->captures, 0);
    assert_int_equal(p->bytes_per_fragment, 0);
    assert_int_equal(p->payload.plane_count, 2); /* it may keep records of its own */
    assert_true(plan_find(p, "peel")->cost == 5000.0);
    assert_true(plan_find(p, "range")->cost == 1000.0);
    assert_true(plan_floors(p, 1500.0) == 1.5);
    plan_free(p);
    /* 40 + 3 x 40 triangles + 10 layers x (4 + 3 x 100 pixels + 0.25 x 1,000
     * fragments + 2 x 40 triangles) */
    p = get(&(request){FOR("pass over", "b")}, &k, &d);
    assert_true(plan_find(p, "pass")->cost == 6500.0);
    plan_free(p);
    p = get(&(request){FOR("pass over", "bd"), .use = "pass"}, &k, &d);
    assert_int_equal(p->warning_count, 1);
    plan_free(p);
    p = get(&(request){FOR("pass over", "bd"), .use = "pass", .settings = {"pass.layers=8"}}, &k,
            &d);
    assert_int_equal(p->warning_count, 0);
    plan_free(p);
}

static void effects_are_decided(void **state) {
    (void)state;
    static const struct {
        request r;
        const char *active; /* ids in order */
        uint32_t forced, channels, fields;
    } rows[] = {
        {{FOR(ALL, "ob")}, "over", 0, 1, 1},
        {{FOR(ALL, "ot")}, "transmission", 0, 3, 2},
        {{FOR(ALL, "obt")}, "over transmission", 0, 3, 3}, /* and the id */
        {{FOR(ALL, "obt"), .effects = "auto"}, "over transmission", 0, 3, 3},
        {{FOR(ALL, "obt"), .effects = "over"}, "over", 1, 1, 1},
        {{FOR(ALL, "ob"), .effects = "transmission, over"}, "over transmission", 1, 3, 3},
        {{FOR("surface abuffer ppc media", "oe")}, "media", 0, 3, 2},
        {{FOR("surface abuffer ppc media over", "obe")}, "media over", 0, 3, 4},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        char active[128] = "";
        uint32_t forced = 0, index = 0;
        plan *p = get(&rows[i].r, &k, &d);
        for (uint32_t e = 0; e < p->effect_count; e++) {
            forced += p->effects[e].forced;
            if (!p->effects[e].active)
                continue;
            assert_int_equal(p->effects[e].index, index++);
            snprintf(active + strlen(active), sizeof active - strlen(active), "%s%s",
                     active[0] ? " " : "", p->effects[e].effect->id);
        }
        assert_string_equal(active, rows[i].active);
        assert_int_equal(forced, rows[i].forced);
        assert_int_equal(p->active_effects, index);
        assert_int_equal(p->transmittance_channels, rows[i].channels);
        assert_int_equal(p->payload.field_count, rows[i].fields);
        plan_free(p);
    }
}

static void materials_find_their_effect(void **state) {
    (void)state;
    static const struct {
        scene_material material;
        const char *effects, *expected;
    } rows[] = {
        {{.alpha = SCENE_OPAQUE}, "over,transmission", NULL},
        {{.alpha = SCENE_MASK}, "over,transmission", NULL},
        {{.alpha = SCENE_BLEND}, "over,transmission", "over"},
        {{.transmission = 0.1f}, "over,transmission", "transmission"},
        {{.alpha = SCENE_BLEND, .transmission = 1}, "over,transmission", "transmission"},
        {{.alpha = SCENE_BLEND, .transmission = 1}, "over", "over"},
        {{.transmission = 1}, "over", NULL},
        {{.alpha = SCENE_BLEND}, "none", NULL},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        scene_material copy = rows[i].material;
        scene s = {.path = (char[]){"s"}, .materials = &copy, .material_count = 1};
        unsigned char transparent = 9;
        base_error err = {0};
        plan *p = get(&(request){FOR(ALL, "obt"), .effects = rows[i].effects}, &k, &d);
        const plan_effect *e = plan_material_effect(p, &rows[i].material);
        if (rows[i].expected)
            assert_string_equal(e ? e->effect->id : "none", rows[i].expected);
        else
            assert_null(e);
        plan_input in = {.demand = &d,
                         .modules = (const modules_note *const *)k.list,
                         .module_count = k.count,
                         .effects = rows[i].effects};
        assert_int_equal(plan_transparent_materials(&in, &s, &transparent, &err), STRATA_OK);
        assert_int_equal(transparent, rows[i].expected != NULL);
        plan_free(p);
    }
}

/* ---- payload --------------------------------------------------------------------------------- */

static void payloads_are_packed(void **state) {
    (void)state;
    static const struct {
        const char *effects[3];
        uint32_t precision, words, planes, last_stride;
        const char *field; /* and where one of its channels lies: */
        uint32_t channel, plane, part, bit, bits;
    } rows[] = {
        {{"over"}, STRATA_PAYLOAD_FLOAT, 4, 2, 8, "color", 3, 1, 1, 0, 32},
        {{"over"}, STRATA_PAYLOAD_HALF, 2, 1, 8, "color", 3, 0, 1, 16, 16},
        {{"over"}, STRATA_PAYLOAD_UNORM8, 1, 1, 4, "color", 3, 0, 0, 24, 8},
        {{"transmission"}, STRATA_PAYLOAD_FLOAT, 7, 4, 4, "transmittance", 2, 3, 0, 0, 32},
        {{"transmission"}, STRATA_PAYLOAD_HALF, 4, 2, 8, "transmittance", 2, 1, 1, 0, 16},
        {{"transmission"}, STRATA_PAYLOAD_UNORM8, 2, 1, 8, "transmittance", 2, 0, 1, 16, 8},
        {{"over", "transmission"}, STRATA_PAYLOAD_UNORM8, 3, 2, 4, "id", 0, 0, 0, 0, 32},
        {{"over", "transmission"}, STRATA_PAYLOAD_UNORM8, 3, 2, 4, "color", 0, 0, 1, 0, 8},
        {{"over", "transmission"}, STRATA_PAYLOAD_FLOAT, 8, 4, 8, "id", 0, 3, 1, 0, 32},
        {{"media"}, STRATA_PAYLOAD_UNORM8, 2, 1, 8, "object", 0, 0, 0, 0, 32},
        {{"media"}, STRATA_PAYLOAD_UNORM8, 2, 1, 8, "tint", 1, 0, 1, 8, 8},
        {{"media"}, STRATA_PAYLOAD_HALF, 2, 1, 8, "tint", 1, 0, 1, 16, 16},
        {{"media"}, STRATA_PAYLOAD_FLOAT, 3, 2, 4, "object", 0, 1, 0, 0, 32},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const modules_effect_note *notes[3];
        plan_payload p;
        base_error err = {0};
        uint32_t count = 0, found = 0;
        for (; count < 3 && rows[i].effects[count]; count++)
            notes[count] = kit_effect(rows[i].effects[count]);
        assert_int_equal(plan_payload_make(notes, count, rows[i].precision, &p, &err), STRATA_OK);
        assert_int_equal(p.words, rows[i].words);
        assert_int_equal(p.plane_count, rows[i].planes);
        assert_int_equal(p.plane_strides[p.plane_count - 1], rows[i].last_stride);
        for (uint32_t f = 0; f < p.field_count; f++) {
            const plan_channel *at = &p.fields[f].at[rows[i].channel];
            if (strcmp(p.fields[f].name, rows[i].field) != 0)
                continue;
            found++;
            if (at->plane != rows[i].plane || at->part != rows[i].part || at->bit != rows[i].bit ||
                at->bits != rows[i].bits || at->word != at->plane * 2 + at->part)
                fail_msg("row %zu: plane %u part %u bit %u, %u bits", i, at->plane, at->part,
                         at->bit, at->bits);
        }
        assert_int_equal(found, 1);
    }
}

/* No two channels share a bit, none leaves its word, none lies beyond the last. */
static void channels_do_not_overlap(void **state) {
    (void)state;
    static const char *const sets[][3] = {
        {"over", "transmission", "media"}, {"transmission", "media"}, {"media", "over"}};
    for (size_t i = 0; i < BASE_COUNT(sets) * 3; i++) {
        const modules_effect_note *notes[3];
        uint32_t used[16] = {0}, count = 0;
        plan_payload p;
        base_error err = {0};
        for (; count < 3 && sets[i / 3][count]; count++)
            notes[count] = kit_effect(sets[i / 3][count]);
        assert_int_equal(plan_payload_make(notes, count, (uint32_t)(i % 3), &p, &err), STRATA_OK);
        for (uint32_t f = 0; f < p.field_count; f++) {
            for (uint32_t c = 0; c < p.fields[f].channels; c++) {
                const plan_channel *at = &p.fields[f].at[c];
                uint32_t mask = at->bits == 32 ? UINT32_MAX : ((1u << at->bits) - 1) << at->bit;
                assert_true(at->word < p.words && at->bit + at->bits <= 32);
                assert_int_equal(used[at->word] & mask, 0);
                used[at->word] |= mask;
            }
        }
        assert_true(p.plane_count <= PLAN_MAX_PLANES);
    }
}

static void payloads_have_limits(void **state) {
    (void)state;
    plan_payload p;
    base_error err = {0};
    const modules_effect_note *greedy = kit_effect("greedy");
    const modules_effect_note *clashing[] = {kit_effect("over"), kit_effect("clash")};
    const modules_effect_note *exact[] = {kit_effect("over"), kit_effect("precise")};
    assert_int_equal(plan_payload_make(&greedy, 1, STRATA_PAYLOAD_UNORM8, &p, &err),
                     STRATA_ERROR_OVERFLOW);
    assert_non_null(strstr(err.text, "52 bytes of payload a fragment; a record holds 48"));
    err = (base_error){0};
    assert_int_equal(plan_payload_make(clashing, 2, STRATA_PAYLOAD_FLOAT, &p, &err),
                     STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(plan_payload_make(exact, 2, STRATA_PAYLOAD_FLOAT, &p, &err),
                     STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(plan_payload_make(NULL, 0, STRATA_PAYLOAD_FLOAT, &p, &err), STRATA_OK);
    assert_int_equal(p.plane_count, 0);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

static void plans_are_told_as_json(void **state) {
    (void)state;
    kit k;
    demand d;
    const char *technique, *mode, *layout, *payload, *evidence;
    int called_for, bytes, blend;
    double cost;
    plan *p = get(&(request){FOR(ALL, "ob"), .device = "-", .settings = {"abuffer.payload=half"}},
                  &k, &d);
    json_t *json = plan_json(p);
    json_t *effect = json_array_get(json_object_get(json, "effects"), 0);
    json_t *capture = json_array_get(json_object_get(json, "techniques"), 1);
    assert_int_equal(json_unpack(json, "{s:{s:i},s:{s:s,s:s,s:i}}", "facts", "materials.blend",
                                 &blend, "fragments", "layout", &layout, "payload", &payload,
                                 "bytes_per_fragment", &bytes),
                     0);
    assert_int_equal(blend, 3);
    assert_string_equal(layout, "contiguous");
    assert_string_equal(payload, "half");
    assert_int_equal(bytes, 16);
    assert_int_equal(
        json_unpack(effect, "{s:s,s:b}", "evidence", &evidence, "called_for", &called_for), 0);
    assert_string_equal(evidence, "3 materials with alphaMode BLEND, 2,060 triangles");
    assert_int_equal(called_for, 1);
    assert_int_equal(json_unpack(capture, "{s:s,s:{s:s},s:F}", "technique", &technique, "settings",
                                 "mode", &mode, "cost", &cost),
                     0);
    assert_string_equal(technique, "abuffer");
    assert_string_equal(mode, "contiguous");
    assert_true(cost == 3.0);
    assert_int_equal(json_array_size(json_object_get(json, "left_out")),
                     13 - json_array_size(json_object_get(json, "techniques")));
    json_decref(json);
    plan_free(p);
}

static void modules_are_told_as_json(void **state) {
    (void)state;
    kit k;
    kit_make(&k, ALL);
    json_t *json = plan_json_modules((const modules_note *const *)k.list, k.count);
    assert_int_equal(json_array_size(json), k.count);
    char *text = json_dumps(json, JSON_COMPACT);
    assert_non_null(text);
    static const char *const parts[] = {
        "{\"slot\":\"fragments/1\",\"use\":\"produces\",\"layouts\":[\"contiguous\",\"linked\"]",
        "\"default\":\"contiguous\",\"trades_accuracy\":false,\"choices\":[\"contiguous\","
        "\"linked\"]",
        "\"type\":\"int\",\"unit\":\"fragments\",\"default\":8",
        "\"minimum\":0,\"maximum\":64",
        "\"order\":\"exact\",\"determinism\":\"bit\",\"largest_depth\":254",
        "\"needs\":[\"feature.stencil_export\"]",
        "\"called_for_by\":[{\"fact\":\"materials.blend\",\"threshold\":1}]",
    };
    for (size_t i = 0; i < BASE_COUNT(parts); i++)
        if (!strstr(text, parts[i]))
            fail_msg("not in the list: %s", parts[i]);
    free(text);
    json_decref(json);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(settings_are_resolved),
        cmocka_unit_test(the_nearest_are_as_many_as_k),
        cmocka_unit_test(bands_are_expected),
        cmocka_unit_test(opaque_scenes_plan_no_fragments),
        cmocka_unit_test(streams_capture_nothing),
        cmocka_unit_test(effects_are_decided),
        cmocka_unit_test(materials_find_their_effect),
        cmocka_unit_test(payloads_are_packed),
        cmocka_unit_test(channels_do_not_overlap),
        cmocka_unit_test(payloads_have_limits),
        cmocka_unit_test(plans_are_told_as_json),
        cmocka_unit_test(modules_are_told_as_json),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
