/* SPDX-License-Identifier: MIT
 *
 * Damages GLB files and loads them, in this process: no crash, no hang, and what loads can be moved
 * in time. fuzz_glb [COUNT [SEED [FILE.glb...]]] with its own seeds and further files; the same
 * SEED gives the same damage everywhere. With FUZZ_BACKEND=null|gl|vulkan what loads is rendered
 * too. Built with STRATA_LIBFUZZER it is a libFuzzer target
 * instead.
 */
#define _POSIX_C_SOURCE 200809L
#include "render/render.h"
#include "scenes/glb.h"

#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What is loaded must also be safe to use: every count and index that a renderer relies on. */
static void inspect(const scene *s) {
    uint64_t primitives = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_instance *instance = &s->instances[i];
        if (instance->mesh >= s->mesh_count || instance->primitive_base != primitives)
            abort();
        const scene_mesh *mesh = &s->meshes[instance->mesh];
        primitives += mesh->topology == SCENE_POINTS ? mesh->index_count : mesh->index_count / 3;
        for (int k = 0; k < 16; k++)
            if (!isfinite(instance->world[k]))
                abort();
    }
    if (primitives != s->primitive_count)
        abort();
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        const scene_mesh *mesh = &s->meshes[i];
        if (mesh->material >= s->material_count)
            abort();
        for (uint32_t k = 0; k < mesh->index_count; k++)
            if (mesh->indices[k] >= mesh->vertex_count)
                abort();
        for (size_t k = 0; k < (size_t)mesh->vertex_count * 3; k++)
            if (!isfinite(mesh->positions[k]) || (mesh->normals && !isfinite(mesh->normals[k])))
                abort();
    }
}

static strata *renderer; /* NULL: nothing is rendered */

/* A small picture, or a line that says why not; ends the scene. */
static void render_once(scene *s) {
    const strata_render_options options = {
        .struct_size = sizeof options, .width = 24, .height = 16};
    strata_scene *owned = calloc(1, sizeof *owned);
    if (!owned)
        abort();
    *owned = (strata_scene){.owner = renderer, .scene = s};
    strata_result r = strata_render(renderer, owned, &options);
    if (r != STRATA_OK && (r > 0 || !strata_error(renderer)[0]))
        abort();
    strata_scene_close(owned);
}

/* 1: loaded, 0: refused with a line of text. */
static int load_once(const unsigned char *data, size_t size) {
    static const double times[] = {0.0, 0.35, 1e9};
    base_error err = {0};
    scene *s = NULL;
    if (scene_load_memory("mutated.glb", data, size, &s, &err) != STRATA_OK) {
        if (s || err.result == STRATA_OK || strncmp(err.text, "mutated.glb: ", 13) != 0)
            abort();
        return 0;
    }
    inspect(s);
    for (size_t i = 0; i < BASE_COUNT(times); i++) {
        err = (base_error){0};
        scene_set_time(s, times[i], &err);
        inspect(s);
    }
    if (renderer)
        render_once(s);
    else
        scene_free(s);
    return 1;
}

#ifdef STRATA_LIBFUZZER

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    load_once(data, size);
    return 0;
}

#else

typedef struct seed {
    unsigned char *data;
    size_t size;
} seed;

static uint64_t state;

static uint32_t dice(size_t sides) /* splitmix64; 0 .. sides - 1 */
{
    uint64_t z = (state += UINT64_C(0x9e3779b97f4a7c15));
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    z ^= z >> 31;
    return sides ? (uint32_t)(z % sides) : 0;
}

/* ---- seeds ----------------------------------------------------------------------------------- */

static const float corners[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const float unit_z[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
static const uint16_t quad[8] = {0, 1, 2, 0, 2, 3, 0, 0};

/* Textures, samplers, transforms, material extensions, vertex colours, a light and a camera. */
static seed seed_materials(void) {
    static const float uv[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const unsigned char colors[16] = {255, 0, 0,   255, 0, 255, 0, 128,
                                             0,   0, 255, 64,  9, 9,   9, 9};
    static const unsigned char tint[4] = {10, 20, 30, 200};
    test_glb g = {0};
    base_text png = {0};
    seed out;
    test_glb_floats(&g, "VEC3", 3, 4, corners);
    test_glb_floats(&g, "VEC3", 3, 4, unit_z);
    test_glb_floats(&g, "VEC2", 2, 4, uv);
    test_glb_accessor(&g, test_glb_view(&g, quad, 12, 0), TEST_GLB_U16, "SCALAR", 6, "");
    test_glb_accessor(&g, test_glb_view(&g, colors, 16, 4), TEST_GLB_U8, "VEC4", 4,
                      ",\"normalized\":true");
    test_glb_png(&png, 8, 8, tint);
    uint32_t picture = test_glb_view(&g, png.data, png.length, 0);
    base_text_free(&png);
    test_glb_json(
        &g,
        "\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":["
        "{\"mesh\":0,\"translation\":[1,2,3],\"rotation\":[0,0.6,0,0.8],\"children\":[2]},"
        "{\"camera\":0,\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,5,1]},"
        "{\"mesh\":0,\"scale\":[2,2,2],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]");
    test_glb_json(&g,
                  "\"meshes\":[{\"name\":\"quad\",\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                  "\"NORMAL\":1,\"TEXCOORD_0\":2,\"COLOR_0\":4},\"indices\":3,\"material\":0}]}]");
    test_glb_json(&g,
                  "\"materials\":[{\"name\":\"glass\",\"alphaMode\":\"BLEND\",\"doubleSided\":true,"
                  "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.5],\"metallicFactor\":0,"
                  "\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":"
                  "{\"offset\":[0.5,0],\"rotation\":0.3,\"scale\":[2,2]}}}},"
                  "\"emissiveFactor\":[1,0.5,0],\"normalTexture\":{\"index\":0,\"scale\":0.7},"
                  "\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.9,"
                  "\"transmissionTexture\":{\"index\":0}},\"KHR_materials_ior\":{\"ior\":1.3},"
                  "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":4}}}]");
    test_glb_json(&g,
                  "\"textures\":[{\"source\":0,\"sampler\":0}],\"samplers\":[{\"magFilter\":9728,"
                  "\"minFilter\":9987,\"wrapS\":33071,\"wrapT\":33648}],"
                  "\"images\":[{\"bufferView\":%u,\"mimeType\":\"image/png\"}]",
                  picture);
    test_glb_json(
        &g, "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
            "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\","
            "\"intensity\":20,\"color\":[1,0.9,0.8],\"spot\":{\"outerConeAngle\":0.5}}]}},"
            "\"extensionsUsed\":[\"KHR_lights_punctual\",\"KHR_materials_ior\",\"X_unknown\"]");
    out.data = test_glb_finish(&g, &out.size);
    return out;
}

/* A skinned and a morphed strip, animated three ways. */
static seed seed_animation(void) {
    static const unsigned char joints[16] = {0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0};
    static const float weights[16] = {1, 0, 0, 0, 1, 0, 0, 0, .5f, .5f, 0, 0, 0, 1, 0, 0};
    static const float times[3] = {0, 0.5f, 1};
    static const float turns[12] = {0, 0, 0, 1, 0, 0, 0.7071f, 0.7071f, 0, 0, 0, 1};
    static const float moves[27] = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 2, 3};
    static const float amounts[3] = {0, 1, 0.25f};
    static const float identities[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                         1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1};
    test_glb g = {0};
    seed out;
    test_glb_floats(&g, "VEC3", 3, 4, corners);
    test_glb_accessor(&g, test_glb_view(&g, joints, 16, 0), TEST_GLB_U8, "VEC4", 4, "");
    test_glb_floats(&g, "VEC4", 4, 4, weights);
    test_glb_floats(&g, "MAT4", 16, 2, identities);
    test_glb_floats(&g, "SCALAR", 1, 3, times);
    test_glb_floats(&g, "VEC4", 4, 3, turns);
    test_glb_floats(&g, "VEC3", 3, 9, moves);
    test_glb_floats(&g, "SCALAR", 1, 3, amounts);
    test_glb_floats(&g, "VEC3", 3, 4, unit_z);
    test_glb_json(&g,
                  "\"scenes\":[{\"nodes\":[0,1,3]}],\"nodes\":[{\"mesh\":0,\"skin\":0},"
                  "{\"children\":[2]},{\"translation\":[0,1,0]},{\"mesh\":1,\"weights\":[0.5]}]");
    test_glb_json(
        &g, "\"meshes\":[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0,"
            "\"JOINTS_0\":1,\"WEIGHTS_0\":2}}]},{\"primitives\":[{\"mode\":6,\"attributes\":"
            "{\"POSITION\":0,\"NORMAL\":8},\"targets\":[{\"POSITION\":8}]}],\"weights\":[0]}]");
    test_glb_json(&g, "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":3}]");
    test_glb_json(&g,
                  "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":"
                  "\"rotation\"}},{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"translation\"}},"
                  "{\"sampler\":2,\"target\":{\"node\":3,\"path\":\"weights\"}}],\"samplers\":["
                  "{\"input\":4,\"output\":5},{\"input\":4,\"output\":6,\"interpolation\":"
                  "\"CUBICSPLINE\"},{\"input\":4,\"output\":7,\"interpolation\":\"STEP\"}]}]");
    out.data = test_glb_finish(&g, &out.size);
    return out;
}

/* Quantized, interleaved, sparse and absent data, gpu instances, points with radii. */
static seed seed_accessors(void) {
    static const int16_t packed[16] = {0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0, -32768, 0, 0, 0};
    static const float radii[4] = {0.1f, 0.2f, 0.3f, 0.4f};
    static const uint32_t order[6] = {0, 1, 2, 2, 1, 3};
    static const unsigned char changed[4] = {1, 3, 0, 0};
    static const float values[6] = {5, 6, 7, 8, 9, 10};
    test_glb g = {0};
    char sparse[160];
    seed out;
    test_glb_accessor(&g, test_glb_view(&g, packed, 32, 8), TEST_GLB_I16, "VEC3", 4,
                      ",\"normalized\":true");
    test_glb_accessor(&g, test_glb_view(&g, order, 24, 0), TEST_GLB_U32, "SCALAR", 6, "");
    test_glb_floats(&g, "SCALAR", 1, 4, radii);
    uint32_t at = test_glb_view(&g, changed, 2, 0), with = test_glb_view(&g, values, 24, 0);
    snprintf(sparse, sizeof sparse,
             ",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":%u,\"componentType\":5121},"
             "\"values\":{\"bufferView\":%u}}",
             at, with);
    test_glb_accessor(&g, UINT32_MAX, TEST_GLB_F32, "VEC3", 4, sparse);
    test_glb_floats(&g, "VEC3", 3, 4, corners);
    test_glb_json(&g,
                  "\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0,\"extensions\":"
                  "{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":4,\"SCALE\":3}}}},"
                  "{\"mesh\":1}],\"extensionsRequired\":[\"KHR_mesh_quantization\"]");
    test_glb_json(&g,
                  "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]},"
                  "{\"primitives\":[{\"mode\":0,\"attributes\":{\"POSITION\":3,\"_RADIUS\":2}}]}]");
    out.data = test_glb_finish(&g, &out.size);
    return out;
}

/* ---- damage ---------------------------------------------------------------------------------- */

typedef struct work { /* one mutated file */
    unsigned char *data;
    size_t size;
} work;

static size_t json_size(const work *w) {
    size_t length = 0;
    if (w->size < 20)
        return 0;
    for (int i = 3; i >= 0; i--)
        length = length << 8 | w->data[12 + i];
    return length <= w->size - 20 ? length : w->size - 20;
}

static void put_word(unsigned char *at, size_t value) {
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> 8 * i & 0xffu);
}

/* Replaces bytes [from, from + old) by text; lengths in headers follow when `honest`. */
static void replace(work *w, size_t from, size_t old, const char *text, size_t length, int honest) {
    unsigned char *data = calloc(w->size - old + length + 1, 1);
    if (!data)
        abort();
    memcpy(data, w->data, from);
    memcpy(data + from, text, length);
    memcpy(data + from + length, w->data + from + old, w->size - from - old);
    size_t json = json_size(w) - old + length;
    free(w->data);
    w->data = data;
    w->size = w->size - old + length;
    if (honest && w->size >= 20) {
        put_word(w->data + 8, w->size);
        put_word(w->data + 12, json);
    }
}

static void flip_bytes(work *w) {
    for (uint32_t n = 1 + dice(8); n > 0 && w->size > 0; n--)
        w->data[dice(w->size)] ^= (unsigned char)(1u << dice(8));
}

static void set_bytes(work *w) {
    static const unsigned char telling[] = {0, 1, 0x7f, 0x80, 0xff, '"', '{', '[', '-', '\\'};
    for (uint32_t n = 1 + dice(8); n > 0 && w->size > 0; n--)
        w->data[dice(w->size)] = telling[dice(sizeof telling)];
}

/* Words of the binary chunk become others: as floats NaN, infinite, huge, tiny; as integers large.
 */
static void edit_binary(work *w) {
    static const size_t words[] = {0,          0x7fc00000, 0x7f800000, 0xff800000, 0x7f7fffff,
                                   0x00000001, 0xffffffff, 0x80000000, 0x00010000, 0x3f800000};
    size_t start = 28 + json_size(w);
    for (uint32_t n = 1 + dice(4); n > 0 && w->size >= start + 4; n--) {
        size_t at = start + dice(w->size - start - 3);
        if (dice(2))
            put_word(w->data + at, words[dice(BASE_COUNT(words))]);
        else
            w->data[at] ^= (unsigned char)(1u << dice(8));
    }
}

static void edit_lengths(work *w) {
    static const size_t lengths[] = {0, 1, 7, 20, 0x7fffffff, 0x80000000, 0xfffffffc, 0xffffffff};
    size_t at = dice(2) ? 8 : 12;
    if (dice(3) == 0)
        at = 20 + json_size(w);
    if (at + 4 <= w->size)
        put_word(w->data + at, dice(2) ? lengths[dice(BASE_COUNT(lengths))] : dice(w->size + 64));
}

static void truncate_file(work *w) {
    w->size = dice(w->size + 1);
}

static int starts_number(const unsigned char *at) {
    return ((*at >= '0' && *at <= '9') || *at == '-') &&
           (at[-1] == ':' || at[-1] == ',' || at[-1] == '[');
}

/* The n-th place in the JSON where `test` holds, n by chance; 0: none. */
static size_t find_place(const work *w, int (*test)(const unsigned char *)) {
    size_t count = 0, json = json_size(w);
    for (size_t i = 21; i < 20 + json; i++)
        count += (size_t)test(w->data + i);
    size_t chosen = dice(count);
    for (size_t i = 21; i < 20 + json && count; i++)
        if (test(w->data + i) && chosen-- == 0)
            return i;
    return 0;
}

static void edit_number(work *w) {
    static const char *const numbers[] = {
        "0",        "-1",    "1",          "2",          "3",
        "255",      "65536", "4294967295", "4294967296", "-2147483649",
        "1e38",     "1e39",  "1e400",      "-1e-400",    "NaN",
        "Infinity", "0.5",   "null",       "\"0\"",      "9007199254740993",
        "[]",       "{}",    "true",       "16777217",   "18446744073709551616"};
    size_t at = find_place(w, starts_number), length = 0;
    if (!at)
        return;
    while (at + length < w->size && strchr("-+.eE0123456789", w->data[at + length]) &&
           w->data[at + length])
        length++;
    char small[16];
    const char *text = numbers[dice(BASE_COUNT(numbers))];
    if (dice(3) > 0) {
        snprintf(small, sizeof small, "%u", dice(dice(2) ? 5 : 200));
        text = small;
    }
    replace(w, at, length, text, strlen(text), 1);
}

static int is_structure(const unsigned char *at) {
    return *at && strchr("{}[],:\"", *at) != NULL;
}

static void edit_token(work *w) {
    static const char *const tokens[] = {
        "{",        "}",       "[",       "]",    ",",    ":",          "\"",        "",
        "[[[[[[[[", "{\"a\":", "\\u0000", "\xff", "null", "\"nodes\":", "[0,0,0,0]", "{}"};
    size_t at = find_place(w, is_structure);
    if (!at)
        return;
    const char *text = tokens[dice(BASE_COUNT(tokens))];
    replace(w, at, dice(2), text, strlen(text), 1);
}

static int starts_text(const unsigned char *at) {
    return *at == '"' && at[1] >= 'A' && at[1] <= 'z';
}

/* One quoted word takes the place of another: keys among keys, choices among choices. */
static void swap_words(work *w) {
    size_t from = find_place(w, starts_text), to = find_place(w, starts_text), length = 1, old = 1;
    char word[64];
    if (!from || !to)
        return;
    while (from + length < w->size && w->data[from + length] != '"' && length < 60)
        length++;
    while (to + old < w->size && w->data[to + old] != '"' && old < 60)
        old++;
    memcpy(word, w->data + from, length);
    replace(w, to, old, word, length, 1);
}

/* A piece of another seed over or into this one. */
static void splice(work *w, const seed *other) {
    size_t length = 1 + dice(other->size < 400 ? other->size : 400);
    size_t from = dice(other->size - length + 1), to = dice(w->size + 1);
    size_t old = dice(2) ? 0 : length < w->size - to ? length : w->size - to;
    replace(w, to, old, (const char *)other->data + from, length, dice(2) == 0);
}

static void damage(work *w, const seed *seeds, uint32_t seed_count) {
    static void (*const kinds[])(work *) = {
        flip_bytes,  set_bytes,   edit_lengths, truncate_file, edit_number,
        edit_number, edit_number, edit_number,  edit_binary,   edit_binary,
        edit_binary, edit_token,  swap_words,   swap_words,
    };
    uint32_t kind = dice(BASE_COUNT(kinds) + 1);
    if (kind < BASE_COUNT(kinds))
        kinds[kind](w);
    else
        splice(w, &seeds[dice(seed_count)]);
}

/* ---- the run --------------------------------------------------------------------------------- */

static const char *saved = "fuzz_glb.crash"; /* the file being loaded, written when that kills us */
static work current;

static void say(const char *text) {
    (void)!write(STDERR_FILENO, text, strlen(text));
}

/* Nothing but what a signal handler may call. */
static void keep_file(void) {
    int fd = open(saved, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd >= 0 && write(fd, current.data, current.size) == (ssize_t)current.size)
        say("fuzz_glb: the file is fuzz_glb.crash\n");
}

static void keep_and_die(int number) {
    say(number == SIGALRM ? "fuzz_glb: hang\n" : "fuzz_glb: crash\n");
    keep_file();
    _exit(1);
}

/* The sanitizers end the process themselves; present only when one is linked. */
extern void __sanitizer_set_death_callback(void (*callback)(void)) __attribute__((weak));

static seed read_seed(const char *path) {
    base_error err = {0};
    seed out = {0};
    if (base_file_read(path, (size_t)64 << 20, &out.data, &out.size, &err) != STRATA_OK) {
        fprintf(stderr, "fuzz_glb: %s\n", err.text);
        exit(2);
    }
    return out;
}

int main(int argc, char **argv) {
    unsigned long count = argc > 1 ? strtoul(argv[1], NULL, 10) : 10000, loaded = 0;
    uint64_t start = argc > 2 ? strtoull(argv[2], NULL, 10) : 1;
    uint32_t seed_count = 3 + (uint32_t)(argc > 3 ? argc - 3 : 0);
    seed *seeds = calloc(seed_count, sizeof *seeds);
    if (!seeds)
        return 2;
    seeds[0] = seed_materials();
    seeds[1] = seed_animation();
    seeds[2] = seed_accessors();
    for (uint32_t i = 3; i < seed_count; i++)
        seeds[i] = read_seed(argv[i]);
    const strata_open_options options = {.struct_size = sizeof options,
                                         .backend = getenv("FUZZ_BACKEND")};
    if (options.backend && strata_open(&options, &renderer) != STRATA_OK)
        return 2;
    signal(SIGALRM, keep_and_die);
    signal(SIGABRT, keep_and_die);
    if (__sanitizer_set_death_callback)
        __sanitizer_set_death_callback(keep_file);
    else
        signal(SIGSEGV, keep_and_die);
    for (uint32_t i = 0; i < seed_count; i++)
        if (!load_once(seeds[i].data, seeds[i].size)) {
            fprintf(stderr, "fuzz_glb: seed %u does not load undamaged\n", i);
            return 1;
        }
    for (unsigned long i = 0; i < count; i++) {
        state = start * UINT64_C(0x100000001) + i; /* each file can be made again alone */
        const seed *from = &seeds[dice(seed_count)];
        current = (work){.data = calloc(from->size + 1, 1), .size = from->size};
        if (!current.data)
            abort();
        memcpy(current.data, from->data, from->size);
        for (uint32_t n = 1 + dice(2); n > 0; n--)
            damage(&current, seeds, seed_count);
        alarm(20);
        loaded += (unsigned long)load_once(current.data, current.size);
        alarm(0);
        free(current.data);
    }
    for (uint32_t i = 0; i < seed_count; i++)
        free(seeds[i].data);
    free(seeds);
    strata_close(renderer);
    printf("%lu mutated files: %lu loaded, %lu refused, 0 crashed\n", count, loaded,
           count - loaded);
    return 0;
}

#endif
