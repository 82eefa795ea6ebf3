/* SPDX-License-Identifier: MIT
 *
 * The texture atlas: every mip level of every image is a rectangle, packed onto shelves, tallest
 * first, on the layers of one array image.
 */
#include "scene/upload_internal.h"

#include <stdlib.h>
#include <string.h>

typedef struct rectangle {
    uint32_t image, level, width, height, x, y, page;
} rectangle;

typedef struct packing {
    rectangle *rectangles;
    uint32_t count, width, height, pages;
} packing;

static uint32_t level_size(uint32_t size, uint32_t level) {
    return size >> level ? size >> level : 1;
}

/* Tall before flat, wide before narrow, then in the scene's order: the packing is a function of the
 * scene alone. */
static int by_height(const void *a, const void *b) {
    const rectangle *r = a, *q = b;
    if (r->height != q->height)
        return r->height > q->height ? -1 : 1;
    if (r->width != q->width)
        return r->width > q->width ? -1 : 1;
    if (r->image != q->image)
        return r->image < q->image ? -1 : 1;
    return r->level < q->level ? -1 : r->level > q->level;
}

static strata_result list_rectangles(const scene *s, const uint32_t *levels, packing *p,
                                     base_error *err) {
    size_t count = 0;
    for (uint32_t i = 0; i < s->image_count; i++)
        count += levels[i];
    p->count = 0;
    p->rectangles = base_calloc(count ? count : 1, sizeof *p->rectangles);
    if (!p->rectangles)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for textures",
                         s->path);
    for (uint32_t i = 0; i < s->image_count; i++)
        for (uint32_t level = 0; level < levels[i]; level++)
            p->rectangles[p->count++] =
                (rectangle){.image = i,
                            .level = level,
                            .width = level_size(s->images[i].width, level),
                            .height = level_size(s->images[i].height, level)};
    qsort(p->rectangles, p->count, sizeof *p->rectangles, by_height);
    return STRATA_OK;
}

/* Width: the power of two that holds the widest and keeps one page about square. */
static strata_result pack(const scene *s, packing *p, uint32_t limit, base_error *err) {
    uint64_t area = 0;
    uint32_t widest = 1;
    for (uint32_t i = 0; i < p->count; i++) {
        const rectangle *r = &p->rectangles[i];
        area += (uint64_t)r->width * r->height;
        widest = r->width > widest ? r->width : widest;
        if (r->width > limit || r->height > limit)
            return base_fail(err, STRATA_ERROR_OVERFLOW,
                             "%s: image '%s' is %u x %u, and this device holds at most %u", s->path,
                             s->images[r->image].name, r->width, r->height, limit);
    }
    p->width = 1;
    while (p->width < limit && (p->width < widest || (uint64_t)p->width * p->width < area))
        p->width = p->width * 2 < limit ? p->width * 2 : limit;
    uint32_t x = 0, y = 0, shelf = 0, page = 0;
    for (uint32_t i = 0; i < p->count; i++) {
        rectangle *r = &p->rectangles[i];
        if (x + r->width > p->width) {
            y += shelf;
            x = shelf = 0;
        }
        if (y + r->height > limit) {
            page++;
            x = y = shelf = 0;
        }
        *r = (rectangle){r->image, r->level, r->width, r->height, x, y, page};
        x += r->width;
        shelf = shelf > r->height ? shelf : r->height;
        p->height = p->height > y + r->height ? p->height : y + r->height;
    }
    p->pages = page + 1;
    return STRATA_OK;
}

static strata_result place_texels(const scene *s, const packing *p, const uint32_t *levels,
                                  uint32_t *first_level, upload_texel **texels,
                                  uint32_t *texel_count, base_error *err) {
    uint32_t base = *texel_count;
    upload_texel *grown = base_realloc(*texels, (size_t)base + p->count, sizeof *grown);
    if (!grown)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for textures",
                         s->path);
    *texels = grown;
    *texel_count = base + p->count;
    for (uint32_t i = 0; i < s->image_count; i++) {
        first_level[i] = base;
        base += levels[i];
    }
    for (uint32_t i = 0; i < p->count; i++) {
        const rectangle *r = &p->rectangles[i];
        grown[first_level[r->image] + r->level] = (upload_texel){r->x | r->y << 16, r->page};
    }
    return STRATA_OK;
}

/* Writes all levels of one image; each is filtered from the one before. */
static strata_result write_image(gpu *g, strata_image atlas, const scene_image *image,
                                 uint32_t levels, const upload_texel *places, int colour,
                                 base_error *err) {
    uint32_t width = image->width, height = image->height;
    const unsigned char *pixels = image->pixels;
    unsigned char *buffers[2] = {NULL, NULL};
    size_t half = (size_t)level_size(width, 1) * level_size(height, 1);
    strata_result result = STRATA_OK;
    for (int i = 0; i < 2 && levels > 1; i++) {
        buffers[i] = base_calloc(half, 4);
        if (!buffers[i])
            result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY,
                               "no memory to filter image '%s'", image->name);
    }
    for (uint32_t level = 0; level < levels && result == STRATA_OK; level++) {
        if (level > 0) {
            upload_next_level(pixels, width, height, colour, buffers[level & 1]);
            pixels = buffers[level & 1];
            width = level_size(width, 1);
            height = level_size(height, 1);
        }
        result = gpu_image_write(g, atlas, places[level].page, places[level].corner & 0xffffu,
                                 places[level].corner >> 16, width, height, pixels, err);
    }
    free(buffers[0]);
    free(buffers[1]);
    return result;
}

strata_result upload_atlas(gpu_scope *scope, gpu *g, const scene *s, const uint32_t *levels,
                           int colour, uint32_t *first_level, upload_texel **texels,
                           uint32_t *texel_count, strata_image *out, base_error *err) {
    uint64_t limit = gpu_fact(g, "limit.image_size");
    if (limit == 0 || limit > 16384)
        limit = 16384; /* places have 16 bits for each of x and y */
    packing p = {0};
    strata_result result = list_rectangles(s, levels, &p, err);
    if (result == STRATA_OK && p.count == 0)
        goto done;
    if (result == STRATA_OK)
        result = pack(s, &p, (uint32_t)limit, err);
    if (result == STRATA_OK)
        result = place_texels(s, &p, levels, first_level, texels, texel_count, err);
    strata_image_desc desc = {.struct_size = sizeof desc,
                              .format = colour ? STRATA_FORMAT_RGBA8_SRGB : STRATA_FORMAT_RGBA8,
                              .label = colour ? "colour textures" : "data textures",
                              .width = p.width,
                              .height = p.height,
                              .layers = p.pages};
    if (result == STRATA_OK)
        result = gpu_image_create(scope, &desc, out, err);
    for (uint32_t i = 0; i < s->image_count && result == STRATA_OK; i++)
        if (levels[i])
            result = write_image(g, *out, &s->images[i], levels[i], *texels + first_level[i],
                                 colour, err);
done:
    free(p.rectangles);
    return result;
}
