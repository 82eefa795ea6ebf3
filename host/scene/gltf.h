/* SPDX-License-Identifier: MIT
 *
 * The private face of the glTF loader: a flat view of one parsed file, and the steps from it to a
 * scene. check (JSON against the rules) -> parse (tinygltf, the only C++) -> buffers, accessors,
 * materials, meshes, nodes, animations. After gltf_check every index in the view is in range.
 */
#ifndef STRATA_HOST_SCENE_GLTF_H
#define STRATA_HOST_SCENE_GLTF_H

#include "scene/animations.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Indices are SCENE_NONE where absent. Pointers into the view live until gltf_parse_free. */
typedef struct gltf_buffer {
    const char *uri;            /* NULL: the GLB's binary chunk */
    uint64_t length;            /* byteLength as declared */
    const unsigned char *bytes; /* `length` of them, once gltf_read_buffers ran */
    unsigned char *owned;       /* bytes, when they are not part of the file in memory */
} gltf_buffer;

typedef struct gltf_image {
    const char *name, *uri, *mime; /* each may be NULL */
    uint32_t view;
} gltf_image;

typedef struct gltf_view {
    uint32_t buffer;
    uint64_t offset, length;
    uint32_t stride; /* 0: tightly packed */
} gltf_view;

typedef enum gltf_component {
    GLTF_I8 = 5120,
    GLTF_U8 = 5121,
    GLTF_I16 = 5122,
    GLTF_U16 = 5123,
    GLTF_U32 = 5125,
    GLTF_F32 = 5126
} gltf_component;

typedef struct gltf_accessor {
    uint32_t view; /* SCENE_NONE: zeros */
    uint64_t offset, count;
    gltf_component component;
    uint32_t width, columns; /* components of an element; columns > 1 of a matrix */
    uint32_t normalized;
    uint64_t sparse_count; /* 0: not sparse */
    uint32_t sparse_index_view, sparse_value_view;
    uint64_t sparse_index_offset, sparse_value_offset;
    gltf_component sparse_index_component;
} gltf_accessor;

typedef struct gltf_attribute {
    const char *name; /* "POSITION", "_RADIUS", "TRANSLATION" ... */
    uint32_t accessor;
} gltf_attribute;

typedef struct gltf_attributes {
    const gltf_attribute *items;
    uint32_t count;
} gltf_attributes;

typedef struct gltf_primitive {
    gltf_attributes attributes;
    const gltf_attributes *targets;
    uint32_t target_count, material, indices, mode;
} gltf_primitive;

typedef struct gltf_mesh {
    const char *name;
    const gltf_primitive *primitives;
    uint32_t primitive_count, weight_count;
    const double *weights;
} gltf_mesh;

typedef struct gltf_node {
    const char *name;
    const int *children;
    uint32_t child_count, mesh, skin, camera, light;
    const double *matrix;                         /* 16, or NULL: the three below hold */
    double translation[3], rotation[4], scale[3]; /* rotation: quaternion x y z w */
    const double *weights;
    uint32_t weight_count;
    gltf_attributes instancing; /* EXT_mesh_gpu_instancing; count 0: absent */
} gltf_node;

typedef struct gltf_texture_use {
    uint32_t texture, uv;
    double offset[2], rotation, scale[2]; /* KHR_texture_transform */
} gltf_texture_use;

typedef struct gltf_material {
    scene_material values; /* factors and flags; its textures are still absent, name is NULL */
    const char *name;
    gltf_texture_use base_color, metallic_roughness, normal, occlusion, emissive, transmission;
} gltf_material;

typedef struct gltf_texture {
    uint32_t sampler, image;
} gltf_texture;

typedef struct gltf_sampler {
    int magnify, minify, wrap_s, wrap_t; /* GL's enumerants, -1 = not given */
} gltf_sampler;

typedef enum gltf_path { GLTF_TRANSLATION, GLTF_ROTATION, GLTF_SCALE, GLTF_WEIGHTS } gltf_path;
typedef enum gltf_interpolation { GLTF_LINEAR, GLTF_STEP, GLTF_CUBIC } gltf_interpolation;

typedef struct gltf_channel {
    uint32_t animation, channel; /* where it stands in the file, for messages */
    uint32_t node, input, output;
    gltf_path path;
    gltf_interpolation interpolation;
} gltf_channel;

typedef struct gltf_skin {
    const int *joints;
    uint32_t joint_count, inverse_bind; /* an accessor */
} gltf_skin;

typedef struct gltf_scene_list {
    const int *nodes;
    uint32_t count;
} gltf_scene_list;

/* NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): one of it, and it reads better so */
typedef struct gltf_file {
    gltf_buffer *buffers;
    uint32_t buffer_count;
    const gltf_image *images;
    uint32_t image_count;
    const gltf_view *views;
    uint32_t view_count;
    const gltf_accessor *accessors;
    uint32_t accessor_count;
    const gltf_mesh *meshes;
    uint32_t mesh_count;
    const gltf_node *nodes;
    uint32_t node_count;
    const gltf_material *materials;
    uint32_t material_count;
    const gltf_texture *textures;
    uint32_t texture_count;
    const gltf_sampler *samplers;
    uint32_t sampler_count;
    const gltf_channel *channels;
    uint32_t channel_count; /* of all animations, in order */
    const gltf_skin *skins;
    uint32_t skin_count;
    const scene_camera *cameras;
    uint32_t camera_count; /* name belongs to the view */
    const scene_light *lights;
    uint32_t light_count; /* likewise */
    const gltf_scene_list *scenes;
    uint32_t scene_count;
    uint32_t scene; /* the default one, or SCENE_NONE */
    void *owner;    /* of everything above but buffers and images */
} gltf_file;

/* The attribute under which a primitive's indices reach gltf_parse. */
#define GLTF_INDICES "#indices"

/* gltf_parse.cpp: the checked JSON through tinygltf into the view; buffers and images excepted.
 * Nothing is thrown. On success *file holds an owner, to be released by gltf_parse_free. */
strata_result gltf_parse(const char *name, const char *text, size_t size, gltf_file *file,
                         base_error *err);
void gltf_parse_free(gltf_file *file);

/* ---- everything below is C ---------------------------------------------------------------------
 */

/* The checked JSON, what it was before tinygltf and C take from it. */
typedef struct gltf_document {
    struct json_t *root; /* owns the strings of buffers and images */
    char *text;          /* for gltf_parse: known members only, without buffers and images */
    size_t text_size;
    gltf_buffer *buffers;
    gltf_image *images;
    uint32_t buffer_count, image_count;
} gltf_document;

/* Parses JSON text and holds every member that the loader reads against the rules: types, ranges,
 * choices, indices against what exists, extensions. Members that nothing reads are dropped.
 * Warnings go to s. On failure nothing is left allocated. */
strata_result gltf_check(scene *s, const char *json, size_t size, gltf_document *document,
                         base_error *err);
void gltf_document_free(gltf_document *document);

/* One load: what the steps share. */
typedef struct gltf_loader {
    scene *s;
    gltf_file file;
    const char *folder;          /* external files lie in it; NULL: there may be none */
    const unsigned char *binary; /* the GLB's chunk, or NULL */
    size_t binary_size;
    uint64_t bytes_left, image_bytes_left; /* what geometry and images may still take */
    size_t mesh_capacity, instance_capacity, material_capacity;
    scene_animations *animations; /* the hierarchy at least; becomes the scene's when it moves */
    size_t *mesh_first;           /* glTF mesh -> its first primitive in mesh_map */
    uint32_t *mesh_map;           /* glTF primitive, while rigid -> scene mesh */
    uint32_t *image_map;          /* glTF image -> scene image, SCENE_NONE: not decoded yet */
    unsigned char *image_bad;     /* glTF image: a warning was given */
    base_error *err;
} gltf_loader;

#define GLTF_MAX_FILE ((size_t)4 << 30) /* bytes of one file */

/* Geometry may take 256 MiB and 200 times the bytes of all files read: far more than honest files
 * unfold to, and a bound on what dishonest ones cost. gltf_allow adds a file. */
void gltf_allow(gltf_loader *l, size_t file_size);
/* Takes count * size from what may still be allocated; fails naming `place` when it is not there.
 */
strata_result gltf_charge(gltf_loader *l, const char *place, uint64_t count, uint64_t size);
strata_result gltf_no_memory(gltf_loader *l);

/* gltf_buffer.c */
strata_result gltf_read_buffers(gltf_loader *l);
/* A URI's bytes (data: or a file in the folder), malloc'd; the error's text lacks file and place.
 */
strata_result gltf_read_uri(const gltf_loader *l, const char *uri, size_t limit,
                            unsigned char **bytes, size_t *size, base_error *err);
/* The bytes of a view; fails naming `place` when it leaves its buffer. */
strata_result gltf_view_bytes(gltf_loader *l, uint32_t view, const char *place,
                              const unsigned char **bytes, uint64_t *size);

/* gltf_accessor.c: elements converted to float or uint32, sparse values applied. *out is malloc'd
 * and charged: [count][width]. `place` says who asks, for messages. */
strata_result gltf_read_floats(gltf_loader *l, uint32_t accessor, uint32_t width, const char *place,
                               float **out, uint32_t *count);
strata_result gltf_read_integers(gltf_loader *l, uint32_t accessor, uint32_t width,
                                 const char *place, uint32_t **out, uint32_t *count);

/* gltf_material.c */
strata_result gltf_read_materials(gltf_loader *l);

/* gltf_mesh.c: the accessor of a named attribute, or SCENE_NONE. */
uint32_t gltf_find(const gltf_attributes *attributes, const char *name);
/* A named attribute as floats, one element a vertex; *out is NULL when it is absent. */
strata_result gltf_read_attribute(gltf_loader *l, const gltf_attributes *attributes,
                                  const char *name, uint32_t width, uint32_t vertices,
                                  const char *place, float **out);
/* Replaces what is not finite by 0, with a warning. values may be NULL. */
void gltf_mend(gltf_loader *l, float *values, size_t count, const char *place, const char *name);

/* gltf_deform.c: fills mesh->deform, skin and node when a skin or targets deform the primitive. */
strata_result gltf_read_deform(gltf_loader *l, const gltf_primitive *p, uint32_t skin,
                               uint32_t node, const char *place, scene_mesh *mesh);

/* One primitive of a mesh as a new scene mesh; *out is its index, SCENE_NONE when there
 * is nothing to draw (lines). skin: SCENE_NONE or the glTF skin that deforms it. */
strata_result gltf_read_primitive(gltf_loader *l, uint32_t mesh, uint32_t primitive, uint32_t skin,
                                  uint32_t node, uint32_t *out);

/* gltf_node.c: hierarchy, instances, lights and cameras of the default scene. */
strata_result gltf_read_nodes(gltf_loader *l);

/* gltf_animation.c: channels and skins; needs the nodes. */
strata_result gltf_read_animations(gltf_loader *l);

#ifdef __cplusplus
}
#endif
#endif
