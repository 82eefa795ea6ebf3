/* SPDX-License-Identifier: MIT
 *
 * The scene model on the CPU: meshes, instances, materials, textures, lights and cameras, as read
 * from glTF or generated. First noun of scene -> demand -> plan -> frame -> fragments -> image.
 * Read-only once loaded, apart from the edits at the end. The GPU copy is made by upload.h.
 *
 * Units: lengths in scene units (glTF: metres), angles in radians, colours linear Rec. 709, light
 * intensities in candela (point, spot) or lux (directional). Matrices are column-major, 16 floats,
 * column vectors.
 */
#ifndef STRATA_HOST_SCENE_H
#define STRATA_HOST_SCENE_H

#include "base/base.h"

#define SCENE_NONE UINT32_MAX

typedef enum scene_topology { SCENE_TRIANGLES, SCENE_POINTS } scene_topology;

/* Joint indices are into the skin's joint list and checked against it; weights are normalised. */
typedef struct scene_deform {
    uint32_t influences;  /* joints per vertex: 0, 4 or 8 */
    uint16_t *joints;     /* [vertex_count][influences] */
    float *weights;       /* [vertex_count][influences] */
    uint32_t target_count;
    float *target_positions; /* [target_count][vertex_count][3] displacements, or NULL */
    float *target_normals;   /* same shape, or NULL */
    float *target_tangents;  /* same shape (xyz only), or NULL */
    float *rest_positions, *rest_normals, *rest_tangents; /* undeformed copies; NULL where absent */
} scene_deform;

/* One glTF primitive as indexed triangles (strips and fans are expanded) or as points. A mesh whose
 * deformation differs between instances (skins, morph weights of a node) is one mesh per node. */
typedef struct scene_mesh {
    char *name; /* "MESH/PRIMITIVE" for messages; never NULL */
    scene_topology topology;
    uint32_t material; /* index into scene.materials, always valid (a default one is appended) */
    uint32_t vertex_count, index_count;
    float *positions; /* [vertex_count][3], finite */
    float *normals;   /* [vertex_count][3] unit length; flat ones are generated when absent; points: NULL */
    float *tangents;  /* [vertex_count][4], w = +-1, or NULL (the shader derives them) */
    float *uv0, *uv1; /* [vertex_count][2] or NULL */
    float *colors;    /* [vertex_count][4] linear, straight alpha, or NULL */
    float *radii;     /* points: [vertex_count] splat radius in object units (_RADIUS), or NULL */
    uint32_t *indices; /* [index_count], each < vertex_count; triangles: index_count % 3 == 0 */
    float lower[3], upper[3]; /* object-space bounds of the (deformed) positions and radii */
    scene_deform *deform;     /* NULL for a rigid mesh */
    uint32_t skin;            /* index into the loader's skins, or SCENE_NONE */
    uint32_t node;            /* node whose weights and skin deform this mesh, or SCENE_NONE */
} scene_mesh;

typedef struct scene_instance {
    uint32_t mesh;
    uint32_t node;            /* node of the hierarchy that moves it, or SCENE_NONE */
    float world[16];          /* object to world, finite; a skinned mesh has the identity */
    float local[16];          /* node to instance (EXT_mesh_gpu_instancing), identity otherwise */
    uint32_t primitive_base;  /* number of this instance's first primitive in the whole scene */
    uint32_t visible;         /* 0 or 1 */
} scene_instance;

typedef enum scene_filter { SCENE_NEAREST, SCENE_LINEAR } scene_filter;
typedef enum scene_mipmap { SCENE_MIP_NONE, SCENE_MIP_NEAREST, SCENE_MIP_LINEAR } scene_mipmap;
typedef enum scene_wrap { SCENE_REPEAT, SCENE_MIRROR, SCENE_CLAMP } scene_wrap;

typedef struct scene_image { /* 8-bit RGBA, straight alpha, first row = v 0 (glTF's top) */
    char *name;
    uint32_t width, height; /* 1..16384 */
    unsigned char *pixels;  /* [height][width][4] */
} scene_image;

/* A texture as one material slot uses it. image == SCENE_NONE: absent (white, or a flat normal). */
typedef struct scene_texture {
    uint32_t image;
    uint32_t uv;           /* 0 or 1 */
    float scale_rotate[4]; /* KHR_texture_transform: uv' = M uv + offset, M row-major 2x2 */
    float offset[2];
    scene_filter magnify, minify;
    scene_mipmap mipmap;
    scene_wrap wrap_u, wrap_v;
} scene_texture;

typedef enum scene_alpha { SCENE_OPAQUE, SCENE_MASK, SCENE_BLEND } scene_alpha;

typedef struct scene_material {
    char *name;
    scene_alpha alpha;
    float alpha_cutoff;
    float base_color[4];
    float metallic, roughness;
    float emissive[3];     /* times KHR_materials_emissive_strength already */
    float normal_scale, occlusion_strength;
    float ior;             /* KHR_materials_ior, 1.5 by default */
    float transmission;    /* KHR_materials_transmission factor, 0..1 */
    uint32_t double_sided, unlit; /* 0 or 1 */
    scene_texture base_color_texture, metallic_roughness_texture, normal_texture,
        occlusion_texture, emissive_texture, transmission_texture;
} scene_material;

typedef enum scene_light_kind { SCENE_DIRECTIONAL, SCENE_POINT, SCENE_SPOT } scene_light_kind;

typedef struct scene_light {
    char *name;
    scene_light_kind kind;
    uint32_t node;
    float color[3]; /* linear, times intensity */
    float range;    /* 0 = unlimited */
    float inner_cos, outer_cos;
    float position[3], direction[3]; /* world; direction is where the light shines to, unit */
} scene_light;

typedef enum scene_projection { SCENE_PERSPECTIVE, SCENE_ORTHOGRAPHIC } scene_projection;

typedef struct scene_camera {
    char *name;
    scene_projection projection;
    uint32_t node;
    float yfov;         /* perspective, full vertical angle */
    float aspect;       /* 0 = that of the image */
    float znear, zfar;  /* zfar 0 = infinite */
    float xmag, ymag;   /* orthographic half extents */
    float world[16];    /* camera to world, rigid: looks along -z, y up */
} scene_camera;

typedef struct scene_animations scene_animations; /* hierarchy, skins and channels; private */

typedef struct scene {
    char *path; /* as given, for messages */
    scene_mesh *meshes;         uint32_t mesh_count;
    scene_instance *instances;  uint32_t instance_count;
    scene_image *images;        uint32_t image_count;
    scene_material *materials;  uint32_t material_count;
    scene_light *lights;        uint32_t light_count;
    scene_camera *cameras;      uint32_t camera_count;
    char **warnings;            uint32_t warning_count; /* one line each: what was ignored or mended */
    scene_animations *animations; /* NULL when nothing moves */
    float lower[3], upper[3];     /* world bounds of what is visible; lower > upper when empty */
    uint64_t primitive_count;     /* triangles and points over all instances; < 2^32 */
    uint64_t revision;            /* grows with every edit */
} scene;

/* Reads .gltf or .glb. All indices, offsets, strides, counts and recursions are checked before use;
 * images are decoded. The scene stands in its rest pose, whatever its animations do at time 0. On
 * failure nothing is left allocated and err names the file and the place in it
 * ("broken.gltf: accessors[3].byteOffset: ..."). Owner of *out: the caller, scene_free. */
strata_result scene_load(const char *path, scene **out, base_error *err);

/* The same from memory (a GLB, or JSON without external files); name stands in messages. */
strata_result scene_load_memory(const char *name, const void *data, size_t size, scene **out,
                                base_error *err);

/* A procedural scene: shells, soup, hairball, needles, particles, stack, city, layers, glass, burst;
 * or a hard case.
 * knobs: count strings "K=V". Unknown names and values out of range fail with the list of knobs. */
strata_result scene_generate(const char *name, const char *const *knobs, uint32_t knob_count,
                             scene **out, base_error *err);

typedef struct scene_generator_knob {
    const char *name, *title;
    double preset, minimum, maximum;
    int whole; /* 1: integers only */
    const char *const *choices; /* NULL-terminated names for 0, 1, ... up to maximum, or NULL */
} scene_generator_knob;
typedef struct scene_generator {
    const char *name, *title;
    const scene_generator_knob *knobs;
    uint32_t knob_count;
} scene_generator;
const scene_generator *scene_generators(uint32_t *count); /* static data, for help and list */

/* Hard cases: scene_generate takes their names too, without knobs. Some ask for a picture of their
 * size. */
typedef struct scene_hard_case {
    const char *name, *title; /* "hard:NAME" */
    uint32_t width, height;
} scene_hard_case;
const scene_hard_case *scene_hard_cases(uint32_t index); /* in the order of the list; NULL: no more */

/* Writes the scene as a self-contained GLB that scene_load reads back to the same meshes,
 * instances (EXT_mesh_gpu_instancing where a mesh repeats), materials, lights and cameras. */
strata_result scene_write_glb(const scene *s, const char *path, base_error *err);

void scene_free(scene *s); /* NULL is fine */

/* ---- edits: bounds and revision follow; primitive numbers never change ---------------------- */
/* Hierarchy, skins, morph targets, lights and cameras; every animation is applied, and keys hold
 * beyond their ends. Nothing moves: no edit. A pose that overflows fails and the last one stays. */
strata_result scene_set_time(scene *s, double seconds, base_error *err);
/* The hierarchy does not move this instance any more afterwards. */
strata_result scene_set_transform(scene *s, uint32_t instance, const float world[16], base_error *err);
strata_result scene_set_visible(scene *s, uint32_t instance, uint32_t visible, base_error *err);

#endif
