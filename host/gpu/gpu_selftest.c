/* SPDX-License-Identifier: MIT
 *
 * Start-up self-tests: what a driver really does, where the specification leaves it open and a
 * technique or the host wants to rely on it. Run when first asked, on a device of their own, and
 * kept on disk for each device and driver. A test that cannot be carried out counts as failed.
 */
#include "gpu/gpu_internal.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SELFTEST_VERSION 4u /* counts changes of the tests themselves */

/* ---- timestamps: does a pass's time agree with the clock? ------------------------------------ */

#define HEAVY_MS     8.0    /* what the dispatch has to last at least */
#define HEAVY_LIMIT  32768u /* work groups at most */
#define HEAVY_ROUNDS 6
#define HEAVY_AGREED 2 /* a busy machine delays the clock, never the work */

static const strata_glsl heavy = {"layout(local_size_x = 64) in;\n"
                                  "layout(std430) buffer Sink { uint sink[]; };\n"
                                  "STRATA_PARAMS { uint rounds; } params;\n"
                                  "void main() {\n"
                                  "    uint v = gl_GlobalInvocationID.x;\n"
                                  "    for (uint i = 0u; i < params.rounds; ++i)\n"
                                  "        v = v * 1664525u + 1013904223u;\n"
                                  "    if (v == 0u)\n"
                                  "        sink[0] = v;\n"
                                  "}\n",
                                  "selftest.timestamps"};

/* Clock and driver's time of one dispatch, in ms; the clock's is -1 on failure. */
static double time_heavy(gpu *g, strata_program program, strata_buffer sink, uint32_t groups,
                         double *measured) {
    const uint32_t rounds = 4096;
    const strata_bind bind = {.struct_size = sizeof bind, .name = "Sink", .buffer = sink};
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "heavy",
                              .groups = {groups},
                              .program = program,
                              .params = &rounds,
                              .params_size = sizeof rounds,
                              .binds = &bind,
                              .bind_count = 1};
    uint32_t count = 0;
    gpu_begin(g, 1, 1);
    double start = base_now_ms();
    gpu_pass(g, "selftest", &pass);
    strata_result result = gpu_submit(g, NULL);
    double clock = base_now_ms() - start;
    const gpu_timing *timings = gpu_timings(g, &count);
    *measured = count == 1 ? timings[0].gpu_ms : -1.0;
    return result == STRATA_OK ? clock : -1.0;
}

static int test_timestamps(gpu *g, gpu_scope *scope) {
    const strata_program_desc program_desc = {.struct_size = sizeof program_desc,
                                              .kind = STRATA_PROGRAM_COMPUTE,
                                              .label = "selftest",
                                              .source = &heavy};
    const strata_buffer_desc sink_desc = {
        .struct_size = sizeof sink_desc, .label = "sink", .size = 4};
    strata_program program;
    strata_buffer sink;
    uint32_t groups = 64;
    double measured;
    int agreed = 0;
    if (gpu_program_create(scope, &program_desc, &program, NULL) != STRATA_OK ||
        gpu_buffer_create(scope, &sink_desc, &sink, NULL) != STRATA_OK ||
        time_heavy(g, program, sink, groups, &measured) < 0) /* the driver compiles */
        return 0;
    double clock = time_heavy(g, program, sink, groups, &measured);
    while (clock >= 0 && clock < HEAVY_MS && groups < HEAVY_LIMIT) {
        groups *= 2;
        clock = time_heavy(g, program, sink, groups, &measured);
    }
    for (int i = 0; i < HEAVY_ROUNDS && agreed < HEAVY_AGREED; i++) {
        clock = time_heavy(g, program, sink, groups, &measured);
        if (clock < 0 || measured > clock)
            return 0;
        agreed += measured >= 0.7 * clock - 1.0;
    }
    return agreed == HEAVY_AGREED;
}

/* ---- ordered_rmw, interlock: are read-modify-writes exact and in primitive order? ------------ */

#define RMW_SIZE       128u                   /* pixels along a side */
#define RMW_PRIMITIVES GPU_SELFTEST_TRIANGLES /* that cover all of them */
#define RMW_ROUNDS     4

static const strata_glsl counting = {
    "#include \"strata/interlock.glsl\"\n"
    "layout(std430) STRATA_INTERLOCKED buffer Cells { uint cells[]; };\n"
    "layout(r32ui) STRATA_INTERLOCKED uniform uimage2DArray texels;\n"
    "STRATA_PARAMS { uint width; } params;\n"
    "void main() {\n"
    "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
    "    uint i = p.y * params.width + p.x, id = uint(gl_PrimitiveID);\n"
    "    STRATA_INTERLOCK_BEGIN\n"
    "    uint before = cells[i];\n"
    "    ivec3 texel = ivec3(p, before & 1u);\n"
    "    uint last = imageLoad(texels, texel).x;\n"
    "    if (before == id && (id < 2u || last == id - 2u)) {\n"
    "        imageStore(texels, texel, uvec4(id));\n"
    "        cells[i] = before + 1u;\n"
    "    }\n"
    "    STRATA_INTERLOCK_END\n"
    "}\n",
    "selftest.counting"};

strata_result gpu_selftest_draws(gpu_scope *scope, uint32_t triangles, strata_draws *draws) {
    const uint32_t count = triangles < GPU_SELFTEST_TRIANGLES ? triangles : GPU_SELFTEST_TRIANGLES;
    const uint32_t command[5] = {3 * count, 1, 0, 0, 0};
    uint32_t indices[3 * GPU_SELFTEST_TRIANGLES];
    gpu_draws_desc desc = {.capacity = 1};
    for (uint32_t i = 0; i < 3 * count; i++)
        indices[i] = i;
    const strata_buffer_desc command_desc = {.struct_size = sizeof command_desc,
                                             .label = "command",
                                             .size = sizeof command,
                                             .data = command};
    const strata_buffer_desc index_desc = {.struct_size = sizeof index_desc,
                                           .label = "indices",
                                           .size = 3 * count * sizeof *indices,
                                           .data = indices};
    strata_result result = gpu_buffer_create(scope, &command_desc, &desc.commands, NULL);
    if (result == STRATA_OK)
        result = gpu_buffer_create(scope, &index_desc, &desc.indices, NULL);
    return result == STRATA_OK ? gpu_draws_create(scope, &desc, draws, NULL) : result;
}

/* One draw of all triangles; 1 when each pixel saw each of them, in order. */
static int count_once(gpu *g, strata_program program, strata_buffer cells, strata_image texels,
                      strata_draws draws, uint32_t *values) {
    const uint32_t width = RMW_SIZE;
    const strata_bind binds[] = {{.struct_size = sizeof *binds, .name = "Cells", .buffer = cells},
                                 {.struct_size = sizeof *binds, .name = "texels", .image = texels}};
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "count",
                              .program = program,
                              .params = &width,
                              .params_size = sizeof width,
                              .binds = binds,
                              .bind_count = 2,
                              .draws = draws};
    gpu_begin(g, RMW_SIZE, RMW_SIZE);
    gpu_fill(g, "selftest", cells, 0, 0, 0);
    gpu_pass(g, "selftest", &pass);
    if (gpu_submit(g, NULL) != STRATA_OK ||
        gpu_buffer_read(g, cells, 0, RMW_SIZE * RMW_SIZE * 4, values, NULL) != STRATA_OK)
        return 0;
    for (uint32_t i = 0; i < RMW_SIZE * RMW_SIZE; i++)
        if (values[i] != RMW_PRIMITIVES)
            return 0;
    return 1;
}

/* Of fragments of a pixel: plain ones, or with STRATA_INTERLOCK those in sections. */
static int counts_in_order(gpu *g, gpu_scope *scope, const char *const *defines, uint32_t count) {
    const strata_program_desc program_desc = {.struct_size = sizeof program_desc,
                                              .kind = STRATA_PROGRAM_FULLSCREEN,
                                              .label = "selftest",
                                              .source = &counting,
                                              .defines = defines,
                                              .define_count = count};
    const strata_buffer_desc cells_desc = {
        .struct_size = sizeof cells_desc, .label = "cells", .size = RMW_SIZE * RMW_SIZE * 4};
    const strata_image_desc texels_desc = {.struct_size = sizeof texels_desc,
                                           .format = STRATA_FORMAT_R32U,
                                           .label = "texels",
                                           .width = RMW_SIZE,
                                           .height = RMW_SIZE,
                                           .layers = 2};
    strata_program program;
    strata_buffer cells;
    strata_image texels;
    strata_draws draws;
    int exact = 1;
    uint32_t *values = base_calloc(RMW_SIZE * RMW_SIZE, sizeof *values);
    if (!values || gpu_program_create(scope, &program_desc, &program, NULL) != STRATA_OK ||
        gpu_buffer_create(scope, &cells_desc, &cells, NULL) != STRATA_OK ||
        gpu_image_create(scope, &texels_desc, &texels, NULL) != STRATA_OK ||
        gpu_selftest_draws(scope, RMW_PRIMITIVES, &draws) != STRATA_OK)
        exact = 0;
    for (int i = 0; i < RMW_ROUNDS && exact; i++)
        exact = count_once(g, program, cells, texels, draws, values);
    free(values);
    return exact;
}

static int test_ordered_rmw(gpu *g, gpu_scope *scope) {
    return counts_in_order(g, scope, NULL, 0);
}

static int test_interlock(gpu *g, gpu_scope *scope) {
    static const char *const defines[] = {"STRATA_INTERLOCK"};
    return g->caps.fragment_interlock && counts_in_order(g, scope, defines, 1);
}

/* ---- ordered_attachments: are attachments read and replaced in primitive order? ---------------
 */

/* Beside the attachment each fragment counts in storage: such a pass may do both. */
static const strata_glsl replacing = {
    "#include \"strata/ordered.glsl\"\n"
    "STRATA_ORDERED_UINT(0)\n"
    "STRATA_ORDERED_UINT(1)\n"
    "layout(std430) buffer Cells { uint cells[]; };\n"
    "STRATA_PARAMS { uint width; } params;\n"
    "void main() {\n"
    "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
    "    uvec4 one = STRATA_ORDERED_LOAD(0), four = STRATA_ORDERED_LOAD(1);\n"
    "    uint id = uint(gl_PrimitiveID);\n"
    "    atomicAdd(cells[p.y * params.width + p.x], 1u);\n"
    "    STRATA_ORDERED_STORE(0, uvec4(one.x == id ? id + 1u : one.x));\n"
    "    STRATA_ORDERED_STORE(1, uvec4(four.yzw, four.x * 3u + id));\n"
    "}\n",
    "selftest.ordered_attachments"};

typedef struct replacing_test {
    strata_program program;
    strata_buffer cells;
    strata_image one, four;
    strata_draws draws;
    uint32_t *values; /* four a pixel */
} replacing_test;

static int all_are(const uint32_t *values, uint32_t width, const uint32_t *wanted) {
    for (uint32_t i = 0; i < RMW_SIZE * RMW_SIZE; i++)
        if (memcmp(values + (size_t)i * width, wanted, width * sizeof *wanted) != 0)
            return 0;
    return 1;
}

static int replace_once(gpu *g, const replacing_test *t) {
    const uint32_t width = RMW_SIZE, size = RMW_SIZE * RMW_SIZE * 4, count = RMW_PRIMITIVES;
    uint32_t four[4] = {0};
    const strata_attachment color[] = {
        {.struct_size = sizeof *color, .image = t->one, .load = STRATA_LOAD_CLEAR, .read = 1},
        {.struct_size = sizeof *color, .image = t->four, .load = STRATA_LOAD_CLEAR, .read = 1}};
    const strata_bind bind = {.struct_size = sizeof bind, .name = "Cells", .buffer = t->cells};
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "replace",
                              .program = t->program,
                              .params = &width,
                              .params_size = sizeof width,
                              .binds = &bind,
                              .bind_count = 1,
                              .color = color,
                              .color_count = 2,
                              .draws = t->draws};
    gpu_begin(g, RMW_SIZE, RMW_SIZE);
    gpu_fill(g, "selftest", t->cells, 0, 0, 0);
    gpu_pass(g, "selftest", &pass);
    for (uint32_t id = 0; id < count; id++) {
        const uint32_t before[4] = {four[0], four[1], four[2], four[3]};
        for (int k = 0; k < 3; k++)
            four[k] = before[k + 1];
        four[3] = before[0] * 3 + id;
    }
    return gpu_submit(g, NULL) == STRATA_OK &&
           gpu_buffer_read(g, t->cells, 0, size, t->values, NULL) == STRATA_OK &&
           all_are(t->values, 1, &count) &&
           gpu_image_read(g, t->one, 0, t->values, size, NULL) == STRATA_OK &&
           all_are(t->values, 1, &count) &&
           gpu_image_read(g, t->four, 0, t->values, 4 * (size_t)size, NULL) == STRATA_OK &&
           all_are(t->values, 4, four);
}

static int test_ordered_attachments(gpu *g, gpu_scope *scope) {
    const strata_program_desc program_desc = {.struct_size = sizeof program_desc,
                                              .kind = STRATA_PROGRAM_FULLSCREEN,
                                              .label = "selftest",
                                              .source = &replacing};
    const strata_buffer_desc cells_desc = {
        .struct_size = sizeof cells_desc, .label = "cells", .size = RMW_SIZE * RMW_SIZE * 4};
    strata_image_desc image_desc = {.struct_size = sizeof image_desc,
                                    .format = STRATA_FORMAT_R32U,
                                    .label = "one",
                                    .width = RMW_SIZE,
                                    .height = RMW_SIZE};
    replacing_test t = {.values = base_calloc(RMW_SIZE * RMW_SIZE * 4, sizeof *t.values)};
    int exact = t.values &&
                gpu_program_create(scope, &program_desc, &t.program, NULL) == STRATA_OK &&
                gpu_buffer_create(scope, &cells_desc, &t.cells, NULL) == STRATA_OK &&
                gpu_image_create(scope, &image_desc, &t.one, NULL) == STRATA_OK;
    image_desc.format = STRATA_FORMAT_RGBA32U;
    exact = exact && gpu_image_create(scope, &image_desc, &t.four, NULL) == STRATA_OK &&
            gpu_selftest_draws(scope, RMW_PRIMITIVES, &t.draws) == STRATA_OK;
    for (int i = 0; i < RMW_ROUNDS && exact; i++)
        exact = replace_once(g, &t);
    free(t.values);
    return exact;
}

/* ---- running and remembering ----------------------------------------------------------------- */

static const struct {
    const char *id;
    int (*run)(gpu *g, gpu_scope *scope);
} selftests[GPU_SELFTESTS] = {
    {"selftest.timestamps", test_timestamps},
    {"selftest.ordered_rmw", test_ordered_rmw},
    {"selftest.interlock", test_interlock},
    {"selftest.ordered_attachments", test_ordered_attachments},
    {"selftest.sample_routing", gpu_selftest_sample_routing},
};

/* File of a result, and the whole text that it has when the result is `value`. */
static int describe_result(const gpu *g, const char *id, int value, char *path, size_t path_size,
                           char *text, size_t text_size) {
    const uint32_t version = SELFTEST_VERSION;
    uint64_t hash = base_hash(0, &version, sizeof version);
    hash = base_hash(hash, g->caps.name, strlen(g->caps.name) + 1);
    hash = base_hash(hash, g->caps.driver, strlen(g->caps.driver) + 1);
    int length = snprintf(path, path_size, "%s/%s/%s-%016" PRIx64, g->cache_dir, "selftest",
                          g->backend->name, hash);
    int more = length < 0 || (size_t)length >= path_size
                   ? -1
                   : snprintf(path + length, path_size - (size_t)length, "-%s", id + 9);
    snprintf(text, text_size, "%u %s %s %s: %d\n", version, id, g->caps.name, g->caps.driver,
             value);
    return more >= 0 && (size_t)more < path_size - (size_t)length;
}

static int load_result(const gpu *g, const char *id, int *value) {
    char path[4096], text[1024];
    unsigned char *data = NULL;
    size_t size = 0;
    base_error ignored = {0};
    int found = 0;
    for (int i = 0; i < 2 && g->cache_dir && !found; i++) {
        if (!describe_result(g, id, i, path, sizeof path, text, sizeof text) ||
            base_file_read(path, sizeof text, &data, &size, &ignored) != STRATA_OK)
            return 0;
        found = size == strlen(text) && memcmp(data, text, size) == 0;
        *value = i;
        free(data);
    }
    return found;
}

static void store_result(const gpu *g, const char *id, int value) {
    char path[4096], text[1024], folder[4096];
    base_output out;
    base_error ignored = {0};
    if (!g->cache_dir)
        return;
    int length = snprintf(folder, sizeof folder, "%s/selftest", g->cache_dir);
    if (length < 0 || (size_t)length >= sizeof folder ||
        !describe_result(g, id, value, path, sizeof path, text, sizeof text) ||
        base_make_folders(folder, &ignored) != STRATA_OK ||
        base_output_open(&out, path, &ignored) != STRATA_OK)
        return;
    if (base_output_write(&out, text, strlen(text), &ignored) == STRATA_OK)
        base_output_commit(&out, &ignored);
    else
        base_output_abort(&out);
}

static int run_test(gpu *g, size_t index) {
    const gpu_open_info info = {.backend = g->backend->name,
                                .device = g->device_name,
                                .cache_dir = g->cache_dir,
                                .profile = 1};
    gpu *other = NULL;
    int value = 0;
    if (g->open) /* one device at a time records */
        gpu_flush(g);
    if (gpu_open(&info, &other, NULL) != STRATA_OK)
        return 0;
    other->selftest_running = 1;
    gpu_scope *scope = gpu_scope_create(other, "selftest");
    if (scope)
        value = selftests[index].run(other, scope);
    gpu_close(other);
    base_log(BASE_LOG_INFO, "%s: %s: %s", g->caps.name, selftests[index].id,
             value ? "passed" : "failed");
    return value;
}

int gpu_selftest(gpu *g, const char *id) {
    for (size_t i = 0; i < GPU_SELFTESTS; i++) {
        if (strcmp(id, selftests[i].id) != 0)
            continue;
        int value = g->selftests[i];
        if (value < 0 && (g->selftest_running || g->lost || g->backend == &gpu_backend_null))
            return 0;
        if (value < 0 && !load_result(g, id, &value)) {
            value = run_test(g, i);
            store_result(g, id, value);
        }
        g->selftests[i] = (signed char)value;
        return value;
    }
    return 0;
}
