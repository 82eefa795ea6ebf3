/* SPDX-License-Identifier: MIT
 *
 * The backend without a GPU: logs each call as one line, with labels and barriers, so that plans,
 * lifetimes and "nothing unrequested ran" are tested anywhere. Buffers and images are real memory:
 * writes, reads, fills, copies and clears work; passes do nothing but call what native ones bring.
 */
#include "gpu/backend.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct null_object {
    char label[64];
    uint64_t size;
    uint32_t width, height, layers, format; /* images */
    unsigned char *bytes;                   /* NULL: a program */
} null_object;

typedef struct null_device {
    base_text log;
} null_device;

static const struct {
    uint32_t bit;
    const char *name;
} access_names[] = {
    {GPU_ACCESS_INDIRECT, "indirect"},
    {GPU_ACCESS_INDEX, "index"},
    {GPU_ACCESS_UNIFORM, "uniform"},
    {GPU_ACCESS_SAMPLED, "sampled"},
    {GPU_ACCESS_STORAGE_READ, "storage-read"},
    {GPU_ACCESS_STORAGE_WRITE, "storage-write"},
    {GPU_ACCESS_COLOR, "color"},
    {GPU_ACCESS_DEPTH, "depth"},
    {GPU_ACCESS_COPY_READ, "copy-read"},
    {GPU_ACCESS_COPY_WRITE, "copy-write"},
    {GPU_ACCESS_NATIVE, "native"},
    {GPU_ACCESS_COLOR_READ, "color-read"},
};

/* ---- open and close ------------------------------------------------------------------------- */

static strata_result null_open(const gpu_open_info *info, void **self, gpu_backend_caps *caps,
                               base_error *err) {
    null_device *device = base_calloc(1, sizeof *device);
    (void)info;
    if (!device)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory");
    *caps = (gpu_backend_caps){.storage_range = UINT64_C(128) << 20,
                               .texels = UINT64_C(32) << 20,
                               .storage_blocks = 16,
                               .image_size = 16384,
                               .groups = 65535,
                               .subgroup = 1,
                               .samples = 8,
                               .raster_order_attachments = 1,
                               .vulkan_target = 1};
    snprintf(caps->name, sizeof caps->name, "null");
    snprintf(caps->driver, sizeof caps->driver, "none");
    *self = device;
    return STRATA_OK;
}

static void null_close(void *self) {
    null_device *device = self;
    base_text_free(&device->log);
    free(device);
}

static void null_enumerate(void (*found)(void *user, const gpu_device_info *info, uint32_t index),
                           void *user) {
    const gpu_device_info info = {.backend = "null", .name = "null", .driver = "none"};
    found(user, &info, 0);
}

static const char *null_log(void *self) {
    null_device *device = self;
    return device->log.data ? device->log.data : "";
}

/* ---- objects -------------------------------------------------------------------------------- */

static null_object *object_new(const char *label, uint64_t size) {
    null_object *object = base_calloc(1, sizeof *object);
    if (!object)
        return NULL;
    snprintf(object->label, sizeof object->label, "%s", label);
    object->size = size;
    if (size && !(object->bytes = base_calloc((size_t)size, 1))) {
        free(object);
        return NULL;
    }
    return object;
}

static void object_free(null_object *object) {
    free(object->bytes);
    free(object);
}

static strata_result null_buffer_create(void *self, const strata_buffer_desc *desc, void **native,
                                        base_error *err) {
    null_device *device = self;
    null_object *object = object_new(desc->label, desc->size);
    if (!object)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "%s: no memory", desc->label);
    if (desc->data)
        memcpy(object->bytes, desc->data, (size_t)desc->size);
    base_text_add(&device->log, "buffer %s %llu\n", desc->label, (unsigned long long)desc->size);
    *native = object;
    return STRATA_OK;
}

static void null_buffer_destroy(void *self, void *native) {
    null_device *device = self;
    null_object *object = native;
    base_text_add(&device->log, "destroy buffer %s\n", object->label);
    object_free(object);
}

static strata_result null_image_create(void *self, const strata_image_desc *desc, void **native,
                                       base_error *err) {
    null_device *device = self;
    uint32_t layers = desc->layers ? desc->layers : 1;
    uint64_t size = (uint64_t)desc->width * desc->height * layers * desc->samples *
                    gpu_format_bytes(desc->format);
    null_object *object = object_new(desc->label, size);
    if (!object)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "%s: no memory", desc->label);
    object->width = desc->width;
    object->height = desc->height;
    object->layers = layers;
    object->format = desc->format;
    base_text_add(&device->log, "image %s %ux%ux%u format %u", desc->label, desc->width,
                  desc->height, desc->layers, desc->format);
    if (desc->samples > 1)
        base_text_add(&device->log, " samples %u", desc->samples);
    base_text_add(&device->log, "\n");
    *native = object;
    return STRATA_OK;
}

static void null_image_destroy(void *self, void *native) {
    null_device *device = self;
    null_object *object = native;
    base_text_add(&device->log, "destroy image %s\n", object->label);
    object_free(object);
}

static strata_result null_program_create(void *self, const gpu_program_info *info, void **native,
                                         base_error *err) {
    null_device *device = self;
    null_object *object = object_new(info->label, 0);
    if (!object)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", info->label);
    base_text_add(&device->log, "program %s params %u", info->label, info->params_size);
    for (uint32_t i = 0; i < info->binding_count; i++)
        base_text_add(&device->log, " %s@%u", info->bindings[i].name, info->bindings[i].binding);
    base_text_add(&device->log, "\n");
    *native = object;
    return STRATA_OK;
}

static void null_program_destroy(void *self, void *native) {
    null_device *device = self;
    null_object *object = native;
    base_text_add(&device->log, "destroy program %s\n", object->label);
    object_free(object);
}

/* No API stands behind this backend. */
static uint64_t null_handle(void *self, void *native, gpu_native_kind kind) {
    (void)self, (void)native, (void)kind;
    return 0;
}

static void *null_proc(void *self, const char *name) {
    (void)self, (void)name;
    return NULL;
}

/* ---- host access ---------------------------------------------------------------------------- */

static strata_result null_buffer_read(void *self, void *native, uint64_t offset, uint64_t size,
                                      void *data, base_error *err) {
    null_device *device = self;
    null_object *object = native;
    (void)err;
    memcpy(data, object->bytes + offset, (size_t)size);
    base_text_add(&device->log, "read %s %llu+%llu\n", object->label, (unsigned long long)offset,
                  (unsigned long long)size);
    return STRATA_OK;
}

static strata_result null_buffer_write(void *self, void *native, uint64_t offset, uint64_t size,
                                       const void *data, base_error *err) {
    null_device *device = self;
    null_object *object = native;
    (void)err;
    memcpy(object->bytes + offset, data, (size_t)size);
    base_text_add(&device->log, "write %s %llu+%llu\n", object->label, (unsigned long long)offset,
                  (unsigned long long)size);
    return STRATA_OK;
}

static strata_result null_image_read(void *self, void *native, uint32_t layer, void *texels,
                                     size_t size, base_error *err) {
    null_device *device = self;
    null_object *object = native;
    (void)err;
    memcpy(texels, object->bytes + (size_t)layer * size, size);
    base_text_add(&device->log, "read image %s layer %u\n", object->label, layer);
    return STRATA_OK;
}

static strata_result null_image_write(void *self, void *native, uint32_t layer, uint32_t x,
                                      uint32_t y, uint32_t width, uint32_t height,
                                      const void *texels, base_error *err) {
    null_device *device = self;
    null_object *object = native;
    size_t texel = gpu_format_bytes(object->format);
    const unsigned char *from = texels;
    (void)err;
    for (uint32_t row = 0; row < height; row++) {
        size_t at = ((size_t)layer * object->height + y + row) * object->width + x;
        memcpy(object->bytes + at * texel, from, width * texel);
        from += width * texel;
    }
    base_text_add(&device->log, "write image %s layer %u %u,%u %ux%u\n", object->label, layer, x, y,
                  width, height);
    return STRATA_OK;
}

/* ---- recording ------------------------------------------------------------------------------ */

static void log_accesses(base_text *log, uint32_t access, uint32_t stages) {
    const char *separator = "";
    for (size_t i = 0; i < BASE_COUNT(access_names); i++)
        if (access & access_names[i].bit) {
            base_text_add(log, "%s%s", separator, access_names[i].name);
            separator = "|";
        }
    if (stages)
        base_text_add(log, "/%s%s%s", stages & GPU_STAGE_VERTEX ? "v" : "",
                      stages & GPU_STAGE_FRAGMENT ? "f" : "",
                      stages & GPU_STAGE_COMPUTE ? "c" : "");
}

/* Ends the line: " [keys storage-write/c>storage-read/f]" for each barrier. */
static void log_barriers(base_text *log, const gpu_barrier *barriers, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const null_object *object = barriers[i].native;
        base_text_add(log, " [%s ", object->label);
        log_accesses(log, barriers[i].before, barriers[i].stages_before);
        base_text_add(log, ">");
        log_accesses(log, barriers[i].after, barriers[i].stages_after);
        base_text_add(log, "]");
    }
    base_text_add(log, "\n");
}

static void null_begin(void *self) {
    null_device *device = self;
    base_text_add(&device->log, "begin\n");
}

static void null_pass(void *self, const gpu_native_pass *native) {
    null_device *device = self;
    base_text *log = &device->log;
    const strata_pass *pass = native->pass;
    const null_object *program = native->program;
    if (native->call) {
        base_text_add(log, "pass %s native", pass->label);
        native->call(native->user, 0);
    } else {
        base_text_add(log, "pass %s program %s", pass->label, program->label);
    }
    if (native->width)
        base_text_add(log, " %ux%u scissor %u,%u %ux%u", native->width, native->height,
                      native->scissor[0], native->scissor[1], native->scissor[2],
                      native->scissor[3]);
    else if (native->indirect)
        base_text_add(log, " indirect %s", ((const null_object *)native->indirect)->label);
    else
        base_text_add(log, " groups %ux%ux%u", pass->groups[0], pass->groups[1], pass->groups[2]);
    if (native->commands)
        base_text_add(log, " draws %s", ((const null_object *)native->commands)->label);
    for (uint32_t i = 0; i < pass->color_count; i++)
        base_text_add(log, " color %s%s", pass->color[i].read ? "read " : "",
                      ((const null_object *)native->color[i])->label);
    if (native->depth)
        base_text_add(log, " depth %s", ((const null_object *)native->depth)->label);
    if (pass->sample_mask)
        base_text_add(log, " samples 0x%x", pass->sample_mask);
    for (uint32_t i = 0; i < native->bind_count; i++)
        base_text_add(log, " %s=%s", native->binds[i].binding->name,
                      ((const null_object *)native->binds[i].native)->label);
    log_barriers(log, native->barriers, native->barrier_count);
}

static void null_fill(void *self, void *buffer, uint64_t offset, uint64_t size, uint32_t value,
                      const gpu_barrier *barriers, uint32_t barrier_count) {
    null_device *device = self;
    null_object *object = buffer;
    for (uint64_t at = offset; at < offset + size; at += sizeof value)
        memcpy(object->bytes + at, &value, sizeof value);
    base_text_add(&device->log, "fill %s %llu+%llu = %u", object->label, (unsigned long long)offset,
                  (unsigned long long)size, value);
    log_barriers(&device->log, barriers, barrier_count);
}

static void null_copy(void *self, void *to, uint64_t to_offset, void *from, uint64_t from_offset,
                      uint64_t size, const gpu_barrier *barriers, uint32_t barrier_count) {
    null_device *device = self;
    null_object *target = to;
    const null_object *source = from;
    memmove(target->bytes + to_offset, source->bytes + from_offset, (size_t)size);
    base_text_add(&device->log, "copy %s %llu to %s %llu + %llu", source->label,
                  (unsigned long long)from_offset, target->label, (unsigned long long)to_offset,
                  (unsigned long long)size);
    log_barriers(&device->log, barriers, barrier_count);
}

/* One texel of the clear value; half floats are left to real devices, which read them back. */
static void make_texel(const null_object *object, const float value[4], unsigned char texel[16]) {
    uint32_t words[4];
    memcpy(words, value, sizeof words);
    for (int i = 0; i < 4; i++) {
        if (object->format == STRATA_FORMAT_R32U || object->format == STRATA_FORMAT_RG32U ||
            object->format == STRATA_FORMAT_RGBA32U ||
            (object->format == STRATA_FORMAT_D32F_S8 && i == 1))
            words[i] = value[i] > 0.0f ? (uint32_t)value[i] : 0;
        if (object->format == STRATA_FORMAT_RGBA8) {
            float unit = value[i] < 0.0f ? 0.0f : value[i] > 1.0f ? 1.0f : value[i];
            texel[i] = (unsigned char)(unit * 255.0f + 0.5f);
        }
    }
    if (object->format != STRATA_FORMAT_RGBA8)
        memcpy(texel, words, 16);
}

static void null_clear_image(void *self, void *image, const float value[4],
                             const gpu_barrier *barriers, uint32_t barrier_count) {
    null_device *device = self;
    null_object *object = image;
    unsigned char texel[16] = {0};
    size_t size = gpu_format_bytes(object->format);
    make_texel(object, value, texel);
    for (uint64_t at = 0; at + size <= object->size; at += size)
        memcpy(object->bytes + at, texel, size);
    base_text_add(&device->log, "clear %s %g %g %g %g", object->label, (double)value[0],
                  (double)value[1], (double)value[2], (double)value[3]);
    log_barriers(&device->log, barriers, barrier_count);
}

static strata_result null_submit(void *self, double *ms, uint32_t timing_count, base_error *err) {
    null_device *device = self;
    (void)err;
    for (uint32_t i = 0; i < timing_count; i++)
        ms[i] = -1.0;
    base_text_add(&device->log, "submit\n");
    return STRATA_OK;
}

const gpu_backend gpu_backend_null = {
    .name = "null",
    .open = null_open,
    .close = null_close,
    .enumerate = null_enumerate,
    .buffer_create = null_buffer_create,
    .buffer_destroy = null_buffer_destroy,
    .image_create = null_image_create,
    .image_destroy = null_image_destroy,
    .program_create = null_program_create,
    .program_destroy = null_program_destroy,
    .buffer_read = null_buffer_read,
    .buffer_write = null_buffer_write,
    .image_read = null_image_read,
    .image_write = null_image_write,
    .begin = null_begin,
    .pass = null_pass,
    .fill = null_fill,
    .copy = null_copy,
    .clear_image = null_clear_image,
    .submit = null_submit,
    .native_handle = null_handle,
    .get_proc = null_proc,
    .log = null_log,
};
