/* SPDX-License-Identifier: MIT
 *
 * Buffers, images, pools and compute on every backend.
 */
#include "gpu/backend_tests.h"

#include <math.h>
#include <stdlib.h>

/* ---- buffers and compute ----------------------------------------------------------------- */

static void test_double(void **state) {
    rig *r = backend_rig(state);
    uint32_t data[300];
    for (uint32_t i = 0; i < 300; i++)
        data[i] = i * 7;
    strata_buffer buffer = rig_buffer(r, "values", sizeof data, data);
    strata_program program =
        rig_program(r, STRATA_PROGRAM_COMPUTE,
                    "layout(local_size_x = 64) in;\n"
                    "layout(std430) buffer Values { uint values[]; };\n"
                    "STRATA_PARAMS { uint count; uint add; } params;\n"
                    "void main() {\n"
                    "    uint i = gl_GlobalInvocationID.x;\n"
                    "    if (i < params.count) values[i] = 2u * values[i] + params.add;\n"
                    "}\n");
    const strata_bind bind = rig_bind_buffer("Values", buffer);
    gpu_begin(r->g, 1, 1);
    for (uint32_t pass = 0; pass < 3; pass++) {
        const uint32_t params[2] = {250, pass}; /* differs from pass to pass */
        rig_pass(r, (strata_pass){.program = program,
                                  .groups = {5},
                                  .binds = &bind,
                                  .bind_count = 1,
                                  .params = params,
                                  .params_size = sizeof params});
    }
    rig_submit(r);
    rig_read(r, buffer, data, sizeof data);
    for (uint32_t i = 0; i < 300; i++)
        assert_int_equal(data[i], i < 250 ? ((2 * i * 7) * 2 + 1) * 2 + 2 : i * 7);
}

/* A buffer as texels: what the pass before wrote is read, as often as it is written. */
static void test_words_as_texels(void **state) {
    rig *r = backend_rig(state);
    enum { COUNT = 1000 };
    uint32_t found[COUNT];
    if (gpu_fact(r->g, "limit.texels") < COUNT)
        return;
    strata_buffer words = rig_buffer(r, "words", sizeof found, NULL);
    strata_buffer sums = rig_buffer(r, "sums", sizeof found, NULL);
    strata_program write =
        rig_program(r, STRATA_PROGRAM_COMPUTE,
                    "layout(local_size_x = 64) in;\n"
                    "layout(std430) writeonly buffer Words { uint words[]; };\n"
                    "STRATA_PARAMS { uint count; uint add; } params;\n"
                    "void main() {\n"
                    "    uint i = gl_GlobalInvocationID.x;\n"
                    "    if (i < params.count) words[i] = 0xfffffff0u + 3u * i + params.add;\n"
                    "}\n");
    strata_program add = rig_program(
        r, STRATA_PROGRAM_COMPUTE,
        "layout(local_size_x = 64) in;\n"
        "uniform usamplerBuffer Words;\n"
        "layout(std430) buffer Sums { uint sums[]; };\n"
        "void main() {\n"
        "    uint i = gl_GlobalInvocationID.x;\n"
        "    if (i < uint(textureSize(Words))) sums[i] += texelFetch(Words, int(i)).x;\n"
        "}\n");
    const strata_bind binds[] = {rig_bind_buffer("Words", words), rig_bind_buffer("Sums", sums)};
    gpu_begin(r->g, 1, 1);
    for (uint32_t round = 0; round < 3; round++) {
        const uint32_t params[2] = {COUNT, round};
        rig_pass(r, (strata_pass){.program = write,
                                  .groups = {16},
                                  .binds = binds,
                                  .bind_count = 1,
                                  .params = params,
                                  .params_size = sizeof params});
        rig_pass(r, (strata_pass){.program = add, .groups = {16}, .binds = binds, .bind_count = 2});
    }
    rig_submit(r);
    rig_read(r, sums, found, sizeof found);
    for (uint32_t i = 0; i < COUNT; i++)
        assert_int_equal(found[i], 3 * (0xfffffff0u + 3 * i) + 3);
}

static void test_params_of_128_bytes(void **state) {
    rig *r = backend_rig(state);
    uint32_t params[32], found[32];
    for (uint32_t i = 0; i < 32; i++)
        params[i] = 0x01010101u * i + 3;
    strata_buffer buffer = rig_buffer(r, "out", sizeof found, NULL);
    strata_program program = rig_program(r, STRATA_PROGRAM_COMPUTE,
                                         "layout(local_size_x = 1) in;\n"
                                         "layout(std430) writeonly buffer Out { uvec4 o[]; };\n"
                                         "STRATA_PARAMS { uvec4 v[8]; } params;\n"
                                         "void main() {\n"
                                         "    for (int i = 0; i < 8; ++i) o[i] = params.v[i];\n"
                                         "}\n");
    const strata_bind bind = rig_bind_buffer("Out", buffer);
    gpu_begin(r->g, 1, 1);
    rig_pass(r, (strata_pass){.program = program,
                              .groups = {1},
                              .binds = &bind,
                              .bind_count = 1,
                              .params = params,
                              .params_size = sizeof params});
    rig_submit(r);
    rig_read(r, buffer, found, sizeof found);
    assert_memory_equal(found, params, sizeof params);
}

static void test_zeroed_and_written(void **state) {
    rig *r = backend_rig(state);
    const uint64_t size = 20u << 20; /* more than one piece of any staging */
    unsigned char *data = malloc(size), *found = malloc(size);
    base_error err = {0};
    assert_true(data && found);
    strata_buffer buffer = rig_buffer(r, "large", size, NULL);
    rig_read(r, buffer, found, size);
    for (uint64_t i = 0; i < size; i++)
        if (found[i])
            fail_msg("byte %llu of a new buffer is %u", (unsigned long long)i, found[i]);
    for (uint64_t i = 0; i < size; i++)
        data[i] = (unsigned char)(i * 31 + (i >> 11));
    assert_int_equal(gpu_buffer_write(r->g, buffer, 0, size, data, &err), STRATA_OK);
    const unsigned char patch[4] = {1, 2, 3, 4};
    assert_int_equal(gpu_buffer_write(r->g, buffer, 8, 4, patch, &err), STRATA_OK);
    memcpy(data + 8, patch, sizeof patch);
    rig_read(r, buffer, found, size);
    assert_memory_equal(found, data, size);
    strata_buffer copy = rig_buffer(r, "initial", size, data);
    rig_read(r, copy, found, size);
    assert_memory_equal(found, data, size);
    free(data);
    free(found);
}

static void test_many_small_buffers(void **state) {
    rig *r = backend_rig(state);
    strata_buffer buffers[6000]; /* more than maxMemoryAllocationCount's least value */
    for (uint32_t i = 0; i < 6000; i++) {
        const uint32_t data[2] = {i, ~i};
        buffers[i] = rig_buffer(r, "small", sizeof data, data);
    }
    for (uint32_t i = 0; i < 6000; i += 7) {
        uint32_t found[2];
        rig_read(r, buffers[i], found, sizeof found);
        assert_int_equal(found[0], i);
        assert_int_equal(found[1], ~i);
    }
}

static void test_fill_and_copy(void **state) {
    rig *r = backend_rig(state);
    uint32_t data[64], found[64];
    for (uint32_t i = 0; i < 64; i++)
        data[i] = i;
    strata_buffer a = rig_buffer(r, "a", sizeof data, data);
    strata_buffer b = rig_buffer(r, "b", sizeof data, NULL);
    gpu_begin(r->g, 1, 1);
    gpu_fill(r->g, "test", a, 16, 32, 0xdeadbeefu);
    gpu_copy(r->g, "test", b, 8, a, 12, 48);
    gpu_fill(r->g, "test", a, 0, 4, 99);
    rig_submit(r);
    rig_read(r, b, found, sizeof found);
    for (uint32_t i = 0; i < 64; i++) {
        const uint32_t from = i + 1; /* 12 bytes to 8 bytes */
        const uint32_t filled = from >= 4 && from < 12 ? 0xdeadbeefu : from;
        assert_int_equal(found[i], i >= 2 && i < 14 ? filled : 0);
    }
    rig_read(r, a, found, sizeof found);
    assert_int_equal(found[0], 99);
    assert_int_equal(found[1], 1);
}

static void test_indirect_dispatch(void **state) {
    rig *r = backend_rig(state);
    uint32_t count = 0;
    strata_buffer groups = rig_buffer(r, "groups", 64, NULL);
    strata_buffer counter = rig_buffer(r, "counter", 4, NULL);
    strata_program writer = rig_program(r, STRATA_PROGRAM_COMPUTE,
                                        "layout(local_size_x = 1) in;\n"
                                        "layout(std430) writeonly buffer Groups { uint g[]; };\n"
                                        "void main() { g[3] = 5u; g[4] = 2u; g[5] = 3u; }\n");
    strata_program adder = rig_program(r, STRATA_PROGRAM_COMPUTE,
                                       "layout(local_size_x = 8) in;\n"
                                       "layout(std430) buffer Counter { uint count; };\n"
                                       "void main() { atomicAdd(count, 1u); }\n");
    const strata_bind bind_groups = rig_bind_buffer("Groups", groups);
    const strata_bind bind_counter = rig_bind_buffer("Counter", counter);
    gpu_begin(r->g, 1, 1);
    rig_pass(
        r, (strata_pass){.program = writer, .groups = {1}, .binds = &bind_groups, .bind_count = 1});
    rig_pass(r, (strata_pass){.program = adder,
                              .indirect = groups,
                              .indirect_offset = 12,
                              .binds = &bind_counter,
                              .bind_count = 1});
    rig_submit(r);
    rig_read(r, counter, &count, sizeof count);
    assert_int_equal(count, 5 * 2 * 3 * 8);
}

/* Recording goes on after a submit within one frame. */
static void step_twice(rig *r) {
    uint32_t value = 1;
    strata_buffer buffer = rig_buffer(r, "value", 4, &value);
    strata_program program = rig_program(r, STRATA_PROGRAM_COMPUTE,
                                         "layout(local_size_x = 1) in;\n"
                                         "layout(std430) buffer Value { uint value; };\n"
                                         "void main() { value = value * 10u + 3u; }\n");
    const strata_bind bind = rig_bind_buffer("Value", buffer);
    const strata_pass pass = {
        .label = "step", .program = program, .groups = {1}, .binds = &bind, .bind_count = 1};
    gpu_begin(r->g, 1, 1);
    rig_pass(r, pass);
    rig_submit(r);
    rig_read(r, buffer, &value, sizeof value);
    assert_int_equal(value, 13);
    rig_pass(r, pass);
    rig_pass(r, pass);
    rig_submit(r);
    rig_read(r, buffer, &value, sizeof value);
    assert_int_equal(value, 1333);
}

static void test_submit_twice(void **state) {
    rig *r = backend_rig(state);
    uint32_t count;
    step_twice(r);
    const gpu_timing *timings = gpu_timings(r->g, &count);
    assert_int_equal(count, 3);
    for (uint32_t i = 0; i < count; i++)
        assert_true(timings[i].gpu_ms < 0.0);
}

static void test_timings(void **state) {
    rig *r = backend_rig(state);
    const gpu_open_info info = {.backend = r->backend, .check = 1, .profile = 1};
    rig timed = {.backend = r->backend};
    base_error err = {0};
    uint32_t count;
    assert_int_equal(gpu_open(&info, &timed.g, &err), STRATA_OK);
    timed.scope = gpu_scope_create(timed.g, "test");
    step_twice(&timed);
    const gpu_timing *timings = gpu_timings(timed.g, &count);
    assert_int_equal(count, 3);
    for (uint32_t i = 0; i < count; i++) {
        assert_string_equal(timings[i].label, "step");
        assert_true(timings[i].gpu_ms >= 0.0 && timings[i].gpu_ms < 60000.0);
    }
    gpu_close(timed.g);
}

/* A part of a buffer that starts at an offset. */
static void test_bound_range(void **state) {
    rig *r = backend_rig(state);
    uint32_t data[256];
    for (uint32_t i = 0; i < 256; i++)
        data[i] = i;
    strata_buffer from = rig_buffer(r, "from", sizeof data, data);
    strata_buffer to = rig_buffer(r, "to", sizeof data, NULL);
    strata_program program = rig_program(r, STRATA_PROGRAM_COMPUTE,
                                         "layout(local_size_x = 64) in;\n"
                                         "layout(std140) uniform First { uvec4 first; };\n"
                                         "layout(std430) readonly buffer From { uint from[]; };\n"
                                         "layout(std430) writeonly buffer To { uint to[]; };\n"
                                         "void main() {\n"
                                         "    uint i = gl_GlobalInvocationID.x;\n"
                                         "    if (i == 0u) to[0] = from.length() + first.y;\n"
                                         "    else to[i] = from[i];\n"
                                         "}\n");
    strata_bind binds[] = {rig_bind_buffer("First", from), rig_bind_buffer("From", from),
                           rig_bind_buffer("To", to)};
    binds[0].offset = 512;
    binds[0].size = 16;
    binds[1].offset = 256;
    binds[1].size = 400;
    binds[2].offset = 768;
    gpu_begin(r->g, 1, 1);
    rig_pass(r, (strata_pass){.program = program, .groups = {1}, .binds = binds, .bind_count = 3});
    rig_submit(r);
    rig_read(r, to, data, sizeof data);
    assert_int_equal(data[192], 100 + 129);
    assert_int_equal(data[193], 65);
    assert_int_equal(data[255], 64 + 63);
    assert_int_equal(data[191], 0);
}

/* Enough sets for several descriptor pools, again and again. */
static void test_many_passes(void **state) {
    rig *r = backend_rig(state);
    uint32_t value = 0;
    strata_buffer buffer = rig_buffer(r, "value", 4, &value);
    strata_program program = rig_program(r, STRATA_PROGRAM_COMPUTE,
                                         "layout(local_size_x = 1) in;\n"
                                         "layout(std430) buffer Value { uint value; };\n"
                                         "void main() { value += 1u; }\n");
    const strata_bind bind = rig_bind_buffer("Value", buffer);
    for (uint32_t frame = 0; frame < 3; frame++) {
        gpu_begin(r->g, 1, 1);
        for (uint32_t i = 0; i < 600; i++)
            rig_pass(r, (strata_pass){
                            .program = program, .groups = {1}, .binds = &bind, .bind_count = 1});
        rig_submit(r);
    }
    rig_read(r, buffer, &value, sizeof value);
    assert_int_equal(value, 1800);
}

/* ---- pools ------------------------------------------------------------------------------- */

static void test_pool_overflow(void **state) {
    rig *r = backend_rig(state);
    const strata_pool_desc desc = {.struct_size = sizeof desc,
                                   .plane_count = 2,
                                   .label = "pool",
                                   .counter_name = "Counter",
                                   .plane_names = {"Keys", "Values"},
                                   .plane_strides = {4, 8},
                                   .expected = 1024};
    strata_pool pool = {0};
    base_error err = {0};
    uint64_t needed = 0;
    assert_int_equal(gpu_pool_create(r->scope, &desc, &pool, &err), STRATA_OK);
    strata_program program =
        rig_program(r, STRATA_PROGRAM_COMPUTE,
                    "layout(local_size_x = 64) in;\n"
                    "layout(std430) buffer Counter { uint needed; uint capacity; };\n"
                    "layout(std430) writeonly buffer Keys { uint keys[]; };\n"
                    "layout(std430) writeonly buffer Values { uvec2 values[]; };\n"
                    "void main() {\n"
                    "    uint slot = atomicAdd(needed, 1u);\n"
                    "    if (slot >= capacity) return;\n"
                    "    keys[slot] = slot + 1u;\n"
                    "    values[slot] = uvec2(slot, slot * 2u);\n"
                    "}\n");
    const strata_bind bind = rig_bind_pool(pool);
    const strata_pass pass = {.program = program, .groups = {100}, .binds = &bind, .bind_count = 1};
    for (int round = 0; round < 2; round++) {
        gpu_begin(r->g, 1, 1);
        rig_pass(r, pass);
        rig_submit(r);
        assert_int_equal(gpu_pool_needed(r->g, pool, &needed, &err), STRATA_OK);
        assert_int_equal(needed, 6400);
        assert_int_equal(gpu_pool_capacity(r->g, pool) < needed, round == 0);
        if (round == 0)
            assert_int_equal(gpu_pool_grow(r->g, pool, needed, &err), STRATA_OK);
    }
    uint32_t keys[6400], values[12800];
    rig_read(r, gpu_pool_plane(r->g, pool, 0), keys, sizeof keys);
    rig_read(r, gpu_pool_plane(r->g, pool, 1), values, sizeof values);
    for (uint32_t i = 0; i < 6400; i++) {
        assert_int_equal(keys[i], i + 1);
        assert_int_equal(values[2 * i + 1], i * 2);
    }
}

/* ---- images ------------------------------------------------------------------------------ */

#define ARRAY_READER                                                                               \
    "layout(local_size_x = 1) in;\n"                                                               \
    "layout(std430) writeonly buffer Out { vec4 o[]; };\n"                                         \
    "uniform sampler2DArray pages;\n"                                                              \
    "void main() {\n"                                                                              \
    "    uvec3 p = gl_GlobalInvocationID;\n"                                                       \
    "    ivec3 size = textureSize(pages, 0);\n"                                                    \
    "    o[(p.z * size.y + p.y) * size.x + p.x] = texelFetch(pages, ivec3(p), 0);\n"               \
    "}\n"

static void fetch_array(rig *r, strata_image image, uint32_t width, uint32_t height,
                        uint32_t layers, float *texels) {
    const uint64_t size = 16ull * width * height * layers;
    strata_buffer out = rig_buffer(r, "out", size, NULL);
    strata_program program = rig_program(r, STRATA_PROGRAM_COMPUTE, ARRAY_READER);
    const strata_bind binds[] = {rig_bind_buffer("Out", out), rig_bind_image("pages", image)};
    gpu_begin(r->g, 1, 1);
    rig_pass(r, (strata_pass){.program = program,
                              .groups = {width, height, layers},
                              .binds = binds,
                              .bind_count = 2});
    rig_submit(r);
    rig_read(r, out, texels, size);
}

static void test_array_upload(void **state) {
    rig *r = backend_rig(state);
    base_error err = {0};
    unsigned char bytes[3][4 * 5][4];
    unsigned char patch[2][4] = {{1, 2, 3, 4}, {5, 6, 7, 8}};
    float found[3][20][4];
    strata_image image = rig_image(r, "pages", STRATA_FORMAT_RGBA8, 5, 4, 3);
    for (uint32_t layer = 0; layer < 3; layer++) {
        for (uint32_t i = 0; i < 80; i++)
            bytes[layer][i / 4][i % 4] = (unsigned char)(layer * 80 + i);
        assert_int_equal(gpu_image_write(r->g, image, layer, 0, 0, 5, 4, bytes[layer], &err),
                         STRATA_OK);
    }
    assert_int_equal(gpu_image_write(r->g, image, 1, 2, 3, 2, 1, patch, &err), STRATA_OK);
    memcpy(bytes[1][3 * 5 + 2], patch, sizeof patch);
    fetch_array(r, image, 5, 4, 3, &found[0][0][0]);
    for (uint32_t layer = 0; layer < 3; layer++)
        for (uint32_t i = 0; i < 20; i++)
            for (uint32_t c = 0; c < 4; c++)
                assert_true(fabsf(found[layer][i][c] * 255.0f - (float)bytes[layer][i][c]) < 1e-3f);
    rig_same(r, "array of unorm8", found, sizeof found);
    unsigned char back[80];
    rig_texels(r, image, 1, back, sizeof back);
    assert_memory_equal(back, bytes[1], sizeof back);
}

static void test_srgb(void **state) {
    rig *r = backend_rig(state);
    base_error err = {0};
    unsigned char bytes[256][4];
    float found[256][4];
    for (uint32_t i = 0; i < 256; i++)
        memset(bytes[i], (int)i, 4);
    strata_image image = rig_image(r, "srgb", STRATA_FORMAT_RGBA8_SRGB, 16, 16, 1);
    assert_int_equal(gpu_image_write(r->g, image, 0, 0, 0, 16, 16, bytes, &err), STRATA_OK);
    fetch_array(r, image, 16, 16, 1, &found[0][0]);
    for (uint32_t i = 0; i < 256; i++) {
        const double c = i / 255.0;
        const double linear = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
        assert_true(fabs((double)found[i][1] - linear) < 2e-3);
        assert_true(fabs((double)found[i][3] - c) < 1e-6);
    }
    rig_same(r, "srgb", found, sizeof found);
}

static const struct {
    uint32_t format;
    const char *text;
} image_writers[] = {
#define WRITER(name, layout, type, vector)                                                         \
    {                                                                                              \
        STRATA_FORMAT_##name, "layout(local_size_x = 1) in;\n"                                     \
                              "layout(" layout ") writeonly uniform " type " target;\n"            \
                              "void main() {\n"                                                    \
                              "    uvec2 p = gl_GlobalInvocationID.xy;\n"                          \
                              "    imageStore(target, ivec2(p), " vector ");\n"                    \
                              "}\n"                                                                \
    }
    WRITER(RGBA32F, "rgba32f", "image2D", "vec4(p, 0.5, -1.0)"),
    WRITER(RGBA16F, "rgba16f", "image2D", "vec4(p, 0.5, -1.0)"),
    WRITER(RGBA8, "rgba8", "image2D", "vec4(vec2(p) / 255.0, 0.0, 1.0)"),
    WRITER(R32F, "r32f", "image2D", "vec4(p.x * 10u + p.y)"),
    WRITER(R32U, "r32ui", "uimage2D", "uvec4(p.x * 10u + p.y)"),
    WRITER(RG32U, "rg32ui", "uimage2D", "uvec4(p, 0, 0)"),
    WRITER(RGBA32U, "rgba32ui", "uimage2D", "uvec4(p, 0xffffffffu, 7)"),
#undef WRITER
};

/* What texel (x, y) of writer `which` is, as bytes. */
static void expected_texel(size_t which, uint32_t x, uint32_t y, void *texel) {
    const float f[4] = {(float)x, (float)y, 0.5f, -1.0f};
    static const uint16_t small[] = {0x0000, 0x3c00, 0x4000, 0x4200, 0x4400}; /* halves 0..4 */
    const uint16_t h[4] = {small[x], small[y], 0x3800, 0xbc00};
    const unsigned char b[4] = {(unsigned char)x, (unsigned char)y, 0, 255};
    const float one = (float)(x * 10 + y);
    const uint32_t u = x * 10 + y, uv[4] = {x, y, 0xffffffffu, 7};
    const void *values[] = {f, h, b, &one, &u, uv, uv};
    memcpy(texel, values[which], gpu_format_bytes(image_writers[which].format));
}

static void test_storage_images(void **state) {
    rig *r = backend_rig(state);
    for (size_t i = 0; i < BASE_COUNT(image_writers); i++) {
        const uint32_t bytes = gpu_format_bytes(image_writers[i].format);
        unsigned char found[20 * 16], texel[16];
        strata_image image = rig_image(r, "target", image_writers[i].format, 5, 4, 0);
        memset(found, 1, sizeof found);
        rig_texels(r, image, 0, found, 20ull * bytes);
        for (size_t k = 0; k < 20ull * bytes; k++)
            assert_int_equal(found[k], 0); /* new images are zero */
        strata_program program = rig_program(r, STRATA_PROGRAM_COMPUTE, image_writers[i].text);
        const strata_bind bind = rig_bind_image("target", image);
        gpu_begin(r->g, 1, 1);
        rig_pass(r, (strata_pass){
                        .program = program, .groups = {5, 4}, .binds = &bind, .bind_count = 1});
        rig_submit(r);
        rig_texels(r, image, 0, found, 20ull * bytes);
        for (uint32_t k = 0; k < 20; k++) {
            expected_texel(i, k % 5, k / 5, texel);
            assert_memory_equal(found + (size_t)k * bytes, texel, bytes);
        }
    }
}

static void test_clear_images(void **state) {
    rig *r = backend_rig(state);
    const float value[4] = {0.25f, 2.0f, 3.0f, 1.0f}, deep[4] = {0.75f, 9.0f, 0, 0};
    strata_image color = rig_image(r, "color", STRATA_FORMAT_RGBA32F, 3, 3, 2);
    strata_image integer = rig_image(r, "integer", STRATA_FORMAT_RGBA32U, 3, 3, 0);
    strata_image depth = rig_image(r, "depth", STRATA_FORMAT_D32F, 3, 3, 0);
    strata_image both = rig_image(r, "both", STRATA_FORMAT_D32F_S8, 3, 3, 0);
    gpu_begin(r->g, 1, 1);
    gpu_clear_image(r->g, "test", color, value);
    gpu_clear_image(r->g, "test", integer, value);
    gpu_clear_image(r->g, "test", depth, deep);
    gpu_clear_image(r->g, "test", both, deep);
    rig_submit(r);
    float colors[9][4], depths[9];
    uint32_t integers[9][4];
    struct {
        float depth;
        uint32_t stencil;
    } boths[9];
    for (uint32_t layer = 0; layer < 2; layer++) {
        rig_texels(r, color, layer, colors, sizeof colors);
        assert_memory_equal(colors[8], value, sizeof value);
    }
    rig_texels(r, integer, 0, integers, sizeof integers);
    assert_int_equal(integers[8][0], 0);
    assert_int_equal(integers[8][1], 2);
    rig_texels(r, depth, 0, depths, sizeof depths);
    assert_true(depths[8] == 0.75f);
    rig_texels(r, both, 0, boths, sizeof boths);
    assert_true(boths[8].depth == 0.75f);
    assert_int_equal(boths[8].stencil, 9);
}

const struct CMUnitTest storage_tests[] = {
    cmocka_unit_test(test_double),
    cmocka_unit_test(test_words_as_texels),
    cmocka_unit_test(test_params_of_128_bytes),
    cmocka_unit_test(test_zeroed_and_written),
    cmocka_unit_test(test_many_small_buffers),
    cmocka_unit_test(test_fill_and_copy),
    cmocka_unit_test(test_indirect_dispatch),
    cmocka_unit_test(test_submit_twice),
    cmocka_unit_test(test_timings),
    cmocka_unit_test(test_bound_range),
    cmocka_unit_test(test_many_passes),
    cmocka_unit_test(test_pool_overflow),
    cmocka_unit_test(test_array_upload),
    cmocka_unit_test(test_srgb),
    cmocka_unit_test(test_storage_images),
    cmocka_unit_test(test_clear_images),
};
const size_t storage_test_count = BASE_COUNT(storage_tests);
