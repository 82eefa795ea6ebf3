/* SPDX-License-Identifier: MIT
 *
 * The renderer held to a program that is not ours: the deep EXR flattened by OpenImageIO's
 * `oiiotool --flatten`, with the background behind it, must be the rendered EXR within the rounding
 * of both. Under coloured transmission a primary at a time, as host/image/image.h says.
 *
 * What oiiotool rounds, u = 2^-24. It goes C += (1 - A) c, A += (1 - A) a in float, with A taken as
 * the mean of three equal numbers: three roundings, and one each of the difference, the product and
 * a, which the file has as 1 - transmittance. With T = 1 - A and d the error of A,
 *        d' = d |1 - a| + gamma_6 (T + d) |a| + u,
 * and a term of C is off by |c| (d + gamma_6 (T + d)) and its addition by u |C|, or by the whole
 * term if that is less. It stops where A has reached 1: what it leaves out is within |c| d.
 */
#define _POSIX_C_SOURCE 200809L
#include "oracle/oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct folder { /* in the build tree, so that a failure leaves its files to look at */
    char path[1024];
} folder;

/* ---- files ----------------------------------------------------------------------------------- */

static void run(const char *command) {
    if (system(command) != 0)
        fail_msg("failed: %s", command);
}

static image read_image(const folder *f, const char *name) {
    char path[1100];
    image im = {0};
    base_error err = {0};
    snprintf(path, sizeof path, "%s/%s.exr", f->path, name);
    if (image_read(path, &im, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    unlink(path);
    return im;
}

static void save(strata *s, uint32_t output, const folder *f, const char *name) {
    char path[1100];
    snprintf(path, sizeof path, "%s/%s.exr", f->path, name);
    if (strata_save(s, output, path) != STRATA_OK)
        fail_msg("%s", strata_error(s));
}

/* One flattened image for each of r, g, b and alpha: its colour in R, its own alpha in A. */
static void flatten(const folder *f, int colored, image out[4]) {
    static const char *const channels[2][4] = {
        {"R=R,A=A --flatten --ch R=R,G=R,B=R,A=A", "R=G,A=A --flatten --ch R=R,G=R,B=R,A=A",
         "R=B,A=A --flatten --ch R=R,G=R,B=R,A=A", "A=A --flatten --ch R=A,G=A,B=A,A=A"},
        {"R=R,A=AR --flatten --ch R=R,G=R,B=R,A=A", "R=G,A=AG --flatten --ch R=R,G=R,B=R,A=A",
         "R=B,A=AB --flatten --ch R=R,G=R,B=R,A=A", "A=A --flatten --ch R=A,G=A,B=A,A=A"}};
    char command[4096];
    for (int c = 0; c < 4; c++) {
        snprintf(command, sizeof command, "oiiotool %s/deep.exr --ch Z=Z,%s -o %s/flat.exr",
                 f->path, channels[colored][c], f->path);
        run(command);
        out[c] = read_image(f, "flat");
    }
}

/* ---- bounds ---------------------------------------------------------------------------------- */

/* How far oiiotool may be off the exact colour, whose channels are r, g, b and alpha. */
static void outside_errors(const oracle_capture *c, const oracle_record *sorted, size_t count,
                           const float *behind, double out[4]) {
    const double gamma = oracle_gamma(6, ORACLE_UNIT);
    double through[4] = {1, 1, 1, 1}, off[4] = {0}, sum[4] = {0};
    for (int k = 0; k < 4; k++)
        out[k] = 0;
    for (size_t i = 0; i <= count; i++) {
        oracle_element e = {0};
        if (i < count)
            e = oracle_decode(c->plan, &sorted[i]);
        for (int k = 0; k < 4; k++) {
            const double color = i < count ? e.color[k].value : (double)behind[k];
            const double a = k < 3 ? 1 - e.through[k].value : color, t = through[k];
            const double error = off[k] + gamma * (t + off[k]);
            sum[k] += t * color;
            out[k] += fabs(color) * error +
                      fmin(ORACLE_UNIT * (fabs(sum[k]) + out[k]), (t + error) * fabs(color));
            off[k] = off[k] * fabs(1 - a) + gamma * (t + off[k]) * fabs(a) + ORACLE_UNIT;
            through[k] = t * (1 - a);
        }
    }
}

static void check_pixel(const oracle_case *k, const oracle_capture *c, size_t pixel,
                        const image flat[4], const image *own, double *worst) {
    const size_t count = c->first[pixel + 1] - c->first[pixel];
    oracle_record *sorted = c->records + c->first[pixel];
    const float *behind = c->behind + 4 * pixel;
    oracle_value want[4];
    double outside[4];
    oracle_sort(sorted, count);
    oracle_fold(c->plan, sorted, count, behind, want);
    outside_errors(c, sorted, count, behind, outside);
    for (int i = 0; i < 4; i++) {
        const float *f = flat[i].pixels + 4 * pixel;
        const double seen = (double)f[0] + (1.0 - (double)f[3]) * (double)c->background[i];
        const double error = fabs(seen - (double)own->pixels[4 * pixel + (size_t)i]);
        const double most = want[i].error + outside[i];
        if (!(error <= most))
            fail_msg("%s: pixel %zu (%zu, %zu), channel %d, %zu fragments: oiiotool has %.9g, the "
                     "image %.9g, more than %.3g apart",
                     k->scene, pixel, pixel % c->width, pixel / c->width, i, count, seen,
                     (double)own->pixels[4 * pixel + (size_t)i], most);
        *worst = fmax(*worst, error / most);
    }
}

static void check_case(strata *s, const folder *f, const oracle_case *k) {
    strata_scene *sc = oracle_scene(s, k->scene);
    oracle_capture c;
    image flat[4];
    double worst = 0;
    oracle_capture_frame(s, sc, k, &c);
    save(s, STRATA_OUTPUT_DEEP, f, "deep");
    save(s, STRATA_OUTPUT_COLOR, f, "own");
    flatten(f, c.plan->transmittance_channels == 3, flat);
    image own = read_image(f, "own");
    for (size_t p = 0; p < (size_t)c.width * c.height; p++)
        check_pixel(k, &c, p, flat, &own, &worst);
    print_message("  %-50s %7zu fragments, %u transmittance%s; apart <= %.2f bound\n", k->scene,
                  c.record_count, c.plan->transmittance_channels,
                  c.plan->transmittance_channels == 1 ? "" : "s", worst);
    for (int i = 0; i < 4; i++)
        image_free(&flat[i]);
    image_free(&own);
    oracle_capture_free(&c);
    strata_scene_close(sc);
}

static void test_flatten(void **state) {
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:soup?small=1500&medium=150&depth=14", 80, 64)},
        {ORACLE_FRAME("scene:stack?count=100&alpha=0.05&opaque=1", 48, 48)},
        {ORACLE_FRAME("scene:particles?count=600&radius=0.08", 64, 64)},
        {ORACLE_FRAME("scene:glass?detail=1&smoke=300", 80, 60)},
        {ORACLE_FRAME("scene:layers?count=65&width=24&height=16", 24, 16)},
        {ORACLE_FRAME("own:ties", 64, 64), .setting = {"abuffer.mode=linked"}},
    };
    const char *build = getenv("STRATA_TEST_BUILD");
    folder f;
    char path[1100];
    base_error err = {0};
    if (system("command -v oiiotool >/dev/null 2>&1") != 0) {
        print_message("skipped: oiiotool is not installed\n");
        skip();
    }
    strata *s = oracle_open(state);
    if (!s)
        skip();
    snprintf(f.path, sizeof f.path, "%s/tests/oracle_%s", build ? build : ".", s->backend);
    assert_int_equal(base_make_folders(f.path, &err), STRATA_OK);
    for (size_t i = 0; i < BASE_COUNT(cases); i++)
        check_case(s, &f, &cases[i]);
    snprintf(path, sizeof path, "%s/deep.exr", f.path);
    unlink(path);
    rmdir(f.path);
    strata_close(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        {"test_flatten_vulkan", test_flatten, NULL, NULL, "vulkan"},
        {"test_flatten_gl", test_flatten, NULL, NULL, "gl"},
    };
    return cmocka_run_group_tests_name("oracle_outside", tests, NULL, NULL);
}
