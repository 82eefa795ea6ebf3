/* SPDX-License-Identifier: MIT
 *
 * The GPU core over the null backend: derived barriers as the log shows them, scopes and history,
 * who holds how many bytes, pools, timings, refused allocations at each place.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_fixture.h"

#define ON_NULL(test) cmocka_unit_test_setup_teardown(test, open_null, close_fixture)

static const strata_glsl update = {"layout(local_size_x = 64) in;\n"
                                   "layout(std430) buffer Values { uint values[]; };\n"
                                   "void main() { values[gl_GlobalInvocationID.x] += 1u; }\n",
                                   "update.glsl"};
static const strata_glsl reduce = {"layout(local_size_x = 64) in;\n"
                                   "layout(std430) readonly buffer Values { uint values[]; };\n"
                                   "layout(std430) writeonly buffer Sums { uint sums[]; };\n"
                                   "void main() { sums[0] = values[0]; }\n",
                                   "reduce.glsl"};
static const strata_glsl show = {"layout(location = 0) out vec4 color;\n"
                                 "layout(std430) readonly buffer Values { uint values[]; };\n"
                                 "void main() { color = vec4(float(values[0])); }\n",
                                 "show.glsl"};
static const strata_glsl sample_source = {
    "layout(location = 0) out vec4 color;\n"
    "uniform sampler2D source;\n"
    "void main() { color = texelFetch(source, ivec2(gl_FragCoord.xy), 0); }\n",
    "sample.glsl"};
static const strata_glsl append_source = {
    "layout(local_size_x = 64) in;\n"
    "layout(std430) buffer Counter { uint needed; uint capacity; };\n"
    "layout(std430) writeonly buffer Keys { uvec2 keys[]; };\n"
    "void main() {\n"
    "    uint slot = atomicAdd(needed, 1u);\n"
    "    if (slot < capacity)\n"
    "        keys[slot] = uvec2(slot);\n"
    "}\n",
    "append.glsl"};

static void dispatch(fixture *f, const char *label, strata_program program,
                     const strata_bind *binds, uint32_t count) {
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = label,
                              .groups = {1},
                              .program = program,
                              .binds = binds,
                              .bind_count = count};
    gpu_pass(f->g, "test", &pass);
    if (gpu_frame_error(f->g)->result != STRATA_OK)
        fail_msg("%s", gpu_frame_error(f->g)->text);
}

static void draw(fixture *f, const char *label, strata_program program, strata_image target,
                 const strata_bind *binds, uint32_t count) {
    const strata_attachment color = {.struct_size = sizeof color, .image = target};
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = label,
                              .program = program,
                              .binds = binds,
                              .bind_count = count,
                              .color = &color,
                              .color_count = 1};
    gpu_pass(f->g, "test", &pass);
    if (gpu_frame_error(f->g)->result != STRATA_OK)
        fail_msg("%s", gpu_frame_error(f->g)->text);
}

static void submit(fixture *f) {
    if (gpu_submit(f->g, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
}

/* ---- hazards -------------------------------------------------------------------------------- */

static void test_hazards_buffer(void **state) {
    fixture *f = *state;
    strata_bind binds[2] = {bind_buffer("Values", make_buffer(f, "values", 256)),
                            bind_buffer("Sums", make_buffer(f, "sums", 256))};
    strata_image target = make_image(f, "target", STRATA_FORMAT_RGBA32F, 4, 4, 0);
    strata_program writes = make_program(f, STRATA_PROGRAM_COMPUTE, &update);
    strata_program reads = make_program(f, STRATA_PROGRAM_COMPUTE, &reduce);
    strata_program shows = make_program(f, STRATA_PROGRAM_FULLSCREEN, &show);
    gpu_begin(f->g, 4, 4);
    dispatch(f, "w1", writes, binds, 1);    /* after the zeros it was made with */
    dispatch(f, "w2", writes, binds, 1);    /* write after write */
    dispatch(f, "r1", reads, binds, 2);     /* read after write */
    dispatch(f, "r2", reads, binds, 2);     /* values: visible already; sums: write after write */
    draw(f, "s1", shows, target, binds, 1); /* another stage */
    draw(f, "s2", shows, target, binds, 1);
    dispatch(f, "w3", writes, binds, 1); /* write after reads in both stages */
    submit(f);
    assert_logged(f, "pass w1 program program groups 1x1x1 Values=values "
                     "[values copy-write>storage-read|storage-write/c]\n");
    assert_logged(f, "pass w2 program program groups 1x1x1 Values=values "
                     "[values storage-read|storage-write/c>storage-read|storage-write/c]\n");
    assert_logged(f, "pass r1 program program groups 1x1x1 Values=values Sums=sums "
                     "[values storage-read|storage-write/c>storage-read/c] "
                     "[sums copy-write>storage-write/c]\n");
    assert_logged(f, "pass r2 program program groups 1x1x1 Values=values Sums=sums "
                     "[sums storage-write/c>storage-write/c]\n");
    assert_logged(f, "pass s1 program program 4x4 scissor 0,0 4x4 color target Values=values "
                     "[values storage-read|storage-write/c>storage-read/f] "
                     "[target copy-write>color]\n");
    assert_logged(f, "pass s2 program program 4x4 scissor 0,0 4x4 color target Values=values "
                     "[target color>color]\n");
    assert_logged(f, "pass w3 program program groups 1x1x1 Values=values "
                     "[values storage-read|storage-write/fc>storage-read|storage-write/c]\n");
}

static void test_hazards_image(void **state) {
    fixture *f = *state;
    strata_image first = make_image(f, "first", STRATA_FORMAT_RGBA32F, 4, 4, 0);
    strata_image second = make_image(f, "second", STRATA_FORMAT_RGBA32F, 4, 4, 0);
    const strata_bind source = bind_image("source", first);
    const float clear[4] = {0};
    strata_program samples = make_program(f, STRATA_PROGRAM_FULLSCREEN, &sample_source);
    gpu_begin(f->g, 4, 4);
    gpu_clear_image(f->g, "test", first, clear);
    draw(f, "a", samples, second, &source, 1);
    gpu_clear_image(f->g, "test", first, clear);
    submit(f);
    draw(f, "b", samples, second, &source, 1); /* remembered across submissions */
    submit(f);
    assert_logged(f, "clear first 0 0 0 0 [first copy-write>copy-write]\n");
    assert_logged(f, "source=first [first copy-write>sampled/f] [second copy-write>color]\n");
    assert_logged(f, "clear first 0 0 0 0 [first sampled|copy-write/f>copy-write]\n");
    assert_logged(f, "pass b program program 4x4 scissor 0,0 4x4 color second source=first "
                     "[first copy-write>sampled/f] [second color>color]\n");
}

static void test_hazards_copies(void **state) {
    fixture *f = *state;
    strata_buffer a = make_buffer(f, "a", 512), b = make_buffer(f, "b", 512);
    const strata_bind values = bind_buffer("Values", a);
    strata_program writes = make_program(f, STRATA_PROGRAM_COMPUTE, &update);
    const strata_pass indirect = {.struct_size = sizeof indirect,
                                  .label = "indirect",
                                  .program = writes,
                                  .binds = &values,
                                  .bind_count = 1,
                                  .indirect = b,
                                  .indirect_offset = 12};
    gpu_begin(f->g, 4, 4);
    gpu_fill(f->g, "test", a, 0, 0, 7);
    gpu_copy(f->g, "test", b, 0, a, 0, 256);
    gpu_pass(f->g, "test", &indirect);
    gpu_fill(f->g, "test", b, 0, 4, 1);
    submit(f);
    assert_logged(f, "fill a 0+512 = 7 [a copy-write>copy-write]\n");
    assert_logged(f, "copy a 0 to b 0 + 256 [a copy-write>copy-read] [b copy-write>copy-write]\n");
    assert_logged(f, "pass indirect program program indirect b Values=a "
                     "[a copy-read|copy-write>storage-read|storage-write/c] "
                     "[b copy-write>indirect]\n");
    assert_logged(f, "fill b 0+4 = 1 [b indirect|copy-write>copy-write]\n");
    uint32_t words[2];
    assert_int_equal(gpu_buffer_read(f->g, b, 0, 8, words, &f->err), STRATA_OK);
    assert_int_equal(words[0], 1);
    assert_int_equal(words[1], 7);
}

/* The host's own writes are writes, and one storage under two names is one use. */
static void test_hazards_host_and_names(void **state) {
    fixture *f = *state;
    const uint32_t word = 1;
    strata_buffer values = make_buffer(f, "values", 256);
    const strata_bind apart[2] = {bind_buffer("Values", values),
                                  bind_buffer("Sums", make_buffer(f, "sums", 256))};
    const strata_bind both[2] = {bind_buffer("Values", values), bind_buffer("Sums", values)};
    strata_program reads = make_program(f, STRATA_PROGRAM_COMPUTE, &reduce);
    gpu_begin(f->g, 4, 4);
    dispatch(f, "one", reads, apart, 2);
    submit(f);
    assert_int_equal(gpu_buffer_write(f->g, values, 0, 4, &word, &f->err), STRATA_OK);
    dispatch(f, "two", reads, apart, 2);
    dispatch(f, "three", reads, both, 2);
    dispatch(f, "four", reads, apart, 2);
    submit(f);
    assert_logged(f, "pass two program program groups 1x1x1 Values=values Sums=sums "
                     "[values copy-write>storage-read/c] [sums storage-write/c>storage-write/c]\n");
    assert_logged(f, "pass three program program groups 1x1x1 Values=values Sums=values "
                     "[values storage-read|copy-write/c>storage-read|storage-write/c]\n");
    assert_logged(f, "pass four program program groups 1x1x1 Values=values Sums=sums "
                     "[values storage-read|storage-write/c>storage-read/c] ");
}

static const strata_glsl scene_source = {
    "#include \"strata/frame.glsl\"\n"
    "layout(location = 0) out vec4 color;\n"
    "layout(std430) readonly buffer Values { uint values[]; };\n"
    "void main() { color = strata_background * float(values[0]); }\n",
    "scene.glsl"};

/* Stages of one use, and of two uses of one storage, are joined; draws read theirs. */
static void test_hazards_stages(void **state) {
    fixture *f = *state;
    strata_buffer frame = make_buffer(f, "frame", 4096), shared = make_buffer(f, "shared", 4096);
    strata_buffer commands = make_buffer(f, "commands", 20);
    strata_image target = make_image(f, "target", STRATA_FORMAT_RGBA32F, 4, 4, 0);
    const strata_bind binds[] = {bind_buffer("StrataFrame", frame),
                                 bind_buffer("StrataRecords", shared),
                                 bind_buffer("StrataPositions", make_buffer(f, "positions", 4096)),
                                 bind_buffer("StrataMaterials", make_buffer(f, "materials", 4096)),
                                 bind_buffer("Values", shared)};
    const gpu_draws_desc desc = {.commands = commands,
                                 .count = make_buffer(f, "count", 4),
                                 .indices = make_buffer(f, "indices", 4),
                                 .capacity = 1};
    const strata_attachment color = {.struct_size = sizeof color, .image = target};
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "scene",
                        .program = make_program(f, STRATA_PROGRAM_SCENE, &scene_source),
                        .binds = binds,
                        .bind_count = BASE_COUNT(binds),
                        .color = &color,
                        .color_count = 1};
    assert_int_equal(gpu_draws_create(f->scope, &desc, &pass.draws, &f->err), STRATA_OK);
    gpu_begin(f->g, 4, 4);
    gpu_pass(f->g, "test", &pass);
    submit(f);
    assert_logged(f, "[frame copy-write>uniform/vf]");
    assert_logged(f, "[shared copy-write>storage-read/vf]");
    assert_logged(f, "[positions copy-write>storage-read/v]");
    assert_logged(f, "[commands copy-write>indirect]");
    assert_logged(f, "[count copy-write>indirect]");
    assert_logged(f, "[indices copy-write>index]");
}

/* ---- scopes, history, bytes ------------------------------------------------------------------ */

static strata_buffer history_buffer(fixture *f, gpu_scope *scope, uint64_t size) {
    strata_buffer buffer;
    const strata_buffer_desc desc = {
        .struct_size = sizeof desc, .label = "kept", .size = size, .history = "kept"};
    assert_int_equal(gpu_buffer_create(scope, &desc, &buffer, &f->err), STRATA_OK);
    return buffer;
}

static uint32_t first_word(fixture *f, strata_buffer buffer) {
    uint32_t word = 0;
    assert_int_equal(gpu_buffer_read(f->g, buffer, 0, 4, &word, &f->err), STRATA_OK);
    return word;
}

static void test_history(void **state) {
    fixture *f = *state;
    const uint32_t seven = 7;
    gpu_scope *create = gpu_scope_create(f->g, "owner"); /* as a technique's create() */
    gpu_scope *prepare = gpu_scope_create(f->g, "owner");
    strata_buffer old = history_buffer(f, prepare, 64);
    assert_int_equal(gpu_buffer_write(f->g, old, 0, 4, &seven, &f->err), STRATA_OK);
    gpu_scope_end(prepare);
    uint32_t word;
    assert_int_not_equal(gpu_buffer_read(f->g, old, 0, 4, &word, &f->err), STRATA_OK);
    f->err = (base_error){0};
    prepare = gpu_scope_create(f->g, "owner");
    strata_buffer again = history_buffer(f, prepare, 64);
    assert_int_not_equal(again.id, old.id);
    assert_int_equal(first_word(f, again), 7);
    gpu_scope_end(prepare);
    prepare = gpu_scope_create(f->g, "owner");
    assert_int_equal(first_word(f, history_buffer(f, prepare, 128)), 0); /* another size */
    assert_int_equal(gpu_bytes(f->g, "owner"), 128);
    gpu_scope_end(prepare);
    assert_int_equal(gpu_bytes(f->g, "owner"), 128);
    gpu_scope_end(create); /* the owner's last */
    assert_int_equal(gpu_bytes(f->g, "owner"), 0);
    create = gpu_scope_create(f->g, "owner");
    assert_int_equal(first_word(f, history_buffer(f, create, 128)), 0);
    gpu_scope *other = gpu_scope_create(f->g, "other"); /* names are each owner's own */
    assert_int_equal(first_word(f, history_buffer(f, other, 64)), 0);
}

static void test_history_image(void **state) {
    fixture *f = *state;
    const uint32_t texel = 5;
    uint32_t read[4];
    strata_image image;
    strata_image_desc desc = {.struct_size = sizeof desc,
                              .label = "ids",
                              .format = STRATA_FORMAT_R32U,
                              .width = 2,
                              .height = 2,
                              .history = "ids"};
    gpu_scope *scope = gpu_scope_create(f->g, "test");
    assert_int_equal(gpu_image_create(scope, &desc, &image, &f->err), STRATA_OK);
    assert_int_equal(gpu_image_write(f->g, image, 0, 1, 1, 1, 1, &texel, &f->err), STRATA_OK);
    gpu_scope_end(scope);
    scope = gpu_scope_create(f->g, "test");
    assert_int_equal(gpu_image_create(scope, &desc, &image, &f->err), STRATA_OK);
    assert_int_equal(gpu_image_read(f->g, image, 0, read, sizeof read, &f->err), STRATA_OK);
    assert_int_equal(read[3], 5);
    gpu_scope_end(scope);
    desc.format = STRATA_FORMAT_R32F; /* as many bytes, another meaning */
    scope = gpu_scope_create(f->g, "test");
    assert_int_equal(gpu_image_create(scope, &desc, &image, &f->err), STRATA_OK);
    assert_int_equal(gpu_image_read(f->g, image, 0, read, sizeof read, &f->err), STRATA_OK);
    assert_int_equal(read[3], 0);
}

static void test_bytes(void **state) {
    fixture *f = *state;
    make_buffer(f, "a", 1000);
    gpu_scope *scope = gpu_scope_create(f->g, "other");
    strata_buffer buffer;
    const strata_buffer_desc desc = {.struct_size = sizeof desc, .label = "b", .size = 500};
    assert_int_equal(gpu_buffer_create(scope, &desc, &buffer, &f->err), STRATA_OK);
    make_image(f, "i", STRATA_FORMAT_RGBA32F, 4, 4, 3);
    assert_int_equal(gpu_bytes(f->g, "test"), 1000 + 4 * 4 * 3 * 16);
    assert_int_equal(gpu_bytes(f->g, "other"), 500);
    assert_int_equal(gpu_bytes(f->g, NULL), 1500 + 768);
    gpu_scope_end(scope);
    assert_logged(f, "destroy buffer b\n");
    assert_int_equal(gpu_bytes(f->g, "other"), 0);
    assert_int_equal(gpu_bytes_peak(f->g, "other"), 500);
    assert_int_equal(gpu_bytes(f->g, NULL), 1000 + 768);
    assert_int_equal(gpu_bytes_peak(f->g, NULL), 1500 + 768);
    assert_int_equal(gpu_bytes(f->g, "nobody"), 0);
}

/* What recorded commands name must not die under them. */
static void test_scope_ends_while_recording(void **state) {
    fixture *f = *state;
    gpu_scope *scope = gpu_scope_create(f->g, "short");
    strata_buffer buffer;
    const strata_buffer_desc desc = {.struct_size = sizeof desc, .label = "b", .size = 4};
    assert_int_equal(gpu_buffer_create(scope, &desc, &buffer, &f->err), STRATA_OK);
    gpu_begin(f->g, 4, 4);
    gpu_fill(f->g, "test", buffer, 0, 4, 1);
    gpu_scope_end(scope);
    const char *submitted = strstr(gpu_null_log(f->g), "submit\n");
    const char *destroyed = strstr(gpu_null_log(f->g), "destroy buffer b\n");
    assert_non_null(submitted);
    assert_non_null(destroyed);
    assert_true(submitted < destroyed);
}

/* ---- pools ---------------------------------------------------------------------------------- */

static strata_pool make_pool(fixture *f, uint64_t expected) {
    strata_pool pool;
    const strata_pool_desc desc = {.struct_size = sizeof desc,
                                   .plane_count = 2,
                                   .label = "records",
                                   .counter_name = "Counter",
                                   .plane_names = {"Keys", "Payload"},
                                   .plane_strides = {8, 4},
                                   .expected = expected};
    if (gpu_pool_create(f->scope, &desc, &pool, &f->err) != STRATA_OK)
        fail_msg("%s", f->err.text);
    return pool;
}

static void test_pool_sizes(void **state) {
    fixture *f = *state;
    uint64_t limit = gpu_fact(f->g, "limit.storage_range") / 8;
    strata_pool pool = make_pool(f, 0);
    assert_int_equal(gpu_pool_capacity(f->g, pool), 1024);
    assert_int_equal(gpu_pool_limit(f->g, pool), limit);
    assert_int_equal(gpu_pool_element_bytes(f->g, pool), 12);
    assert_int_equal(gpu_bytes(f->g, "test"), 1024 * 12 + 8);
    assert_int_equal(gpu_pool_capacity(f->g, make_pool(f, UINT64_MAX)), limit);
    assert_int_equal(gpu_pool_capacity(f->g, (strata_pool){0}), 0);
    assert_int_equal(gpu_pool_plane(f->g, pool, 2).id, 0);
    assert_int_equal(gpu_pool_grow(f->g, pool, limit + 1, &f->err), STRATA_ERROR_OVERFLOW);
    assert_int_equal(gpu_pool_capacity(f->g, pool), 1024);
}

static void test_pool_in_passes(void **state) {
    fixture *f = *state;
    const uint32_t asked = 99;
    uint64_t needed = 1;
    strata_pool pool = make_pool(f, 64);
    const strata_bind bind = bind_pool(pool);
    strata_program program = make_program(f, STRATA_PROGRAM_COMPUTE, &append_source);
    gpu_begin(f->g, 4, 4);
    assert_int_equal(gpu_pool_needed(f->g, pool, &needed, &f->err), STRATA_OK);
    assert_int_equal(needed, 0);
    dispatch(f, "append", program, &bind, 1);
    dispatch(f, "append", program, &bind, 1);
    submit(f);
    assert_logged(f, "fill records.Counter 0+4 = 0 [records.Counter copy-write>copy-write]\n"
                     "pass append program program groups 1x1x1 Keys=records.Keys "
                     "Counter=records.Counter "); /* Payload: the program has no such block */
    const char *cleared = strstr(gpu_null_log(f->g), "fill records.Counter");
    assert_null(strstr(cleared + 1, "fill records.Counter")); /* once a frame */
    assert_not_logged(f, "Payload=");

    /* What the frame asked for stands until the next frame begins. */
    strata_buffer counter = {gpu_pool_plane(f->g, pool, 1).id + 1};
    uint32_t capacity = 0;
    assert_int_equal(gpu_buffer_read(f->g, counter, 4, 4, &capacity, &f->err), STRATA_OK);
    assert_int_equal(capacity, 64);
    assert_int_equal(gpu_buffer_write(f->g, counter, 0, 4, &asked, &f->err), STRATA_OK);
    assert_int_equal(gpu_pool_needed(f->g, pool, &needed, &f->err), STRATA_OK);
    assert_int_equal(needed, 99);
    assert_int_equal(gpu_pool_grow(f->g, pool, needed, &f->err), STRATA_OK);
    assert_int_equal(gpu_pool_capacity(f->g, pool), 99);
    assert_int_equal(gpu_buffer_read(f->g, counter, 4, 4, &capacity, &f->err), STRATA_OK);
    assert_int_equal(capacity, 99);
    gpu_begin(f->g, 4, 4);
    assert_int_equal(gpu_pool_needed(f->g, pool, &needed, &f->err), STRATA_OK);
    assert_int_equal(needed, 0);
}

static void test_pool_grow_frees_first(void **state) {
    fixture *f = *state;
    strata_pool pool = make_pool(f, 64);
    size_t before = strlen(gpu_null_log(f->g));
    assert_int_equal(gpu_pool_grow(f->g, pool, 128, &f->err), STRATA_OK);
    const char *log = gpu_null_log(f->g) + before;
    assert_true(strstr(log, "destroy buffer records.Payload") <
                strstr(log, "buffer records.Keys 1024"));
    assert_int_equal(gpu_bytes_peak(f->g, "test"), 128 * 12 + 8);
    gpu_begin(f->g, 4, 4);
    gpu_fill(f->g, "test", gpu_pool_plane(f->g, pool, 0), 0, 0, 0);
    assert_int_equal(gpu_pool_grow(f->g, pool, 256, &f->err), STRATA_ERROR_INVALID_STATE);
    submit(f);
}

static void test_pool_grow_fails(void **state) {
    fixture f;
    (void)state;
    open_device(&f, &(gpu_open_info){.backend = "null", .inject = "allocation:2"});
    strata_pool pool = make_pool(&f, 64);
    assert_int_equal(gpu_pool_grow(f.g, pool, 1 << 20, &f.err), STRATA_ERROR_OUT_OF_DEVICE_MEMORY);
    assert_int_equal(gpu_pool_capacity(f.g, pool), 1024);
    f.err = (base_error){0};
    assert_int_equal(gpu_pool_grow(f.g, pool, 1 << 20, &f.err), STRATA_OK);
    assert_int_equal(gpu_pool_capacity(f.g, pool), 1 << 20);
    gpu_close(f.g);
}

/* ---- failures at each place ------------------------------------------------------------------ */

/* Makes one of everything; the result of the first that fails. */
static strata_result make_all(fixture *f) {
    strata_buffer buffer;
    strata_image image;
    strata_pool pool;
    strata_program program;
    const strata_buffer_desc buffer_desc = {
        .struct_size = sizeof buffer_desc, .label = "b", .size = 64, .history = "b"};
    const strata_image_desc image_desc = {.struct_size = sizeof image_desc,
                                          .label = "i",
                                          .format = STRATA_FORMAT_R32F,
                                          .width = 4,
                                          .height = 4,
                                          .history = "i"};
    const strata_pool_desc pool_desc = {.struct_size = sizeof pool_desc,
                                        .plane_count = 1,
                                        .label = "p",
                                        .counter_name = "Counter",
                                        .plane_names = {"Keys"},
                                        .plane_strides = {8}};
    const strata_program_desc program_desc = {.struct_size = sizeof program_desc,
                                              .kind = STRATA_PROGRAM_COMPUTE,
                                              .label = "program",
                                              .source = &append_source};
    strata_result result = gpu_buffer_create(f->scope, &buffer_desc, &buffer, &f->err);
    if (result == STRATA_OK)
        result = gpu_image_create(f->scope, &image_desc, &image, &f->err);
    if (result == STRATA_OK)
        result = gpu_pool_create(f->scope, &pool_desc, &pool, &f->err);
    if (result == STRATA_OK)
        result = gpu_program_create(f->scope, &program_desc, &program, &f->err);
    if (result == STRATA_OK)
        result = gpu_pool_grow(f->g, pool, 2048, &f->err);
    return result;
}

static void test_each_allocation(void **state) {
    (void)state;
    for (int n = 1; n <= 6; n++) {
        fixture f;
        char inject[32];
        snprintf(inject, sizeof inject, "allocation:%d", n);
        open_device(&f, &(gpu_open_info){.backend = "null", .inject = inject});
        strata_result expected = n <= 5 ? STRATA_ERROR_OUT_OF_DEVICE_MEMORY : STRATA_OK;
        assert_int_equal(make_all(&f), expected);
        if (n <= 5)
            assert_int_equal(gpu_last_code(f.g), GPU_ERROR_MEMORY);
        gpu_scope_end(f.scope);
        assert_int_equal(gpu_bytes(f.g, NULL), 0);
        f.scope = gpu_scope_create(f.g, "test");
        f.err = (base_error){0};
        strata_result again = n == 6 ? STRATA_ERROR_OUT_OF_DEVICE_MEMORY : STRATA_OK;
        assert_int_equal(make_all(&f), again); /* none but the n-th fails */
        gpu_close(f.g);
    }
}

/* ---- timings, errors, facts ------------------------------------------------------------------ */

static void test_timings(void **state) {
    fixture *f = *state;
    const strata_bind values = bind_buffer("Values", make_buffer(f, "values", 256));
    strata_program program = make_program(f, STRATA_PROGRAM_COMPUTE, &update);
    uint32_t count;
    gpu_begin(f->g, 4, 4);
    dispatch(f, "one", program, &values, 1);
    submit(f);
    dispatch(f, "two", program, &values, 1);
    submit(f);
    const gpu_timing *timings = gpu_timings(f->g, &count);
    assert_int_equal(count, 2);
    assert_string_equal(timings[0].label, "one");
    assert_string_equal(timings[1].label, "two");
    assert_string_equal(timings[1].owner, "test");
    assert_true(timings[1].gpu_ms < 0 && timings[1].cpu_ms >= 0);
    gpu_begin(f->g, 4, 4);
    gpu_timings(f->g, &count);
    assert_int_equal(count, 0);
}

static void test_first_error_sticks(void **state) {
    fixture *f = *state;
    strata_buffer buffer = make_buffer(f, "b", 16);
    gpu_begin(f->g, 4, 4);
    gpu_fill(f->g, "test", buffer, 0, 4, 1);
    gpu_frame_fail(f->g, "owner", STRATA_ERROR_OVERFLOW, "too many");
    gpu_frame_fail(f->g, "owner", STRATA_ERROR_IO, "later");
    gpu_fill(f->g, "test", buffer, 4, 4, 2);
    gpu_fill(f->g, "test", buffer, 99, 4, 2);
    assert_int_equal(gpu_submit(f->g, &f->err), STRATA_ERROR_OVERFLOW);
    assert_string_equal(f->err.text, "owner: too many");
    assert_logged(f, "fill b 0+4 = 1");
    assert_not_logged(f, "fill b 4+4");
    f->err = (base_error){0};
    gpu_begin(f->g, 4, 4);
    gpu_fill(f->g, "test", buffer, 4, 4, 2);
    submit(f);
    assert_logged(f, "fill b 4+4 = 2");
}

static void test_rectangle(void **state) {
    fixture *f = *state;
    strata_image target = make_image(f, "target", STRATA_FORMAT_RGBA32F, 10, 10, 0);
    strata_image small = make_image(f, "small", STRATA_FORMAT_RGBA32F, 4, 4, 0);
    const strata_bind values = bind_buffer("Values", make_buffer(f, "values", 256));
    strata_program program = make_program(f, STRATA_PROGRAM_FULLSCREEN, &show);
    gpu_begin(f->g, 10, 10);
    gpu_rectangle(f->g, 2, 6, 20, 20);
    draw(f, "a", program, target, &values, 1);
    draw(f, "b", program, small, &values, 1);
    submit(f);
    assert_logged(f, "pass a program program 10x10 scissor 2,6 8x4 ");
    assert_logged(f, "pass b program program 4x4 scissor 2,4 2x0 ");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        ON_NULL(test_hazards_buffer),
        ON_NULL(test_hazards_image),
        ON_NULL(test_hazards_copies),
        ON_NULL(test_hazards_host_and_names),
        ON_NULL(test_hazards_stages),
        ON_NULL(test_history),
        ON_NULL(test_history_image),
        ON_NULL(test_bytes),
        ON_NULL(test_scope_ends_while_recording),
        ON_NULL(test_pool_sizes),
        ON_NULL(test_pool_in_passes),
        ON_NULL(test_pool_grow_frees_first),
        cmocka_unit_test(test_pool_grow_fails),
        cmocka_unit_test(test_each_allocation),
        ON_NULL(test_timings),
        ON_NULL(test_first_error_sticks),
        ON_NULL(test_rectangle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
