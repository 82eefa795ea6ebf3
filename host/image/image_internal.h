/* SPDX-License-Identifier: MIT
 *
 * What the files of host/image share among themselves: decoders, what comparing takes,
 * and an EXR file being written into a base_output. Not for other folders.
 */
#ifndef STRATA_HOST_IMAGE_INTERNAL_H
#define STRATA_HOST_IMAGE_INTERNAL_H

#include "image/image.h"

#include <openexr.h>

strata_result image_decode_png(const char *name, const void *data, size_t size, image *out,
                               base_error *err);
strata_result image_decode_exr(const char *name, const void *data, size_t size, image *out,
                               base_error *err);

/* Colour t, 0..1, of the heat map's ramp (image.h). */
void image_ramp(double t, float out[4]);
strata_result image_same_size(const image *a, const image *b, base_error *err);

/* One EXR part under construction: open, exr_add_channel on `context` for each channel, header,
 * chunks, and close, which commits the file when `result` is OK and the library could finish it,
 * and removes what there is of it otherwise. The struct may not move between open and close. */
typedef struct image_exr_writer {
    exr_context_t context;
    base_output output;
} image_exr_writer;

strata_result image_exr_open(image_exr_writer *writer, const char *path, exr_storage_t storage,
                             exr_compression_t compression, uint32_t width, uint32_t height,
                             base_error *err);
/* Reports `code`, a result of the library, against the file. OK stays OK. */
strata_result image_exr_check(const image_exr_writer *writer, exr_result_t code, base_error *err);
strata_result image_exr_close(image_exr_writer *writer, strata_result result, base_error *err);

#endif
