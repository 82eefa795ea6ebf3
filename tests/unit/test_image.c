/* SPDX-License-Identifier: MIT
 *
 * host/image: round trips, the sRGB code against a table computed here, metrics on cases worked out
 * by hand, files that lie, and deep EXR flattened by oiiotool, a renderer-independent judge.
 */
#define _POSIX_C_SOURCE 200809L
#include "image/image.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64];

static const char *place(const char *name) {
    static char paths[4][256];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, 256, "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/strata-image-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static uint32_t random_bits(uint32_t *seed) {
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

static image make(uint32_t width, uint32_t height) {
    image im;
    base_error err = {0};
    assert_int_equal(image_create(width, height, &im, &err), STRATA_OK);
    return im;
}

static float *at(const image *im, uint32_t x, uint32_t y) {
    return im->pixels + ((size_t)y * im->width + x) * 4;
}

/* ---- PNG ------------------------------------------------------------------------------------ */

/* The file's bytes as another reader of libpng sees them: first row on top, straight. */
static unsigned char *read_png_bytes(const char *path, uint32_t width, uint32_t height) {
    png_image png = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&png, path));
    assert_int_equal(png.width, width);
    assert_int_equal(png.height, height);
    png.format = PNG_FORMAT_RGBA;
    unsigned char *bytes = malloc(PNG_IMAGE_SIZE(png));
    assert_true(png_image_finish_read(&png, NULL, bytes, 0, NULL));
    return bytes;
}

/* What the standard's forward curve gives, rounded: an independent path to the same code. */
static int expected_code(double linear) {
    double v = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
    return (int)floor(fmin(fmax(v, 0), 1) * 255 + 0.5);
}

static void png_rounds_srgb_correctly(void **state) {
    (void)state;
    enum { N = 65536 };
    image im = make(256, N / 256);
    for (uint32_t i = 0; i < N; ++i) {
        float *p = im.pixels + (size_t)i * 4;
        p[0] = (float)i / (N - 1);
        p[1] = p[0] * p[0];
        p[2] = p[0] * 0.0062f; /* around the linear part's end */
        p[3] = 1;
    }
    base_error err = {0};
    assert_int_equal(image_write(&im, place("ramp.PNG"), &err), STRATA_OK);
    unsigned char *bytes = read_png_bytes(place("ramp.PNG"), 256, N / 256);
    for (uint32_t y = 0; y < im.height; ++y) {
        for (uint32_t x = 0; x < im.width; ++x) {
            const unsigned char *code = bytes + ((size_t)(im.height - 1 - y) * im.width + x) * 4;
            for (int c = 0; c < 3; ++c)
                assert_int_equal(code[c], expected_code(at(&im, x, y)[c]));
        }
    }
    free(bytes);
    image_free(&im);
}

static void png_handles_alpha_and_odd_values(void **state) {
    (void)state;
    image im = make(6, 1);
    const float values[6][4] = {{0.25f, 0.5f, 0.125f, 0.5f}, /* straight .5, 1, .25 */
                                {0.5f, 0.5f, 0.5f, 0},       /* light without alpha */
                                {NAN, -1, INFINITY, 1},
                                {2, 0.5f, 0, 2}, /* alpha above 1 is 1 */
                                {0, 0, 0, NAN},
                                {0.1f, 0.1f, 0.1f, 1.0f / 255}};
    const unsigned char expected[6][4] = {{188, 255, 137, 128}, {0, 0, 0, 0}, {0, 0, 255, 255},
                                          {255, 188, 0, 255},   {0, 0, 0, 0}, {255, 255, 255, 1}};
    memcpy(im.pixels, values, sizeof values);
    base_error err = {0};
    assert_int_equal(image_write(&im, place("odd.png"), &err), STRATA_OK);
    unsigned char *bytes = read_png_bytes(place("odd.png"), 6, 1);
    assert_memory_equal(bytes, expected, sizeof expected);
    free(bytes);
    image_free(&im);
}

static void png_round_trip_keeps_every_code_and_the_rows(void **state) {
    (void)state;
    image im = make(256, 2), back;
    for (uint32_t x = 0; x < 256; ++x) {
        float *low = at(&im, x, 0), *high = at(&im, x, 1);
        low[0] = low[1] = low[2] = image_srgb_to_linear((unsigned char)x);
        low[3] = 1;
        high[0] = high[3] = (float)(x / 255.0); /* straight red 1 under every alpha */
    }
    base_error err = {0};
    assert_int_equal(image_write(&im, place("codes.png"), &err), STRATA_OK);
    assert_int_equal(image_read(place("codes.png"), &back, &err), STRATA_OK);
    image_difference d;
    assert_int_equal(image_compare(&im, &back, &d, &err), STRATA_OK);
    assert_true(d.max == 0);
    image_free(&back);
    image_free(&im);
}

/* ---- EXR ------------------------------------------------------------------------------------ */

static void exr_round_trip_is_bit_exact(void **state) {
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {1, 37}, {37, 1}, {67, 53}, {300, 16}, {16, 33}};
    uint32_t seed = 7;
    for (size_t s = 0; s < BASE_COUNT(sizes); ++s) {
        image im = make(sizes[s][0], sizes[s][1]), back;
        for (size_t i = 0; i < (size_t)im.width * im.height * 4; ++i)
            im.pixels[i] = (float)random_bits(&seed) * (s % 2 ? 1.0f : 1e-30f);
        at(&im, 0, 0)[3] = INFINITY;
        at(&im, im.width - 1, im.height - 1)[1] = 1e-42f; /* denormal */
        base_error err = {0};
        assert_int_equal(image_write(&im, place("float.exr"), &err), STRATA_OK);
        assert_int_equal(image_read(place("float.exr"), &back, &err), STRATA_OK);
        assert_int_equal(back.width, im.width);
        assert_int_equal(back.height, im.height);
        assert_memory_equal(back.pixels, im.pixels,
                            (size_t)im.width * im.height * 4 * sizeof(float));
        image_free(&back);
        image_free(&im);
    }
}

static void exr_plane_reads_back_as_grey(void **state) {
    (void)state;
    const float values[6] = {0, 1, 2, 3, 4, 0.5f};
    base_error err = {0};
    image back;
    assert_int_equal(image_write_exr_plane(values, 3, 2, "Z", place("z.exr"), &err), STRATA_OK);
    assert_int_equal(image_read(place("z.exr"), &back, &err), STRATA_OK);
    for (uint32_t i = 0; i < 6; ++i) {
        for (int c = 0; c < 3; ++c)
            assert_true(back.pixels[i * 4 + (uint32_t)c] == values[i]);
        assert_true(back.pixels[i * 4 + 3] == 1);
    }
    image_free(&back);
}

/* ---- hostile and impossible ----------------------------------------------------------------- */

static void bad_files_fail_with_one_line_naming_them(void **state) {
    (void)state;
    static const char *const texts[] = {"",        "x",
                                        "\x89PNG", "\x89PNG\r\n\x1a\n garbage follows",
                                        "v/1\x01", "v/1\x01\x02\0\0\0no attributes here",
                                        "GIF89a"};
    for (size_t i = 0; i < BASE_COUNT(texts); ++i) {
        base_error err = {0};
        image im;
        assert_int_not_equal(image_read_memory("bad.img", texts[i], strlen(texts[i]), &im, &err),
                             STRATA_OK);
        assert_ptr_equal(strstr(err.text, "bad.img"), err.text);
        assert_null(strchr(err.text, '\n'));
        assert_null(im.pixels);
    }
    base_error err = {0};
    image im;
    assert_int_equal(image_read(place("none.png"), &im, &err), STRATA_ERROR_NOT_FOUND);
    assert_non_null(strstr(err.text, "none.png"));
}

static void png_bombs_are_refused_before_memory_is_asked_for(void **state) {
    (void)state;
    unsigned char *data;
    size_t size;
    base_error err = {0};
    unsigned char rgba[4] = {1, 2, 3, 4};
    assert_int_equal(image_encode_png("p", rgba, 1, 1, &data, &size, &err), STRATA_OK);
    memcpy(data + 16, "\0\0\x40\0\0\0\x40\0", 8); /* IHDR: 16384 x 16384; fix its CRC */
    uint32_t crc = 0xffffffffu;
    for (int i = 12; i < 29; ++i) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; ++bit)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    crc = ~crc;
    for (int i = 0; i < 4; ++i)
        data[29 + i] = (unsigned char)(crc >> (24 - 8 * i));
    image im;
    assert_int_equal(image_read_memory("bomb.png", data, size, &im, &err), STRATA_ERROR_BAD_FILE);
    assert_non_null(strstr(err.text, "cannot be in"));
    free(data);
}

/* Every truncation and thousands of flipped bytes of good files: any result, no crash. */
static void mangled_files_never_crash(void **state) {
    (void)state;
    image im = make(20, 20);
    uint32_t seed = 99;
    for (size_t i = 0; i < 1600; ++i)
        im.pixels[i] = (float)(random_bits(&seed) & 255) / 255;
    base_error err = {0};
    static const char *const names[] = {"mangle.png", "mangle.exr"};
    for (size_t n = 0; n < 2; ++n) {
        unsigned char *data;
        size_t size;
        assert_int_equal(image_write(&im, place(names[n]), &err), STRATA_OK);
        assert_int_equal(base_file_read(place(names[n]), 1 << 20, &data, &size, &err), STRATA_OK);
        unsigned char *copy = malloc(size);
        for (int round = 0; round < 3000; ++round) {
            memcpy(copy, data, size);
            size_t length = round % 3 ? size : random_bits(&seed) % size;
            for (int flips = round % 4; flips >= 0; --flips) {
                copy[random_bits(&seed) % (round % 2 ? size : 400)] =
                    (unsigned char)random_bits(&seed);
            }
            image back;
            base_error ignored = {0};
            strata_result result = image_read_memory(names[n], copy, length, &back, &ignored);
            assert_true(result == STRATA_OK ? back.pixels != NULL : ignored.text[0] != '\0');
            image_free(&back);
        }
        free(copy);
        free(data);
    }
    image_free(&im);
}

static void failed_writes_leave_the_old_file_and_nothing_else(void **state) {
    (void)state;
    image im = make(2, 2);
    base_error err = {0};
    assert_int_equal(image_write(&im, place("picture.gif"), &err), STRATA_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(err.text, "picture.gif"));
    static const char *const names[] = {"no/such/folder.png", "no/such/folder.exr"};
    for (size_t i = 0; i < 2; ++i) {
        err = (base_error){0};
        assert_int_equal(image_write(&im, place(names[i]), &err), STRATA_ERROR_NOT_FOUND);
        assert_non_null(strstr(err.text, names[i]));
    }
    static const char *const full[] = {"full.png", "full.exr"};
    for (size_t i = 0; i < 2 && access("/dev/full", W_OK) == 0; ++i) {
        err = (base_error){0};
        assert_int_equal(symlink("/dev/full", place(full[i])), 0);
        assert_int_equal(image_write(&im, place(full[i]), &err), STRATA_ERROR_IO);
        assert_non_null(strstr(err.text, full[i]));
    }
    image big = {.width = 70000, .height = 1, .pixels = im.pixels};
    err = (base_error){0};
    assert_int_equal(image_write(&big, place("big.exr"), &err), STRATA_ERROR_OVERFLOW);
    assert_int_equal(access(place("big.exr"), F_OK), -1);
    image_free(&im);
    assert_int_equal(image_create(65535, 65535, &im, NULL), STRATA_ERROR_OVERFLOW);
}

/* ---- metrics -------------------------------------------------------------------------------- */

static void compare_gives_the_figures_worked_out_by_hand(void **state) {
    (void)state;
    image a = make(2, 2), b = make(2, 2);
    image_difference d;
    base_error err = {0};
    assert_int_equal(image_compare(&a, &b, &d, &err), STRATA_OK);
    assert_true(d.max == 0 && d.rmse == 0 && d.differing == 0 && d.psnr == INFINITY);
    at(&a, 1, 0)[2] = 0.5f;
    at(&b, 0, 1)[3] = -0.25f;
    at(&b, 0, 1)[0] = 0.25f;
    assert_int_equal(image_compare(&a, &b, &d, &err), STRATA_OK);
    assert_true(d.max == 0.5 && d.differing == 2 && d.broken == 0 && d.x == 1 && d.y == 0);
    double rmse = sqrt((0.25 + 0.0625 + 0.0625) / 16);
    assert_true(fabs(d.rmse - rmse) < 1e-15);
    assert_true(fabs(d.psnr + 20 * log10(rmse)) < 1e-12);
    image wide = make(3, 2);
    assert_int_equal(image_compare(&a, &wide, &d, &err), STRATA_ERROR_INVALID_ARGUMENT);
    image_free(&wide);
    image_free(&b);
    image_free(&a);
}

static void compare_never_passes_what_is_not_a_number(void **state) {
    (void)state;
    static const struct {
        float a, b;
        uint64_t broken;
    } cases[] = {{NAN, NAN, 1},
                 {NAN, 0, 1},
                 {0, NAN, 1},
                 {INFINITY, 1, 1},
                 {1, -INFINITY, 1},
                 {INFINITY, -INFINITY, 1},
                 {INFINITY, INFINITY, 0},
                 {-INFINITY, -INFINITY, 0},
                 {0.0f, -0.0f, 0}};
    image a = make(1, 1), b = make(1, 1);
    for (size_t i = 0; i < BASE_COUNT(cases); ++i) {
        image_difference d;
        base_error err = {0};
        a.pixels[1] = cases[i].a;
        b.pixels[1] = cases[i].b;
        assert_int_equal(image_compare(&a, &b, &d, &err), STRATA_OK);
        assert_int_equal(d.broken, cases[i].broken);
        assert_true(cases[i].broken ? d.max == INFINITY && d.psnr == -INFINITY : d.max == 0);
    }
    image_free(&b);
    image_free(&a);
}

static void heat_map_grows_lighter_with_the_error(void **state) {
    (void)state;
    image a = make(10, 1), b = make(10, 1), heat;
    for (uint32_t x = 0; x < 8; ++x)
        at(&b, x, 0)[x % 4] = (float)pow(10, (double)x - 7.0); /* 1e-7 .. 1 */
    at(&b, 8, 0)[0] = NAN;
    base_error err = {0};
    assert_int_equal(image_heat_map(&a, &b, &heat, &err), STRATA_OK);
    double before = -1;
    for (uint32_t x = 0; x < 8; ++x) {
        const float *p = at(&heat, x, 0);
        double luminance = 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
        assert_true(luminance > before);
        before = luminance;
    }
    assert_true(at(&heat, 0, 0)[0] < 1e-3f && at(&heat, 7, 0)[1] > 0.999f);
    assert_true(at(&heat, 8, 0)[0] == 0 && at(&heat, 8, 0)[1] == 1 && at(&heat, 8, 0)[2] == 0);
    assert_true(at(&heat, 9, 0)[0] == 0 && at(&heat, 9, 0)[1] == 0 && at(&heat, 9, 0)[3] == 1);
    image_free(&heat);
    image_free(&b);
    image_free(&a);
}

/* ---- deep ----------------------------------------------------------------------------------- */

enum { DEEP_W = 13, DEEP_H = 7, DEEP_MAX = DEEP_W * DEEP_H * 40 };

typedef struct deep_case {
    image_deep deep;
    uint64_t offset[DEEP_W * DEEP_H];
    uint32_t count[DEEP_W * DEEP_H];
    float depth[DEEP_MAX], color[DEEP_MAX][4], alpha[DEEP_MAX][3];
} deep_case;

/* Random stacks of 0 to 39 samples, stored in pixels' reverse order to exercise the offsets. */
static deep_case *make_deep(int colored) {
    deep_case *c = calloc(1, sizeof *c);
    uint32_t seed = 5;
    uint64_t used = 0;
    for (int p = DEEP_W * DEEP_H - 1; p >= 0; --p) {
        c->offset[p] = used;
        c->count[p] = random_bits(&seed) % 40;
        float z = 1;
        for (uint32_t s = 0; s < c->count[p]; ++s, ++used) {
            z += (float)(random_bits(&seed) % 4) / 4; /* equal depths among them */
            c->depth[used] = z;
            float mean = 0;
            for (int k = 0; k < 3; ++k) {
                c->alpha[used][k] = (float)(random_bits(&seed) % 1000) / 4000;
                mean += c->alpha[used][k] / 3;
                c->color[used][k] = (float)(random_bits(&seed) % 1000) / 8000;
            }
            c->color[used][3] = mean;
        }
    }
    c->deep = (image_deep){.width = DEEP_W,
                           .height = DEEP_H,
                           .offset = c->offset,
                           .count = c->count,
                           .sample_count = used,
                           .depth = c->depth,
                           .color = &c->color[0][0],
                           .color_alpha = colored ? &c->alpha[0][0] : NULL};
    return c;
}

static int have_oiiotool(void) {
    if (system("oiiotool --version >/dev/null 2>&1") == 0)
        return 1;
    print_message("skipped: oiiotool (package openimageio-tools) is not installed\n");
    return 0;
}

/* Our own fold, in double, of channel `c` under the alphas a(sample). */
static double fold(const deep_case *d, size_t pixel, int c) {
    double color = 0, transmittance = 1;
    for (uint64_t s = d->offset[pixel]; s < d->offset[pixel] + d->count[pixel]; ++s) {
        double alpha =
            d->deep.color_alpha && c < 3 ? (double)d->alpha[s][c] : (double)d->color[s][3];
        color += transmittance * (double)d->color[s][c];
        transmittance *= 1 - alpha;
    }
    return color;
}

static void deep_flattens_to_our_fold(void **state) {
    (void)state;
    if (!have_oiiotool())
        skip();
    deep_case *d = make_deep(0);
    char command[512];
    base_error err = {0};
    image flat;
    assert_int_equal(image_write_deep_exr(&d->deep, place("deep.exr"), &err), STRATA_OK);
    snprintf(command, sizeof command, "oiiotool '%s' --flatten --ch R,G,B,A -d float -o '%s'",
             place("deep.exr"), place("flat.exr"));
    assert_int_equal(system(command), 0);
    assert_int_equal(image_read(place("flat.exr"), &flat, &err), STRATA_OK);
    for (size_t p = 0; p < DEEP_W * DEEP_H; ++p)
        for (int c = 0; c < 4; ++c)
            assert_true(fabs((double)flat.pixels[p * 4 + (size_t)c] - fold(d, p, c)) < 2e-6);
    image_free(&flat);
    free(d);
}

/* Each primary flattened under its own alpha, which is what coloured transmission means. */
static void deep_with_coloured_alpha_flattens_per_primary(void **state) {
    (void)state;
    if (!have_oiiotool())
        skip();
    deep_case *d = make_deep(1);
    base_error err = {0};
    assert_int_equal(image_write_deep_exr(&d->deep, place("glass.exr"), &err), STRATA_OK);
    for (int c = 0; c < 3; ++c) {
        char command[512];
        image flat;
        snprintf(command, sizeof command,
                 "oiiotool '%s' --ch Z=Z,%c=%c,A=A%c --flatten --ch %c -d float -o '%s'",
                 place("glass.exr"), "RGB"[c], "RGB"[c], "RGB"[c], "RGB"[c], place("flat.exr"));
        assert_int_equal(system(command), 0);
        assert_int_equal(image_read(place("flat.exr"), &flat, &err), STRATA_OK);
        for (size_t p = 0; p < DEEP_W * DEEP_H; ++p)
            assert_true(fabs((double)flat.pixels[p * 4] - fold(d, p, c)) < 2e-6);
        image_free(&flat);
    }
    free(d);
}

static void deep_input_is_checked(void **state) {
    (void)state;
    deep_case *d = make_deep(0);
    base_error err = {0};
    image im;
    d->count[3] = 1000000;
    assert_int_equal(image_write_deep_exr(&d->deep, place("wrong.exr"), &err),
                     STRATA_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(err.text, "pixel (3, 0)"));
    assert_int_equal(access(place("wrong.exr"), F_OK), -1);
    d->count[3] = 0;
    err = (base_error){0};
    assert_int_equal(image_write_deep_exr(&d->deep, place("deep.exr"), &err), STRATA_OK);
    assert_int_equal(image_read(place("deep.exr"), &im, &err), STRATA_ERROR_UNSUPPORTED);
    assert_non_null(strstr(err.text, "deep"));
    free(d);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(png_rounds_srgb_correctly),
        cmocka_unit_test(png_handles_alpha_and_odd_values),
        cmocka_unit_test(png_round_trip_keeps_every_code_and_the_rows),
        cmocka_unit_test(exr_round_trip_is_bit_exact),
        cmocka_unit_test(exr_plane_reads_back_as_grey),
        cmocka_unit_test(bad_files_fail_with_one_line_naming_them),
        cmocka_unit_test(png_bombs_are_refused_before_memory_is_asked_for),
        cmocka_unit_test(mangled_files_never_crash),
        cmocka_unit_test(failed_writes_leave_the_old_file_and_nothing_else),
        cmocka_unit_test(compare_gives_the_figures_worked_out_by_hand),
        cmocka_unit_test(compare_never_passes_what_is_not_a_number),
        cmocka_unit_test(heat_map_grows_lighter_with_the_error),
        cmocka_unit_test(deep_flattens_to_our_fold),
        cmocka_unit_test(deep_with_coloured_alpha_flattens_per_primary),
        cmocka_unit_test(deep_input_is_checked),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
