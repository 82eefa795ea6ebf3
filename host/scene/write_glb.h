/* SPDX-License-Identifier: MIT
 *
 * A GLB file in the making: lists of JSON objects that grow side by side and pieces of memory that
 * become the binary chunk. Shared by write_glb.c (container, meshes, materials) and
 * write_glb_nodes.c (instances, cameras, lights). Private to host/scene.
 */
#ifndef STRATA_HOST_SCENE_WRITE_GLB_H
#define STRATA_HOST_SCENE_WRITE_GLB_H

#include "scene/scene.h"

enum {
    GLB_UNLIT = 1,
    GLB_TRANSMISSION = 2,
    GLB_IOR = 4,
    GLB_EMISSIVE_STRENGTH = 8,
    GLB_TEXTURE_TRANSFORM = 16,
    GLB_LIGHTS = 32,
    GLB_INSTANCING = 64
};

/* The elements of one of glTF's top-level arrays, comma-separated. */
typedef struct glb_list {
    base_text text;
    uint32_t count;
} glb_list;

typedef struct glb_piece {
    const void *data;
    void *owned; /* freed with the writer; NULL for memory of the scene */
    size_t size;
} glb_piece;

typedef struct glb_writer {
    const scene *s;
    glb_list views, accessors, meshes, nodes, images, samplers, textures, materials, lights,
        cameras;
    glb_piece *pieces;
    size_t piece_count, piece_capacity;
    uint64_t length;       /* of the binary chunk so far, a multiple of 4 */
    uint32_t *mesh_number; /* of each scene mesh in the file; SCENE_NONE: empty, left out */
    unsigned extensions;
    int failed; /* out of memory */
} glb_writer;

/* Begins element number `list->count - 1`; the caller writes the rest of the object to the text. */
base_text *glb_begin(glb_list *list);
/* A number that reads back to the same float, whatever the locale. */
void glb_number(base_text *text, double value);
/* `,"key":[...]` */
void glb_numbers(base_text *text, const char *key, const float *values, uint32_t count);
/* A JSON string with its quotes. */
void glb_string(base_text *text, const char *string);

/* Appends bytes to the binary chunk; returns the accessor for `count` elements of `width` floats.
 * Takes over `owned`, which may be NULL. */
uint32_t glb_floats(glb_writer *w, const float *values, float *owned, uint32_t count,
                    uint32_t width);

void glb_write_instances(glb_writer *w);
void glb_write_cameras(glb_writer *w);
void glb_write_lights(glb_writer *w);

#endif
