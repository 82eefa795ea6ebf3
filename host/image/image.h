/* SPDX-License-Identifier: MIT
 *
 * Images as files and as numbers: PNG, EXR and deep EXR, error metrics and heat maps. Last noun of
 * scene -> demand -> plan -> frame -> fragments -> image. Knows nothing of scenes or devices.
 *
 * Everywhere: linear Rec. 709 floats, premultiplied alpha, row 0 = the bottom row, as rendered.
 * Files have their top row first; readers and writers turn the image over. A written file appears
 * whole or not at all. Readers take any bytes: a bad file is one line that names it.
 */
#ifndef STRATA_HOST_IMAGE_H
#define STRATA_HOST_IMAGE_H

#include "base/base.h"

#define IMAGE_MAX_SIDE       65535u
#define IMAGE_MAX_PIXELS     ((uint64_t)1 << 28)
#define IMAGE_MAX_FILE_BYTES ((size_t)8 << 30)

typedef struct image {
    uint32_t width, height; /* 1..IMAGE_MAX_SIDE, at most IMAGE_MAX_PIXELS in all */
    float *pixels;          /* [height][width][4]: R G B A */
} image;

/* All zero (transparent black). The caller frees with image_free; *out is zeroed on failure. */
strata_result image_create(uint32_t width, uint32_t height, image *out, base_error *err);
/* Averages of areas, without a side longer than `longest`; the same size when it is small enough.
 */
strata_result image_shrink(const image *im, uint32_t longest, image *out, base_error *err);
void image_free(image *im); /* leaves it zeroed; NULL and a zeroed image are fine */

/* By the name's ending: .png or .exr, in any case; anything else is an invalid argument. */
strata_result image_write(const image *im, const char *path, base_error *err);
/* PNG or EXR by the first bytes, whatever the name. */
strata_result image_read(const char *path, image *out, base_error *err);
/* The same from memory; name stands in messages. */
strata_result image_read_memory(const char *name, const void *data, size_t size, image *out,
                                base_error *err);

/* ---- PNG: 8-bit sRGB, straight alpha --------------------------------------------------------
 * Each value is clamped to 0..1 and goes to the code whose sRGB value is nearest (correctly
 * rounded, not a gamma approximation). Colour without alpha cannot be said in straight alpha: alpha
 * 0 is written as transparent black. NaN is written as 0. The reader takes any PNG; 16-bit files
 * lose their low bits. */
strata_result image_write_png(const image *im, const char *path, base_error *err);

/* rgba: [height][width][4] bytes, first row on top, to a PNG in memory, byte for byte.
 * The caller frees *data. `name` stands in messages. */
strata_result image_encode_png(const char *name, const unsigned char *rgba, uint32_t width,
                               uint32_t height, unsigned char **data, size_t *size,
                               base_error *err);

/* Linear value of an 8-bit sRGB code, rounded once from double. */
float image_srgb_to_linear(unsigned char code);

/* ---- EXR: 32-bit float, ZIP -----------------------------------------------------------------
 * The reader takes the first part of scan-line and tiled files with channels R, G, B (and A, else
 * 1), or Y, or a single channel of any name, which become grey. Half and uint are converted. */
strata_result image_write_exr(const image *im, const char *path, base_error *err);

/* One plane under a name of its own ("Z", "Y", ...); values: [height][width], row 0 = bottom. */
strata_result image_write_exr_plane(const float *values, uint32_t width, uint32_t height,
                                    const char *channel, const char *path, base_error *err);

/* ---- deep EXR: every fragment of every pixel ------------------------------------------------
 * Channels Z (eye depth, positive, grows with distance), R, G, B (premultiplied), A and, under
 * coloured transmission, AR, AG, AB = 1 - transmittance per primary, all 32-bit float.
 * `oiiotool --flatten` folds R, G, B, A exactly. Coloured alphas it accumulates by their mean,
 * which is wrong from the third layer on and leaves 0..1, so fold such a file a primary at a time:
 * `oiiotool F --ch Z=Z,R=R,A=AR --flatten`. Uncompressed: 20 or 32 bytes a sample. */
typedef struct image_deep {
    uint32_t width, height;
    const uint64_t *offset;   /* [height][width], row 0 = bottom: index of a pixel's first sample */
    const uint32_t *count;    /* [height][width] samples of a pixel */
    uint64_t sample_count;    /* length of the arrays below; offset + count <= sample_count */
    const float *depth;       /* [sample_count], ascending within a pixel */
    const float *color;       /* [sample_count][4] premultiplied R G B A */
    const float *color_alpha; /* [sample_count][3] AR AG AB, or NULL */
} image_deep;

strata_result image_write_deep_exr(const image_deep *deep, const char *path, base_error *err);

/* ---- comparing ------------------------------------------------------------------------------ */
typedef struct image_difference {
    double max;         /* largest |a - b| over all pixels and the four channels */
    double rmse;        /* over all channels */
    double psnr;        /* decibels below a peak of 1: -20 log10(rmse); +infinity when equal */
    uint64_t differing; /* pixels in which any channel differs, broken ones included */
    uint64_t broken;    /* pixels with a NaN, or an infinity the other image does not have */
    uint32_t x, y;      /* the first pixel that has `max` (or is broken), row 0 = bottom */
} image_difference;

/* Linear, in double, fixed order of summation. With any broken pixel max and rmse are +infinity and
 * psnr is -infinity, so that no threshold passes. Fails when the sizes differ. */
strata_result image_compare(const image *a, const image *b, image_difference *out, base_error *err);

/* The largest |a - b| of each pixel's channels on a ramp of even perceived lightness, black through
 * blue, magenta, red and yellow to white, over a logarithmic scale that is the same for all maps:
 * IMAGE_HEAT_FLOOR and below black (0 exactly: black too), 1 and above white: one step of lightness
 * a decade. Broken pixels are pure green, which is not on the ramp. The caller frees *out. */
#define IMAGE_HEAT_FLOOR 1e-7
strata_result image_heat_map(const image *a, const image *b, image *out, base_error *err);

/* FLIP (Andersson et al. 2020), the difference seen when alternating between two pictures on a
 * display: colours clamped to 0..1, alpha left out (over black). 0 the same .. 1 black to white. */
#define IMAGE_FLIP_PIXELS_PER_DEGREE 67.0
typedef struct image_flip {
    double mean, max;
    double
        weighted_median; /* the value below which half of the sum of all values lies; 0 if all 0 */
} image_flip;

/* Symmetric, in spite of the names. map: a picture that the caller frees, on the heat map's ramp
 * but even from 0 to 1, or NULL. Broken values read as 0. INVALID_ARGUMENT: the sizes differ, or
 * pixels_per_degree is not within 1..1000. */
strata_result image_flip_compare(const image *reference, const image *test,
                                 double pixels_per_degree, image_flip *out, image *map,
                                 base_error *err);

#endif
