/* SPDX-License-Identifier: MIT
 *
 * Recording apart from passes: the frame's state and first error, fills, copies and clears,
 * submission with its timings, and the host's own reads and writes.
 */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the frame ------------------------------------------------------------------------------ */

void gpu_begin(gpu *g, uint32_t frame_width, uint32_t frame_height) {
    if (g->open)
        gpu_flush(g);
    if (g->profile && !g->selftest_running && g->backend != &gpu_backend_null)
        g->clock_passes = !gpu_selftest(g, "selftest.timestamps");
    g->begun = 1;
    g->frame_error = (base_error){0};
    g->frame_code = g->last_code = GPU_ERROR_NONE;
    g->timing_count = g->timing_submitted = 0;
    g->frame_width = frame_width;
    g->frame_height = frame_height;
    gpu_rectangle(g, 0, 0, frame_width, frame_height);
    gpu_pools_begin(g);
    if (g->lost) {
        g->where_owner = "device";
        g->where_label = "begin";
        gpu_record_fail(g, GPU_ERROR_LOST, "frame");
    }
}

void gpu_rectangle(gpu *g, uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
    uint32_t left = x < g->frame_width ? x : g->frame_width;
    uint32_t low = y < g->frame_height ? y : g->frame_height;
    g->rectangle[0] = left;
    g->rectangle[1] = low;
    g->rectangle[2] = width < g->frame_width - left ? width : g->frame_width - left;
    g->rectangle[3] = height < g->frame_height - low ? height : g->frame_height - low;
}

int gpu_recording(gpu *g, const char *owner, const char *label) {
    g->where_owner = owner ? owner : "host";
    g->where_label = label ? label : "";
    if (g->frame_error.result != STRATA_OK)
        return 0;
    if (g->lost) {
        gpu_record_fail(g, GPU_ERROR_LOST, "device");
        return 0;
    }
    if (!g->begun) {
        gpu_record_fail(g, GPU_ERROR_STATE, "before gpu_begin");
        return 0;
    }
    return 1;
}

void gpu_open_commands(gpu *g) {
    if (g->open)
        return;
    g->open = 1;
    g->backend->begin(g->self);
}

gpu_code gpu_last_code(const gpu *g) {
    return g->last_code;
}

const base_error *gpu_frame_error(const gpu *g) {
    return &g->frame_error;
}

void gpu_frame_fail(gpu *g, const char *owner, strata_result result, const char *text) {
    if (result < 0 && g->frame_error.result == STRATA_OK)
        base_fail(&g->frame_error, result, "%s: %s", owner, text ? text : "failed");
}

/* ---- fill, copy, clear ---------------------------------------------------------------------- */

/* A buffer of a recording call and the part of it that is meant; size 0 = to the end. */
static gpu_object *ranged_buffer(gpu *g, strata_buffer buffer, uint64_t offset, uint64_t *size) {
    gpu_code code;
    gpu_object *object = gpu_object_find(g, buffer.id, GPU_BUFFER, &code);
    if (!object) {
        gpu_record_fail(g, code, "buffer %u", buffer.id);
        return NULL;
    }
    if (!object->buffer.storage) {
        gpu_record_fail(g, GPU_ERROR_MEMORY, "buffer '%s'", object->label);
        return NULL;
    }
    if (offset <= object->buffer.size && *size == 0)
        *size = object->buffer.size - offset;
    if (offset > object->buffer.size || *size > object->buffer.size - offset || offset % 4 ||
        *size % 4) {
        gpu_record_fail(g, GPU_ERROR_BUFFER_RANGE, "buffer '%s' of %llu bytes, %llu at %llu",
                        object->label, (unsigned long long)object->buffer.size,
                        (unsigned long long)*size, (unsigned long long)offset);
        return NULL;
    }
    return object;
}

void gpu_fill(gpu *g, const char *owner, strata_buffer buffer, uint64_t offset, uint64_t size,
              uint32_t value) {
    gpu_barrier barriers[GPU_MAX_USES];
    gpu_uses uses = {0};
    if (!gpu_recording(g, owner, "fill"))
        return;
    gpu_object *object = ranged_buffer(g, buffer, offset, &size);
    if (!object || size == 0)
        return;
    gpu_uses_add(&uses, object->buffer.storage, GPU_ACCESS_COPY_WRITE, 0);
    uint32_t count = gpu_hazards_derive(&uses, barriers);
    gpu_open_commands(g);
    g->backend->fill(g->self, object->buffer.storage->native, offset, size, value, barriers, count);
}

void gpu_copy(gpu *g, const char *owner, strata_buffer to, uint64_t to_offset, strata_buffer from,
              uint64_t from_offset, uint64_t size) {
    gpu_barrier barriers[GPU_MAX_USES];
    gpu_uses uses = {0};
    if (!gpu_recording(g, owner, "copy"))
        return;
    gpu_object *source = ranged_buffer(g, from, from_offset, &size);
    if (!source || size == 0)
        return;
    gpu_object *target = ranged_buffer(g, to, to_offset, &size);
    if (!target)
        return;
    if (source->buffer.storage == target->buffer.storage && from_offset < to_offset + size &&
        to_offset < from_offset + size) {
        gpu_record_fail(g, GPU_ERROR_BUFFER_RANGE, "buffer '%s' copied onto itself", source->label);
        return;
    }
    gpu_uses_add(&uses, source->buffer.storage, GPU_ACCESS_COPY_READ, 0);
    gpu_uses_add(&uses, target->buffer.storage, GPU_ACCESS_COPY_WRITE, 0);
    uint32_t count = gpu_hazards_derive(&uses, barriers);
    gpu_open_commands(g);
    g->backend->copy(g->self, target->buffer.storage->native, to_offset,
                     source->buffer.storage->native, from_offset, size, barriers, count);
}

void gpu_clear_image(gpu *g, const char *owner, strata_image image, const float value[4]) {
    gpu_barrier barriers[GPU_MAX_USES];
    gpu_uses uses = {0};
    gpu_code code;
    if (!gpu_recording(g, owner, "clear"))
        return;
    gpu_object *object = gpu_object_find(g, image.id, GPU_IMAGE, &code);
    if (!object) {
        gpu_record_fail(g, code, "image %u", image.id);
        return;
    }
    if (object->image.format == STRATA_FORMAT_RGBA8_SRGB) {
        gpu_record_fail(g, GPU_ERROR_IMAGE_FORMAT, "image '%s'", object->label);
        return;
    }
    gpu_uses_add(&uses, object->image.storage, GPU_ACCESS_COPY_WRITE, 0);
    uint32_t count = gpu_hazards_derive(&uses, barriers);
    gpu_open_commands(g);
    g->backend->clear_image(g->self, object->image.storage->native, value, barriers, count);
}

/* ---- submit --------------------------------------------------------------------------------- */

static void stick(gpu *g, const base_error *failure) {
    if (g->frame_error.result != STRATA_OK)
        return;
    g->frame_error = *failure;
    g->frame_code = g->last_code;
}

void gpu_flush(gpu *g) {
    base_error failure = {0};
    uint32_t count = (uint32_t)(g->timing_count - g->timing_submitted);
    double *ms = count ? base_calloc(count, sizeof *ms) : NULL;
    if (!g->open)
        return;
    g->open = 0;
    for (uint32_t i = 0; ms && i < count; i++)
        ms[i] = -1.0;
    strata_result result = g->backend->submit(g->self, ms, ms ? count : 0, &failure);
    for (uint32_t i = 0; ms && i < count; i++)
        g->timings[g->timing_submitted + i].gpu_ms = g->profile ? ms[i] : -1.0;
    g->timing_submitted = g->timing_count;
    free(ms);
    g->submits++;
    if (g->inject == GPU_INJECT_LOST && g->submits == g->inject_at && result == STRATA_OK)
        result = base_fail(&failure, STRATA_ERROR_DEVICE_LOST, "submit (injected): %s",
                           gpu_code_text(GPU_ERROR_LOST));
    if (gpu_backend_result(g, &failure, result) != STRATA_OK)
        stick(g, &failure);
}

strata_result gpu_submit(gpu *g, base_error *err) {
    if (g->open)
        gpu_flush(g);
    if (!g->begun)
        return gpu_fail(g, err, GPU_ERROR_STATE, "submit before gpu_begin");
    if (g->frame_error.result != STRATA_OK) {
        if (g->frame_code != GPU_ERROR_NONE)
            g->last_code = g->frame_code;
        return base_fail(err, g->frame_error.result, "%s", g->frame_error.text);
    }
    return STRATA_OK;
}

const gpu_timing *gpu_timings(const gpu *g, uint32_t *count) {
    *count = (uint32_t)g->timing_count;
    return g->timings;
}

/* ---- host access ---------------------------------------------------------------------------- */

static strata_result host_buffer(gpu *g, strata_buffer buffer, uint64_t offset, uint64_t size,
                                 gpu_storage **out, base_error *err) {
    gpu_code code;
    if (g->lost)
        return gpu_fail(g, err, GPU_ERROR_LOST, "buffer %u", buffer.id);
    gpu_object *object = gpu_object_find(g, buffer.id, GPU_BUFFER, &code);
    if (!object)
        return gpu_fail(g, err, code, "buffer %u", buffer.id);
    if (g->open)
        return gpu_fail(g, err, GPU_ERROR_STATE, "buffer '%s' while recording", object->label);
    if (!object->buffer.storage)
        return gpu_fail(g, err, GPU_ERROR_MEMORY, "buffer '%s'", object->label);
    if (offset > object->buffer.size || size > object->buffer.size - offset || offset % 4 ||
        size % 4)
        return gpu_fail(g, err, GPU_ERROR_BUFFER_RANGE, "buffer '%s' of %llu bytes, %llu at %llu",
                        object->label, (unsigned long long)object->buffer.size,
                        (unsigned long long)size, (unsigned long long)offset);
    *out = object->buffer.storage;
    return STRATA_OK;
}

strata_result gpu_buffer_read(gpu *g, strata_buffer buffer, uint64_t offset, uint64_t size,
                              void *data, base_error *err) {
    gpu_storage *storage = NULL;
    strata_result result = host_buffer(g, buffer, offset, size, &storage, err);
    if (result != STRATA_OK || size == 0)
        return result;
    return gpu_backend_result(
        g, err, g->backend->buffer_read(g->self, storage->native, offset, size, data, err));
}

strata_result gpu_buffer_write(gpu *g, strata_buffer buffer, uint64_t offset, uint64_t size,
                               const void *data, base_error *err) {
    gpu_storage *storage = NULL;
    strata_result result = host_buffer(g, buffer, offset, size, &storage, err);
    if (result != STRATA_OK || size == 0)
        return result;
    gpu_hazards_uploaded(storage);
    return gpu_backend_result(
        g, err, g->backend->buffer_write(g->self, storage->native, offset, size, data, err));
}

static strata_result host_image(gpu *g, strata_image image, uint32_t layer, gpu_object **out,
                                base_error *err) {
    gpu_code code;
    if (g->lost)
        return gpu_fail(g, err, GPU_ERROR_LOST, "image %u", image.id);
    *out = gpu_object_find(g, image.id, GPU_IMAGE, &code);
    if (!*out)
        return gpu_fail(g, err, code, "image %u", image.id);
    if (g->open)
        return gpu_fail(g, err, GPU_ERROR_STATE, "image '%s' while recording", (*out)->label);
    if ((*out)->image.samples > 1)
        return gpu_fail(g, err, GPU_ERROR_IMAGE_SAMPLES, "image '%s' of %u samples", (*out)->label,
                        (*out)->image.samples);
    if (layer >= ((*out)->image.layers ? (*out)->image.layers : 1))
        return gpu_fail(g, err, GPU_ERROR_IMAGE_SIZE, "image '%s': layer %u", (*out)->label, layer);
    return STRATA_OK;
}

strata_result gpu_image_read(gpu *g, strata_image image, uint32_t layer, void *texels, size_t size,
                             base_error *err) {
    gpu_object *object = NULL;
    strata_result result = host_image(g, image, layer, &object, err);
    if (result != STRATA_OK)
        return result;
    uint64_t wanted = (uint64_t)object->image.width * object->image.height *
                      gpu_format_bytes(object->image.format);
    if (size != wanted)
        return gpu_fail(g, err, GPU_ERROR_IMAGE_SIZE, "image '%s' of %llu bytes read as %zu",
                        object->label, (unsigned long long)wanted, size);
    return gpu_backend_result(
        g, err,
        g->backend->image_read(g->self, object->image.storage->native, layer, texels, size, err));
}

strata_result gpu_image_write(gpu *g, strata_image image, uint32_t layer, uint32_t x, uint32_t y,
                              uint32_t width, uint32_t height, const void *texels,
                              base_error *err) {
    gpu_object *object = NULL;
    strata_result result = host_image(g, image, layer, &object, err);
    if (result != STRATA_OK)
        return result;
    if (x > object->image.width || width > object->image.width - x || y > object->image.height ||
        height > object->image.height - y)
        return gpu_fail(g, err, GPU_ERROR_IMAGE_SIZE, "image '%s': %ux%u texels at %u, %u",
                        object->label, width, height, x, y);
    if (gpu_format_is_depth(object->image.format))
        return gpu_fail(g, err, GPU_ERROR_IMAGE_FORMAT, "image '%s' written by the host",
                        object->label);
    if (width == 0 || height == 0)
        return STRATA_OK;
    gpu_hazards_uploaded(object->image.storage);
    return gpu_backend_result(g, err,
                              g->backend->image_write(g->self, object->image.storage->native, layer,
                                                      x, y, width, height, texels, err));
}
