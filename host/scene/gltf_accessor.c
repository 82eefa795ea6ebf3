/* SPDX-License-Identifier: MIT
 *
 * glTF accessors as plain arrays: any component type, normalised or not, interleaved or packed,
 * absent views as zeros, sparse values put in. No element is read before its bytes are known to lie
 * in their buffer.
 */
#include "scene/gltf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_ZEROS (1u << 24) /* elements of an accessor that no bytes stand behind */

static uint32_t component_size(gltf_component component) {
    switch (component) {
    case GLTF_I8:
    case GLTF_U8:
        return 1;
    case GLTF_I16:
    case GLTF_U16:
        return 2;
    default:
        return 4;
    }
}

static uint32_t load_u16(const unsigned char *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}

static uint32_t load_u32(const unsigned char *at) {
    return load_u16(at) | load_u16(at + 2) << 16;
}

static float signed_unit(int value, float largest, uint32_t normalized) {
    float v = (float)value;
    if (!normalized)
        return v;
    return v / largest < -1.0f ? -1.0f : v / largest;
}

static float load_float(const unsigned char *at, gltf_component component, uint32_t normalized) {
    switch (component) {
    case GLTF_I8:
        return signed_unit((signed char)at[0], 127.0f, normalized);
    case GLTF_U8:
        return normalized ? (float)at[0] / 255.0f : (float)at[0];
    case GLTF_I16:
        return signed_unit((int16_t)load_u16(at), 32767.0f, normalized);
    case GLTF_U16:
        return normalized ? (float)load_u16(at) / 65535.0f : (float)load_u16(at);
    case GLTF_U32:
        return normalized ? (float)((double)load_u32(at) / 4294967295.0) : (float)load_u32(at);
    default: {
        uint32_t bits = load_u32(at);
        float value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    }
}

static uint32_t load_integer(const unsigned char *at, gltf_component component) {
    uint32_t size = component_size(component);
    return size == 1 ? at[0] : size == 2 ? load_u16(at) : load_u32(at);
}

/* Where the elements of an accessor stand: base + i * stride, components at `steps`. Columns of
 * matrices with small components begin at multiples of four bytes. */
typedef struct layout {
    const unsigned char *base; /* NULL: all zero */
    uint64_t stride;
    uint32_t size;      /* bytes from the first to the end of the last component */
    uint32_t steps[16]; /* byte offset of each component in its element */
} layout;

static void component_steps(const gltf_accessor *a, layout *out) {
    uint32_t bytes = component_size(a->component), rows = a->width / a->columns;
    uint32_t column = a->columns > 1 ? (rows * bytes + 3u) & ~3u : rows * bytes;
    for (uint32_t i = 0; i < a->width; i++)
        out->steps[i] = i / rows * column + i % rows * bytes;
    out->size = out->steps[a->width - 1] + bytes;
    out->stride = (uint64_t)column * a->columns;
}

/* Checks that `count` elements fit into a view from `offset` on. */
static strata_result locate(gltf_loader *l, const char *place, uint32_t view, uint64_t offset,
                            uint64_t count, layout *out) {
    uint64_t size;
    strata_result result = gltf_view_bytes(l, view, place, &out->base, &size);
    if (result != STRATA_OK || count == 0)
        return result;
    uint64_t span; /* to the end of the last element */
    if (__builtin_mul_overflow(count - 1, out->stride, &span) ||
        __builtin_add_overflow(span, out->size, &span) ||
        __builtin_add_overflow(span, offset, &span) || span > size)
        return base_fail(
            l->err, STRATA_ERROR_BAD_FILE,
            "%s: %s: %llu elements from byte %llu on do not fit into the %llu bytes of "
            "bufferViews[%u]",
            l->s->path, place, (unsigned long long)count, (unsigned long long)offset,
            (unsigned long long)size, view);
    out->base += offset;
    return STRATA_OK;
}

static strata_result main_layout(gltf_loader *l, const gltf_accessor *a, const char *place,
                                 layout *out) {
    *out = (layout){0};
    component_steps(a, out);
    if (a->view == SCENE_NONE)
        return a->count <= MAX_ZEROS
                   ? STRATA_OK
                   : base_fail(l->err, STRATA_ERROR_BAD_FILE,
                               "%s: %s: has no bufferView and %llu elements, more than %u",
                               l->s->path, place, (unsigned long long)a->count, MAX_ZEROS);
    uint32_t stride = l->file.views[a->view].stride;
    if (stride != 0 && stride < out->size)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: %s: bufferViews[%u].byteStride is %u, an element has %u bytes",
                         l->s->path, place, a->view, stride, out->size);
    if (stride != 0)
        out->stride = stride;
    return locate(l, place, a->view, a->offset, a->count, out);
}

/* Floats that already stand in memory as they are wanted. */
static int is_plain(const gltf_accessor *a, const layout *from) {
    return __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ && a->component == GLTF_F32 && from->base &&
           from->stride == a->width * sizeof(float);
}

/* Converts `count` elements; exactly one of floats and integers is given. */
static void convert(const gltf_accessor *a, const layout *from, uint64_t count, float *floats,
                    uint32_t *integers) {
    if (floats && is_plain(a, from)) {
        memcpy(floats, from->base, (size_t)count * a->width * sizeof *floats);
        return;
    }
    for (uint64_t i = 0; i < count && from->base; i++) {
        const unsigned char *element = from->base + i * from->stride;
        for (uint32_t c = 0; c < a->width; c++) {
            const unsigned char *at = element + from->steps[c];
            if (floats)
                floats[i * a->width + c] = load_float(at, a->component, a->normalized);
            else
                integers[i * a->width + c] = load_integer(at, a->component);
        }
    }
}

static strata_result apply_sparse(gltf_loader *l, const gltf_accessor *a, const char *place,
                                  float *floats, uint32_t *integers) {
    layout index = {.stride = component_size(a->sparse_index_component),
                    .size = component_size(a->sparse_index_component)};
    layout value = {0};
    strata_result result;
    component_steps(a, &value);
    if (a->sparse_count > a->count)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: sparse.count is %llu of %llu",
                         l->s->path, place, (unsigned long long)a->sparse_count,
                         (unsigned long long)a->count);
    result =
        locate(l, place, a->sparse_index_view, a->sparse_index_offset, a->sparse_count, &index);
    if (result == STRATA_OK)
        result =
            locate(l, place, a->sparse_value_view, a->sparse_value_offset, a->sparse_count, &value);
    for (uint64_t i = 0; i < a->sparse_count && result == STRATA_OK; i++) {
        uint32_t at = load_integer(index.base + i * index.stride, a->sparse_index_component);
        if (at >= a->count)
            return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                             "%s: %s: sparse.indices[%llu] is %u of %llu elements", l->s->path,
                             place, (unsigned long long)i, at, (unsigned long long)a->count);
        layout one = value;
        one.base += i * value.stride;
        convert(a, &one, 1, floats ? floats + (size_t)at * a->width : NULL,
                integers ? integers + (size_t)at * a->width : NULL);
    }
    return result;
}

/* The common part: checks, allocation, conversion. */
static strata_result read_accessor(gltf_loader *l, uint32_t index, uint32_t width,
                                   const char *where, int integers, void **out, uint32_t *count) {
    const gltf_accessor *a = &l->file.accessors[index];
    char place[160];
    layout from;
    snprintf(place, sizeof place, "%s: accessors[%u]", where, index);
    *out = NULL;
    *count = 0;
    if (a->width != width)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: has %u components, %u are needed",
                         l->s->path, place, a->width, width);
    if (integers &&
        (a->component == GLTF_F32 || a->component == GLTF_I8 || a->component == GLTF_I16))
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: %s: componentType %d is not an unsigned integer", l->s->path, place,
                         (int)a->component);
    if (a->count >= UINT32_MAX)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: has %llu elements, 2^32 or more",
                         l->s->path, place, (unsigned long long)a->count);
    strata_result result = main_layout(l, a, place, &from);
    if (result == STRATA_OK)
        result = gltf_charge(l, place, a->count, (uint64_t)width * sizeof(float));
    if (result != STRATA_OK)
        return result;
    void *data = base_calloc((size_t)a->count, width * sizeof(float));
    if (!data)
        return gltf_no_memory(l);
    convert(a, &from, a->count, integers ? NULL : data, integers ? data : NULL);
    if (a->sparse_count > 0)
        result = apply_sparse(l, a, place, integers ? NULL : data, integers ? data : NULL);
    if (result != STRATA_OK) {
        free(data);
        return result;
    }
    *out = data;
    *count = (uint32_t)a->count;
    return STRATA_OK;
}

strata_result gltf_read_floats(gltf_loader *l, uint32_t accessor, uint32_t width, const char *place,
                               float **out, uint32_t *count) {
    void *data;
    strata_result result = read_accessor(l, accessor, width, place, 0, &data, count);
    *out = data;
    return result;
}

strata_result gltf_read_integers(gltf_loader *l, uint32_t accessor, uint32_t width,
                                 const char *place, uint32_t **out, uint32_t *count) {
    void *data;
    strata_result result = read_accessor(l, accessor, width, place, 1, &data, count);
    *out = data;
    return result;
}
