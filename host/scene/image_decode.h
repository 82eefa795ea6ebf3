/* SPDX-License-Identifier: MIT
 *
 * PNG and JPEG files in memory to 8-bit RGBA, for the textures of scenes. Private to host/scene.
 */
#ifndef STRATA_HOST_SCENE_IMAGE_DECODE_H
#define STRATA_HOST_SCENE_IMAGE_DECODE_H

#include "scene/scene_internal.h"

/* Fills width, height and pixels (malloc'd). Refuses sides above SCENE_MAX_IMAGE and files that
 * unfold to more memory than their size in pixels explains. The text of err names no file. */
strata_result scene_decode_image(const unsigned char *bytes, size_t size, scene_image *out,
                                 base_error *err);

#endif
