/* SPDX-License-Identifier: MIT
 *
 * What the parts of upload share: the structs that shaders/strata/{scene,texture,lighting}.glsl
 * mirror (std430), the state of an upload, and the steps. Private to host/scene/upload*.c.
 */
#ifndef STRATA_HOST_UPLOAD_INTERNAL_H
#define STRATA_HOST_UPLOAD_INTERNAL_H

#include "scene/upload.h"

/* ---- as the shaders see it ------------------------------------------------------------------- */

#define UPLOAD_MIRRORED     1u
#define UPLOAD_UNLIT        2u
#define UPLOAD_SPLATS       4u
#define UPLOAD_NORMALS      8u
#define UPLOAD_TANGENTS     16u
#define UPLOAD_UV0          32u
#define UPLOAD_UV1          64u
#define UPLOAD_COLORS       128u
#define UPLOAD_RADII        256u
#define UPLOAD_DOUBLE_SIDED 512u
#define UPLOAD_MASK         1024u
#define UPLOAD_BLEND        2048u

/* Vertex streams, in the order of upload_record.first. */
typedef enum upload_stream {
    UPLOAD_POSITION,
    UPLOAD_NORMAL,
    UPLOAD_TANGENT,
    UPLOAD_STREAM_UV0,
    UPLOAD_STREAM_UV1,
    UPLOAD_COLOR,
    UPLOAD_RADIUS,
    UPLOAD_STREAMS
} upload_stream;

typedef struct upload_record {
    float world[3][4]; /* rows */
    uint32_t material, primitive_base, primitive_map, flags;
    uint32_t first[UPLOAD_STREAMS];
    float scale;
} upload_record;
_Static_assert(sizeof(upload_record) == 96, "StrataRecord");

typedef struct upload_material {
    float base_color[4], emissive[4]; /* emissive[3]: alpha cutoff */
    float metallic, roughness, normal_scale, occlusion_strength, f0, transmission;
    uint32_t base_color_texture, metallic_roughness_texture, normal_texture, occlusion_texture,
        emissive_texture, transmission_texture;
} upload_material;
_Static_assert(sizeof(upload_material) == 80, "StrataMaterial");

typedef struct upload_texture {
    float scale_rotate[4], offset[2];
    uint32_t size, flags, levels, first_level, reserved[2];
} upload_texture;
_Static_assert(sizeof(upload_texture) == 48, "StrataTexture");

typedef struct upload_texel { /* where a mip level stands in the atlas */
    uint32_t corner, page;    /* x | y << 16 */
} upload_texel;

typedef struct upload_light {
    float position[4], direction[4], color[4], cone[4];
} upload_light;
_Static_assert(sizeof(upload_light) == 64, "StrataLight");

typedef struct upload_command { /* VkDrawIndexedIndirectCommand */
    uint32_t index_count, instance_count, first_index;
    int32_t vertex_offset;
    uint32_t first_instance;
} upload_command;
_Static_assert(sizeof(upload_command) == 20, "tightly packed");

#define UPLOAD_OBJECT_TRANSPARENT 1u /* in draws.transparent/1 */
#define UPLOAD_OBJECT_UNBOUNDED   2u /* its bounds are not known: splats */
#define UPLOAD_OBJECT_NEXT        4u /* the next instance of what the object before it draws */
#define UPLOAD_OBJECT_CONTINUES   8u /* its indices follow those of the object before it */

typedef struct upload_object {
    float lower[3];
    uint32_t flags;
    float upper[3];
    uint32_t first_index, index_count, clusters, reserved[2];
} upload_object;
_Static_assert(sizeof(upload_object) == 48, "StrataObject");

/* ---- state ----------------------------------------------------------------------------------- */

/* A run of a mesh's triangles as submitted: what is one object where objects are asked for. */
typedef struct upload_cluster {
    uint32_t first_index, index_count; /* in the indices of all meshes */
    float lower[3], upper[3];          /* object space */
} upload_cluster;

typedef struct upload_mesh {
    uint32_t used;                     /* an instance of it exists and it has indices */
    uint32_t transparent;              /* which list */
    uint32_t flags;                    /* of its records, without MIRRORED */
    uint32_t first_index, index_count; /* as submitted: six for each point */
    uint32_t primitive_map;
    uint32_t first_cluster, cluster_count; /* at least one when used */
    uint32_t first[UPLOAD_STREAMS];
} upload_mesh;

typedef struct upload_list {
    gpu_scope *scope; /* of commands and draws; ends when their number changes */
    strata_buffer commands;
    strata_draws draws;
    upload_command *host; /* as on the device */
    uint32_t count, capacity;
    uint64_t triangles;
} upload_list;

struct upload {
    gpu *g;
    gpu_scope *scope;
    uint32_t shuffle_seed;
    upload_mesh *meshes; /* one for each of the scene's */
    uint32_t mesh_count, instance_count;
    strata_buffer streams[UPLOAD_STREAMS], indices, records, lights;
    uint32_t *order; /* instances in the order of submission */
    uint32_t wants_objects;
    upload_cluster *clusters; /* of all meshes */
    uint32_t cluster_count;
    upload_record *record; /* host copies, one for each cluster of each visible instance */
    upload_object *object; /* NULL unless wanted */
    uint32_t record_count, record_capacity;
    strata_buffer objects, states;
    upload_list lists[2]; /* opaque, transparent */
    uint32_t material_count, texture_count, light_count;
    uint32_t key_light; /* 1: the one light is ours */
};

/* ---- steps; each leaves what it made in u, also when it fails -------------------------------- */

/* upload_geometry.c: flags, layout and contents of streams and indices. */
strata_result upload_geometry(upload *u, const scene *s, const unsigned char *transparent,
                              base_error *err);
strata_result upload_deformed(upload *u, const scene *s, base_error *err);

/* upload_objects.c: cuts meshes into clusters, once layouts know which are used: their number, then
 * in which order the triangles of a mesh are submitted (order[i]: number in the mesh, permuted
 * already or 0, 1, ..), then their bounds. */
strata_result upload_clusters(upload *u, const scene *s, base_error *err);
strata_result upload_cluster_order(const scene_mesh *mesh, const upload_mesh *layout,
                                   uint32_t *order, base_error *err);
void upload_cluster_bounds(upload *u, const scene_mesh *mesh, const upload_mesh *layout,
                           const uint32_t *indices);
upload_object upload_make_object(const upload *u, const scene_mesh *mesh, const upload_mesh *layout,
                                 uint32_t cluster);

/* upload_draws.c: records and commands, made or brought up to date. */
strata_result upload_records(upload *u, const scene *s, base_error *err);
void upload_draws_free(upload *u);

/* upload_material.c: materials, textures, atlas; sets the texture features' defines. A material
 * that is not drawn as transparent transmits nothing. */
strata_result upload_materials(upload *u, const scene *s, const unsigned char *transparent,
                               base_error *err);
/* Textures of a material, by slot; colour says whether the slot holds sRGB colours. */
#define UPLOAD_SLOTS 6
const scene_texture *upload_slot(const scene_material *m, uint32_t slot, int *colour);

/* upload_light.c */
strata_result upload_lights(upload *u, const scene *s, base_error *err);

/* upload_atlas.c: packs images (with all mip levels where levels[i] > 1; 0 = not in this atlas) and
 * fills first_level[i] (an index into *texels, which grows). out is zero when there is none. */
strata_result upload_atlas(gpu_scope *scope, gpu *g, const scene *s, const uint32_t *levels,
                           int colour, uint32_t *first_level, upload_texel **texels,
                           uint32_t *texel_count, strata_image *out, base_error *err);
/* upload_mips.c: the next level of an image, box filtered in linear light, weighted by alpha when
 * colour. to holds max(1, width / 2) * max(1, height / 2) * 4 bytes. */
void upload_next_level(const unsigned char *from, uint32_t width, uint32_t height, int colour,
                       unsigned char *to);

/* upload.c: 0 .. count - 1, permuted unless seed is 0; NULL when out of memory. */
uint32_t *upload_permutation(uint32_t count, uint64_t seed);
/* upload.c: a storage buffer under a global name; size 0 makes none. */
strata_result upload_buffer(upload *u, const char *name, const char *label, const void *data,
                            uint64_t size, strata_buffer *out, base_error *err);
strata_result upload_image(upload *u, const char *name, strata_image image, base_error *err);
strata_result upload_define(upload *u, const char *name, int wanted, base_error *err);

#endif
