/* SPDX-License-Identifier: MIT
 *
 * What the procedural scenes share: a random generator, trigonometry that gives the same bits on
 * every machine, and a builder for meshes, materials, lights and cameras. Private to host/scene.
 *
 * Running out of memory is remembered in the builder and ends in one error; nothing in between has
 * to be checked. Everything is computed in double with +, -, *, / and sqrt alone, and rounded once.
 */
#ifndef STRATA_HOST_SCENE_GENERATE_H
#define STRATA_HOST_SCENE_GENERATE_H

#include "scene/scene_internal.h"

/* ---- numbers ---------------------------------------------------------------------------------
 * PCG32 (O'Neill 2014), one stream a scene. */
typedef struct generate_random {
    uint64_t state;
} generate_random;

generate_random generate_seed(uint64_t seed);
uint32_t generate_bits(generate_random *random);
double generate_unit(generate_random *random); /* [0, 1), 32 bits */
double generate_between(generate_random *random, double low, double high);
void generate_direction(generate_random *random, double out[3]); /* even over the sphere */

/* Sine and cosine of an angle in turns (1 = 360 degrees), within 2e-15 for |turns| < 2^20. */
void generate_turn(double turns, double *sine, double *cosine);

void generate_normalize(double v[3]); /* zero becomes +z */
void generate_cross(const double a[3], const double b[3], double out[3]);

/* A vivid linear colour of the given hue in turns. */
void generate_hue(double hue, float out[3]);

/* ---- building -------------------------------------------------------------------------------- */
typedef struct generate_builder {
    scene *s;
    const double *knobs; /* in the order of the scene's knob list; choices are indices */
    generate_random random;
    size_t mesh_capacity, instance_capacity, material_capacity, light_capacity, camera_capacity;
    int failed; /* out of memory: nothing more is added */
} generate_builder;

/* A mesh that grows. Attributes are there for all vertices or for none. */
typedef struct generate_mesh {
    generate_builder *builder;
    float *positions, *normals, *uv, *colors, *radii;
    uint32_t *indices;
    size_t vertex_count, vertex_capacity, index_count, index_capacity;
    int has_normals, has_uv, has_colors, has_radii;
} generate_mesh;

enum { GENERATE_NORMALS = 1, GENERATE_UV = 2, GENERATE_COLORS = 4, GENERATE_RADII = 8 };

generate_mesh generate_mesh_begin(generate_builder *b, unsigned attributes);
/* Room for that much more at once; optional. */
void generate_mesh_reserve(generate_mesh *mesh, size_t vertices, size_t indices);
/* Appends a vertex, position only; what else the mesh has is set with the next three, which write
 * to the vertex added last. Returns its number. */
uint32_t generate_vertex(generate_mesh *mesh, double x, double y, double z);
void generate_normal(generate_mesh *mesh, double x, double y, double z);
void generate_uv(generate_mesh *mesh, double u, double v);
void generate_color(generate_mesh *mesh, const float rgb[3], double alpha);
void generate_radius(generate_mesh *mesh, double radius);
void generate_triangle(generate_mesh *mesh, uint32_t a, uint32_t b, uint32_t c);

/* Hands the arrays to the scene; returns the mesh's index. One with radii is points. An empty one
 * is dropped: SCENE_NONE, of which generate_instance makes nothing. */
uint32_t generate_mesh_end(generate_mesh *mesh, const char *name, uint32_t material);

/* Uniform scale and translation; x y z may be scaled apart. */
void generate_instance(generate_builder *b, uint32_t mesh, const double translation[3],
                       const double scale[3]);
void generate_instance_here(generate_builder *b, uint32_t mesh); /* identity */

uint32_t generate_material(generate_builder *b, const char *name, const scene_material *material);

/* Perspective, looking from `eye` to `target`, y up; depth range near .. far. */
void generate_camera(generate_builder *b, const char *name, const double eye[3],
                     const double target[3], double yfov_degrees, double near, double far);
/* Orthographic from the origin along -z, half extents x and y, depth range 0 .. far. */
void generate_camera_flat(generate_builder *b, double half_x, double half_y, double far);

void generate_sun(generate_builder *b, const double direction[3], const float color[3]);
void generate_lamp(generate_builder *b, const double position[3], const float color[3]);

/* Takes over `pixels` ([height][width][4], sRGB). Returns the image's index. */
uint32_t generate_image(generate_builder *b, const char *name, uint32_t width, uint32_t height,
                        unsigned char *pixels);

/* ---- shapes, generate_shapes.c ---------------------------------------------------------------
 * Closed, wound counter-clockwise seen from outside, with normals. */

/* 8 * detail^2 triangles; the same bits along the seams of its eight faces. */
void generate_sphere(generate_mesh *mesh, const double centre[3], double radius, uint32_t detail);
/* Axis-aligned; uv runs once round the walls. */
void generate_box(generate_mesh *mesh, const double lower[3], const double upper[3]);
/* In the plane y = height, facing up; uv repeats every `tile`. */
void generate_floor(generate_mesh *mesh, double half, double height, double tile, uint32_t cells);
/* `profile` [count][2] of (radius, height), turned about the y axis at `centre`. */
void generate_lathe(generate_mesh *mesh, const double centre[3], const double (*profile)[2],
                    uint32_t count, uint32_t segments);
void generate_torus(generate_mesh *mesh, const double centre[3], double ring, double tube,
                    const double axis[3], uint32_t segments, uint32_t sides);
/* A tube (sides >= 3) or ribbon (sides 2) along `points` [count][3]; a ribbon lies across
 * `across` [count][3], a tube's first side is there. radius is the half width, `taper` the share of
 * it that is left at the end. */
void generate_tube(generate_mesh *mesh, const double (*points)[3], const double (*across)[3],
                   uint32_t count, double radius, double taper, uint32_t sides);

/* ---- the scenes, in the order of scene_generators; knobs in the order of generate_knobs.c -------
 */
enum {
    SHELLS_SEED,
    SHELLS_COUNT,
    SHELLS_SUBDIVISION,
    SHELLS_ALPHA,
    SHELLS_CORE,
    SHELLS_TRANSMISSION
};
enum { SOUP_SEED, SOUP_SMALL, SOUP_MEDIUM, SOUP_DEPTH, SOUP_MATERIALS, SOUP_ALPHA };
enum {
    HAIRBALL_SEED,
    HAIRBALL_STRANDS,
    HAIRBALL_SEGMENTS,
    HAIRBALL_SIDES,
    HAIRBALL_RADIUS,
    HAIRBALL_ALPHA,
    HAIRBALL_CORE
};
enum {
    NEEDLES_SEED,
    NEEDLES_BRANCHES,
    NEEDLES_NEEDLES,
    NEEDLES_LENGTH,
    NEEDLES_WIDTH,
    NEEDLES_ALPHA
};
enum { PARTICLES_SEED, PARTICLES_COUNT, PARTICLES_RADIUS, PARTICLES_ALPHA, PARTICLES_CORE };
enum {
    STACK_SEED,
    STACK_COUNT,
    STACK_ALPHA,
    STACK_TILT,
    STACK_SHIFT,
    STACK_SPLIT,
    STACK_OPAQUE,
    STACK_MERGED
};
enum { CITY_SEED, CITY_COUNT, CITY_VIEW, CITY_GLASS, CITY_ALPHA };
enum {
    LAYERS_SEED,
    LAYERS_COUNT,
    LAYERS_WHERE,
    LAYERS_WIDTH,
    LAYERS_HEIGHT,
    LAYERS_ALPHA,
    LAYERS_ORDER,
    LAYERS_OPAQUE
};
enum { GLASS_SEED, GLASS_DETAIL, GLASS_SMOKE };
enum { CITY_STREET, CITY_AERIAL };                             /* CITY_VIEW */
enum { /* burst */
    BURST_SEED,
    BURST_MEAN,
    BURST_SPREAD,
    BURST_WIDTH,
    BURST_HEIGHT,
    BURST_ALPHA
};
enum { LAYERS_ALL, LAYERS_PIXEL };                             /* LAYERS_WHERE */
enum { LAYERS_SHUFFLED, LAYERS_NEAR_FIRST, LAYERS_FAR_FIRST }; /* LAYERS_ORDER */

uint32_t generate_knob(const generate_builder *b, int knob); /* of a whole knob */

void generate_shells(generate_builder *b);
void generate_soup(generate_builder *b);
void generate_hairball(generate_builder *b);
void generate_needles(generate_builder *b);
void generate_particles(generate_builder *b);
void generate_stack(generate_builder *b);
void generate_city(generate_builder *b);
void generate_layers(generate_builder *b);
void generate_burst(generate_builder *b);
void generate_glass(generate_builder *b);

#endif
