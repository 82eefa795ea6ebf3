/* SPDX-License-Identifier: MIT
 *
 * Native passes over the null backend: what orders them, that the callback runs exactly where a
 * sound pass is recorded, and each way in which one is refused. Handles are 0 where no API is.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_world.h"

static unsigned calls;

static void count_call(void *user, uint64_t handle) {
    assert_int_equal(handle, 0);
    calls += *(unsigned *)user;
}

static unsigned one = 1;

static strata_pass native(world *w) {
    return (strata_pass){
        .struct_size = sizeof(strata_pass), .label = "own", .binds = w->binds, .bind_count = 1};
}

static void run(world *w, const strata_pass *pass) {
    gpu_pass_native(w->f.g, "tester", pass, count_call, &one);
    if (gpu_frame_error(w->f.g)->result != STRATA_OK)
        fail_msg("%s", gpu_frame_error(w->f.g)->text);
}

static void native_refused(world *w, const strata_pass *pass, gpu_code code, const char *text) {
    const size_t before = strlen(gpu_null_log(w->f.g));
    const unsigned made = calls;
    gpu_pass_native(w->f.g, "tester", pass, count_call, &one);
    const base_error *failure = gpu_frame_error(w->f.g);
    if (failure->result == STRATA_OK || gpu_last_code(w->f.g) != code)
        fail_msg("expected '%s', got '%s' (%s)", gpu_code_text(code),
                 gpu_code_text(gpu_last_code(w->f.g)), failure->text);
    assert_non_null(strstr(failure->text, text));
    assert_non_null(strstr(failure->text, "tester"));
    assert_string_equal(gpu_null_log(w->f.g) + before, "");
    gpu_pass_native(w->f.g, "tester", &(strata_pass){.struct_size = sizeof *pass, .label = "late"},
                    count_call, &one); /* a frame that failed records nothing more */
    assert_int_equal(calls, made);
    gpu_begin(w->f.g, 16, 16);
}

/* Whatever was written before is there, and whatever comes after waits. */
static void test_order(void **state) {
    world *w = *state;
    const strata_pass pass = native(w);
    calls = 0;
    accepted(w, &w->dispatch);
    run(w, &pass);
    accepted(w, &w->dispatch);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    assert_int_equal(calls, 1);
    assert_logged(&w->f, "pass own native 16x16 scissor 0,0 16x16"
                         " [values storage-read|storage-write/c>native]\n");
    assert_logged(&w->f, "[values native>storage-read|storage-write/c]");
    gpu_begin(w->f.g, 16, 16);
    run(w, &pass);
    run(w, &pass); /* one after the other: either may write */
    assert_logged(&w->f, "pass own native 16x16 scissor 0,0 16x16 [values native>native]\n");
    assert_int_equal(calls, 3);
}

/* Attachments count by their images alone; program, work and state are left out. */
static void test_attachments(void **state) {
    world *w = *state;
    strata_pass pass = native(w);
    pass.bind_count = 0;
    pass.color = &w->attachment;
    pass.color_count = 1;
    pass.depth = &w->depth_attachment;
    pass.program = (strata_program){9999};
    pass.groups[0] = 1;
    pass.depth_test = 99;
    pass.params_size = 7;
    pass.indirect = (strata_buffer){9999};
    pass.draws = (strata_draws){9999};
    accepted(w, &w->draw);
    run(w, &pass);
    assert_logged(&w->f, "pass own native 16x16 scissor 0,0 16x16 color color depth depth"
                         " [color color>native] [depth copy-write>native]\n");
    w->attachment.image = w->layered;
    native_refused(w, &pass, GPU_ERROR_ATTACHMENT_SIZE, "layers");
    w->attachment.image = w->small;
    native_refused(w, &pass, GPU_ERROR_ATTACHMENT_SIZE, "depth");
    w->attachment.image = w->depth;
    native_refused(w, &pass, GPU_ERROR_IMAGE_FORMAT, "colour attachment 0");
}

static strata_pool make_pool(world *w) {
    const strata_pool_desc desc = {.struct_size = sizeof desc,
                                   .label = "pool",
                                   .plane_count = 2,
                                   .counter_name = "Counter",
                                   .plane_names = {"Keys", "Data"},
                                   .plane_strides = {8, 4},
                                   .expected = 1024};
    strata_pool pool;
    assert_int_equal(gpu_pool_create(w->f.scope, &desc, &pool, &w->f.err), STRATA_OK);
    return pool;
}

/* A pool comes with planes and counter, and `needed` is cleared as for any other pass. */
static void test_pool(void **state) {
    world *w = *state;
    const strata_bind bind = {.struct_size = sizeof bind, .pool = make_pool(w)};
    strata_pass pass = native(w);
    pass.binds = &bind;
    gpu_begin(w->f.g, 16, 16);
    run(w, &pass);
    assert_logged(&w->f, "fill pool.Counter 0+4 = 0");
    assert_logged(&w->f, "[pool.Keys copy-write>native] [pool.Data copy-write>native]"
                         " [pool.Counter copy-write>native]");
    strata_bind many[10];
    for (uint32_t i = 0; i < 10; i++) {
        many[i] = bind;
        many[i].pool = make_pool(w);
    }
    pass.binds = many;
    pass.bind_count = 10;
    run(w, &pass);
    strata_bind more[64];
    for (uint32_t i = 0; i < 64; i++)
        more[i] = bind_buffer("buffer", make_buffer(&w->f, "more", 4));
    more[0] = bind;
    pass.binds = more;
    pass.bind_count = 64;
    native_refused(w, &pass, GPU_ERROR_VALUE, "more than 64");
}

static void test_refused(void **state) {
    world *w = *state;
    strata_pass pass = native(w);
    pass.label = NULL;
    native_refused(w, &pass, GPU_ERROR_LABEL_MISSING, "strata_pass");
    pass = native(w);
    pass.struct_size = 8;
    native_refused(w, &pass, GPU_ERROR_STRUCT_SIZE, "strata_pass");
    pass = native(w);
    pass.bind_count = 1000;
    native_refused(w, &pass, GPU_ERROR_VALUE, "1000 binds");
    pass.bind_count = 1;
    w->binds[0].name = NULL;
    native_refused(w, &pass, GPU_ERROR_VALUE, "bind 0");
    w->binds[0] = bind_buffer("Values", (strata_buffer){9999});
    native_refused(w, &pass, GPU_ERROR_HANDLE_UNKNOWN, "'Values'");
    w->binds[0] = bind_buffer("Values", (strata_buffer){0});
    native_refused(w, &pass, GPU_ERROR_BIND_KIND, "'Values'");
    w->binds[0] = bind_buffer("Values", w->values);
    w->binds[0].offset = 4096;
    w->binds[0].size = 4;
    native_refused(w, &pass, GPU_ERROR_BUFFER_RANGE, "values");
    w->binds[0] = bind_buffer("Values", w->values);
    gpu_pass_native(w->f.g, "tester", &pass, NULL, NULL);
    assert_int_equal(gpu_last_code(w->f.g), GPU_ERROR_VALUE);
    assert_non_null(strstr(gpu_frame_error(w->f.g)->text, "no callback"));
}

static void test_before_begin(void **state) {
    (void)state;
    fixture fresh;
    open_device(&fresh, &(gpu_open_info){.backend = "null"});
    const strata_pass pass = {.struct_size = sizeof pass, .label = "own"};
    calls = 0;
    gpu_pass_native(fresh.g, "tester", &pass, count_call, &one);
    assert_int_equal(gpu_last_code(fresh.g), GPU_ERROR_STATE);
    assert_int_equal(calls, 0);
    gpu_close(fresh.g);
}

static void test_no_handles(void **state) {
    world *w = *state;
    const strata_pool pool = make_pool(w);
    assert_int_equal(gpu_native_buffer(w->f.g, w->values), 0);
    assert_int_equal(gpu_native_image(w->f.g, w->color, GPU_NATIVE_IMAGE), 0);
    assert_int_equal(gpu_native_pool(w->f.g, pool, 2), 0);
    assert_int_equal(gpu_native_object(w->f.g, GPU_NATIVE_DEVICE), 0);
    assert_null(gpu_native_proc(w->f.g, "glFinish"));
    assert_null(gpu_native_proc(w->f.g, NULL));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_WORLD(test_order),   IN_WORLD(test_attachments),          IN_WORLD(test_pool),
        IN_WORLD(test_refused), cmocka_unit_test(test_before_begin), IN_WORLD(test_no_handles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
