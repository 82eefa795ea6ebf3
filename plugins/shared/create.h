/* SPDX-License-Identifier: MIT
 *
 * Buffers and images of which only a size, a format and a label matter.
 */
#ifndef STRATA_PLUGINS_CREATE_H
#define STRATA_PLUGINS_CREATE_H

#include "strata/strata.h"

/* One that is bound as a whole: where the device cannot, OUT_OF_DEVICE_MEMORY, after which the host
 * tries with more bands, for which it is smaller. */
static inline strata_result create_buffer(const strata_gpu *gpu, const char *label, uint64_t size,
                                          strata_buffer *out) {
    const uint64_t range = gpu->fact(gpu->self, "limit.storage_range");
    if (range > 0 && size > range)
        return STRATA_ERROR_OUT_OF_DEVICE_MEMORY;
    return gpu->buffer_create(gpu->self,
                              &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                    .label = label,
                                                    .size = size},
                              out);
}

/* Width and height 0: the frame's; layers 0: a plain image. */
static inline strata_result create_array(const strata_gpu *gpu, const char *label, uint32_t format,
                                         uint32_t width, uint32_t height, uint32_t layers,
                                         strata_image *out) {
    return gpu->image_create(gpu->self,
                             &(strata_image_desc){.struct_size = sizeof(strata_image_desc),
                                                  .label = label,
                                                  .format = format,
                                                  .width = width,
                                                  .height = height,
                                                  .layers = layers},
                             out);
}

static inline strata_result create_image(const strata_gpu *gpu, const char *label, uint32_t format,
                                         uint32_t width, uint32_t height, strata_image *out) {
    return create_array(gpu, label, format, width, height, 0, out);
}

#endif
