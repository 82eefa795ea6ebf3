/* SPDX-License-Identifier: MIT
 *
 * kplus's ways of keeping the fragments of a pixel apart, where they really meet: its own GLSL in a
 * compute shader whose invocations, side by side and on several threads, insert into very few
 * pixels. A rasteriser that works tile by tile never shows what an unlocked write does. For the
 * interlock, which compute shaders do not have, a spin lock stands around its section.
 */
#include <stdio.h>
#include <stdlib.h>

#include "base/base.h"
#include "gpu/rig.h"

enum { PIXELS = 3, FRAGMENTS = 24576, K = 24, ATTEMPTS = 20, MOST_ATTEMPTS = 1000, NAMES = 8 };

typedef struct race_params {
    uint32_t k, tries;
} race_params;

/* Payloads of one word, which tells whose they are. */
static const char effects[] =
    "#ifndef RACE_EFFECTS\n"
    "#define RACE_EFFECTS\n"
    "struct StrataPayload { uint tag; };\n"
    "struct StrataElement { vec4 color; };\n"
    "layout(std430) coherent buffer Tags { uint tags[]; };\n"
    "void strata_payload_store(uint slot, StrataPayload payload) { tags[slot] = payload.tag; }\n"
    "#endif\n";

/* In place of strata/frame.glsl: a band of three pixels, side by side. */
#define FRAME                                                                                      \
    "#define STRATA_FRAME_GLSL\n"                                                                  \
    "uvec4 strata_frame_band() { return uvec4(0u, 0u, 3u, 1u); }\n"                                \
    "uint strata_pixel(uvec2 position) { return position.x; }\n"                                   \
    "uint strata_pixel_count() { return 3u; }\n"

/* Each fragment is as near as the last ones or nearer, so that nearly all come in; or as far or
 * farther, so that those which come in while the pixel is filled must stay. */
#define RECORD                                                                                     \
    "#include \"strata/scan.glsl\"\n"                                                              \
    "void main() {\n"                                                                              \
    "    uint i = strata_item();\n"                                                                \
    "    uvec2 position = uvec2(i % 3u, 0u);\n"                                                    \
    "#ifdef NEAREST_FIRST\n"                                                                       \
    "    uvec2 record = uvec2(i / 8u, i * 2654435761u);\n"                                         \
    "#else\n"                                                                                      \
    "    uvec2 record = uvec2((24575u - i) / 8u, i * 2654435761u);\n"                              \
    "#endif\n"
#define PAYLOAD "    StrataPayload payload = StrataPayload(record.x + 31u * record.y);\n"

static const strata_glsl inserting = {FRAME "#include \"strata/effects.glsl\"\n"
                                            "#include \"insert.glsl\"\n" RECORD PAYLOAD
                                            "    uvec2 cell = cell_at(position);\n"
                                            "    if (!culled(cell, record))\n"
                                            "        insert(position, cell, record, payload);\n"
                                            "}\n",
                                      "insert"};
static const strata_glsl taking_turns = {
    FRAME "#include \"strata/effects.glsl\"\n"
          "#include \"insert.glsl\"\n"
          "layout(std430) coherent buffer Turns { uint turns[]; };\n"
          "layout(std430) buffer Failures { uint failures; };\n" RECORD PAYLOAD
          "    uvec2 cell = cell_at(position);\n"
          "    bool waiting = !culled(cell, record);\n"
          "    for (uint i = 0u; i < params.tries && waiting; ++i)\n"
          "        if (atomicExchange(turns[position.x], 1u) == 0u) {\n"
          "            EXCLUDE_FENCE;\n"
          "            insert(position, cell, record, payload);\n"
          "            EXCLUDE_FENCE;\n"
          "            atomicExchange(turns[position.x], 0u);\n"
          "            waiting = false;\n"
          "        }\n"
          "    if (waiting)\n"
          "        atomicAdd(failures, 1u);\n"
          "}\n",
    "taking_turns"};
static const strata_glsl descending = {
    "#ifdef WIDE\n#extension GL_EXT_shader_atomic_int64 : require\n"
    "#extension GL_ARB_gpu_shader_int64 : require\n#endif\n" FRAME
    "#include \"descend.glsl\"\n" RECORD "#ifdef ORDERS_PASS\n"
    "    descend_orders(slots_of_key(slots_of(position), record.x), record.y);\n"
    "#else\n"
    "    descend(slots_of(position), value_of(record));\n"
    "#endif\n"
    "}\n",
    "descend"};

typedef struct record {
    uint32_t key, order;
} record;

static int in_order(const void *a, const void *b) {
    const record *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return x->order < y->order ? -1 : x->order > y->order;
}

/* The nearest K of one pixel, in order. */
static void expect(uint32_t pixel, int nearest_first, record out[FRAGMENTS]) {
    uint32_t count = 0;
    for (uint32_t i = pixel; i < FRAGMENTS; i += PIXELS) {
        out[count++] = (record){(nearest_first ? i : FRAGMENTS - 1u - i) / 8u, i * 2654435761u};
    }
    qsort(out, count, sizeof *out, in_order);
}

/* ---- the module's sources -------------------------------------------------------------------- */

static char *read_source(const char *name, char path[64]) {
    char file[4096];
    const char *root = getenv("STRATA_TEST_SOURCE");
    snprintf(file, sizeof file, "%s/plugins/kplus/%s", root ? root : ".", name);
    snprintf(path, 64, "%s", name);
    FILE *f = fopen(file, "rb");
    char *text = calloc(1, 1 << 16);
    if (!f || !text)
        fail_msg("%s cannot be read", file);
    assert_true(fread(text, 1, (1 << 16) - 1, f) > 0);
    fclose(f);
    return text;
}

static strata_program program_of(rig *r, const strata_glsl *source, const char *const *defines,
                                 uint32_t define_count) {
    static const char *const names[NAMES] = {"slots.glsl",   "cells.glsl", "insert.glsl",
                                             "array.glsl",   "heap.glsl",  "chain.glsl",
                                             "descend.glsl", "texels.glsl"};
    static char *texts[NAMES], paths[NAMES][64];
    static strata_glsl sources[NAMES];
    const strata_glsl *includes[NAMES + 1] = {NULL};
    base_error err = {0};
    strata_program out = {0};
    for (size_t i = 0; i < NAMES; ++i) {
        if (!texts[i])
            texts[i] = read_source(names[i], paths[i]);
        sources[i] = (strata_glsl){texts[i], paths[i]};
        includes[i] = &sources[i];
    }
    assert_int_equal(gpu_set_include(r->g, "strata/effects.glsl", effects, &err), STRATA_OK);
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_COMPUTE,
                                      .label = source->path,
                                      .source = source,
                                      .defines = defines,
                                      .define_count = define_count,
                                      .includes = includes};
    if (gpu_program_create(r->scope, &desc, &out, &err) != STRATA_OK)
        fail_msg("%s: %s", r->backend, err.text);
    return out;
}

static void dispatch(rig *r, strata_program program, const strata_bind *binds, uint32_t count) {
    const race_params params = {K, 32768};
    rig_pass(r, (strata_pass){.program = program,
                              .groups = {FRAGMENTS / 64},
                              .params = &params,
                              .params_size = sizeof params,
                              .binds = binds,
                              .bind_count = count});
}

/* ---- the lock and the interlock -------------------------------------------------------------- */

/* Whether every record is there, with its own payload; 0 when a lock was given up, which a busy
 * machine may bring about and which is counted. */
static int insert_once(rig *r, strata_program program, int interlock, int heap, int nearest_first) {
    static record found[PIXELS * K], nearest[FRAGMENTS];
    static uint32_t tags[PIXELS * K];
    uint32_t cells[PIXELS][2], failures = 0;
    for (uint32_t i = 0; i < PIXELS; ++i) {
        cells[i][0] = UINT32_MAX;
        cells[i][1] = 0;
    }
    const strata_buffer keys = rig_buffer(r, "keys", sizeof found, NULL),
                        tag_buffer = rig_buffer(r, "tags", sizeof tags, NULL),
                        failed = rig_buffer(r, "failures", 4, NULL);
    strata_bind binds[6] = {
        rig_bind_buffer("StrataKeys", keys),
        rig_bind_buffer("Tags", tag_buffer),
        rig_bind_buffer("Failures", failed),
        rig_bind_buffer("Cells", rig_buffer(r, "cells", sizeof cells, cells)),
    };
    uint32_t count = 4;
    if (interlock)
        binds[count++] = rig_bind_buffer("Turns", rig_buffer(r, "turns", 4 * PIXELS, NULL));
    if (heap)
        binds[count++] = rig_bind_buffer("Nodes", rig_buffer(r, "nodes", sizeof found, NULL));
    gpu_begin(r->g, 8, 8);
    dispatch(r, program, binds, count);
    rig_submit(r);
    rig_read(r, keys, found, sizeof found);
    rig_read(r, tag_buffer, tags, sizeof tags);
    rig_read(r, failed, &failures, sizeof failures);
    if (failures > 0)
        return 0;
    for (uint32_t pixel = 0; pixel < PIXELS; ++pixel) {
        record *kept = found + pixel * K;
        expect(pixel, nearest_first, nearest);
        for (uint32_t i = 0; i < K; ++i)
            if (tags[pixel * K + i] != kept[i].key + 31u * kept[i].order)
                fail_msg("%s: pixel %u, slot %u holds another's payload", r->backend, pixel, i);
        qsort(kept, K, sizeof *kept, in_order);
        for (uint32_t i = 0; i < K; ++i)
            if (in_order(&kept[i], &nearest[i]) != 0)
                fail_msg("%s: pixel %u: record %u is (%u, %u), not (%u, %u)", r->backend, pixel, i,
                         kept[i].key, kept[i].order, nearest[i].key, nearest[i].order);
    }
    return 1;
}

static void check_insertion(rig *r, int interlock, int heap, int nearest_first) {
    const char *defines[4] = {interlock ? "STRATA_INTERLOCK" : "LOCK"};
    uint32_t count = 1;
    int held = 0, tried = 0;
    if (heap)
        defines[count++] = "HEAP";
    if (nearest_first)
        defines[count++] = "NEAREST_FIRST";
    if (!gpu_fact(r->g, "selftest.ordered_rmw")) /* as kplus does, and for its reason */
        defines[count++] = "FENCES";
    rig_clear(r);
    const strata_program program =
        program_of(r, interlock ? &taking_turns : &inserting, defines, count);
    while (tried < ATTEMPTS || (held == 0 && tried < MOST_ATTEMPTS)) {
        held += insert_once(r, program, interlock, heap, nearest_first);
        ++tried;
    }
    print_message("%s: %d of %d attempts without a lock given up\n", r->backend, held, tried);
    assert_true(held > 0);
}

static void the_lock_excludes(void **state) {
    rig *r = *state;
    if (!r)
        skip();
    check_insertion(r, 0, 0, 0);
    check_insertion(r, 0, 0, 1);
    check_insertion(r, 0, 1, 0);
    check_insertion(r, 0, 1, 1);
}

static void sections_go_by_what_they_find(void **state) {
    rig *r = *state;
    if (!r)
        skip();
    check_insertion(r, 1, 0, 0);
    check_insertion(r, 1, 0, 1);
    check_insertion(r, 1, 1, 0);
    check_insertion(r, 1, 1, 1);
}

/* ---- atomics --------------------------------------------------------------------------------- */

static void check_chain(rig *r, int wide) {
    static record found[PIXELS * K], empty[PIXELS * K], nearest[FRAGMENTS];
    const char *const variant[] = {wide ? "WIDE" : "NARROW"};
    const char *const orders[] = {"ORDERS_PASS"};
    rig_clear(r);
    memset(empty, 0xff, sizeof empty);
    const strata_program first = program_of(r, &descending, variant, 1);
    for (int attempt = 0; attempt < ATTEMPTS; ++attempt) {
        const strata_buffer keys = rig_buffer(r, "keys", sizeof empty, empty);
        const strata_bind bind = rig_bind_buffer("StrataKeys", keys);
        gpu_begin(r->g, 8, 8);
        dispatch(r, first, &bind, 1);
        if (!wide)
            dispatch(r, program_of(r, &descending, orders, 1), &bind, 1);
        rig_submit(r);
        rig_read(r, keys, found, sizeof found);
        for (uint32_t pixel = 0; pixel < PIXELS; ++pixel) {
            expect(pixel, 0, nearest);
            for (uint32_t i = 0; i < K; ++i) {
                record at = found[pixel * K + i];
                if (wide) /* the key is the high word */
                    at = (record){at.order, at.key};
                if (in_order(&at, &nearest[i]) != 0)
                    fail_msg("%s: pixel %u: record %u is (%u, %u), not (%u, %u)", r->backend, pixel,
                             i, at.key, at.order, nearest[i].key, nearest[i].order);
            }
        }
    }
}

static void chains_lose_nothing(void **state) {
    rig *r = *state;
    if (!r)
        skip();
    check_chain(r, 0);
    if (gpu_fact(r->g, "feature.int64_atomics"))
        check_chain(r, 1);
}

static int open_gl(void **state) {
    *state = rig_open("gl");
    return 0;
}

static int open_vulkan(void **state) {
    *state = rig_open("vulkan");
    return 0;
}

static int close_rig(void **state) {
    if (*state)
        rig_close(*state);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_lock_excludes, open_vulkan, close_rig),
        cmocka_unit_test_setup_teardown(sections_go_by_what_they_find, open_vulkan, close_rig),
        cmocka_unit_test_setup_teardown(chains_lose_nothing, open_vulkan, close_rig),
        cmocka_unit_test_setup_teardown(chains_lose_nothing, open_gl, close_rig),
    };
    return cmocka_run_group_tests_name("kplus races", tests, NULL, NULL);
}
