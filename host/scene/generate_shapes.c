/* SPDX-License-Identifier: MIT
 *
 * The solids of which procedural scenes are put together. Closed shapes repeat the very same
 * positions along their seams, so that no pixel falls between two faces.
 */
#include "scene/generate.h"

#include <math.h>

/* One of the eight faces, with corners on the axes at `sign`; a triangular grid of detail rows. */
static void sphere_face(generate_mesh *mesh, const double centre[3], double radius, uint32_t detail,
                        const double sign[3]) {
    uint32_t row_start = (uint32_t)mesh->vertex_count;
    int outward = sign[0] * sign[1] * sign[2] > 0;
    for (uint32_t i = 0; i <= detail; i++) {
        for (uint32_t j = 0; j <= i; j++) {
            double d[3] = {sign[0] * (detail - i), sign[1] * (i - j), sign[2] * j};
            generate_normalize(d);
            generate_vertex(mesh, centre[0] + radius * d[0], centre[1] + radius * d[1],
                            centre[2] + radius * d[2]);
            generate_normal(mesh, d[0], d[1], d[2]);
        }
    }
    for (uint32_t i = 0; i < detail; i++) {
        uint32_t next = row_start + i + 1;
        for (uint32_t j = 0; j <= i; j++) {
            uint32_t a = row_start + j, b = next + j, c = next + j + 1;
            generate_triangle(mesh, a, outward ? b : c, outward ? c : b);
            if (j < i)
                generate_triangle(mesh, a, outward ? c : a + 1, outward ? a + 1 : c);
        }
        row_start = next;
    }
}

void generate_sphere(generate_mesh *mesh, const double centre[3], double radius, uint32_t detail) {
    size_t n = detail;
    generate_mesh_reserve(mesh, 4 * (n + 1) * (n + 2), 24 * n * n);
    for (int octant = 0; octant < 8; octant++) {
        const double sign[3] = {octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1};
        sphere_face(mesh, centre, radius, detail, sign);
    }
}

/* corner bits: x, y, z high; four per face, counter-clockwise from outside, first two below. */
static const unsigned char box_faces[6][4] = {{5, 1, 3, 7}, {0, 4, 6, 2}, {6, 7, 3, 2},
                                              {0, 1, 5, 4}, {4, 5, 7, 6}, {1, 0, 2, 3}};
static const signed char box_normals[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                              {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

void generate_box(generate_mesh *mesh, const double lower[3], const double upper[3]) {
    static const double wall[6] = {0.25, 0.75, -1, -1, 0, 0.5}; /* where its quarter of u begins */
    for (int face = 0; face < 6; face++) {
        uint32_t first = (uint32_t)mesh->vertex_count;
        for (int i = 0; i < 4; i++) {
            unsigned corner = box_faces[face][i];
            generate_vertex(mesh, corner & 1 ? upper[0] : lower[0],
                            corner & 2 ? upper[1] : lower[1], corner & 4 ? upper[2] : lower[2]);
            generate_normal(mesh, box_normals[face][0], box_normals[face][1], box_normals[face][2]);
            if (wall[face] >= 0)
                generate_uv(mesh, wall[face] + (i == 1 || i == 2 ? 0.25 : 0), i < 2 ? 1 : 0);
        }
        generate_triangle(mesh, first, first + 1, first + 2);
        generate_triangle(mesh, first, first + 2, first + 3);
    }
}

void generate_floor(generate_mesh *mesh, double half, double height, double tile, uint32_t cells) {
    uint32_t first = (uint32_t)mesh->vertex_count, side = cells + 1;
    for (uint32_t j = 0; j < side; j++) {
        for (uint32_t i = 0; i < side; i++) {
            double x = half * (2.0 * i / cells - 1), z = half * (2.0 * j / cells - 1);
            generate_vertex(mesh, x, height, z);
            generate_normal(mesh, 0, 1, 0);
            generate_uv(mesh, x / tile, z / tile);
        }
    }
    for (uint32_t j = 0; j < cells; j++) {
        for (uint32_t i = 0; i < cells; i++) {
            uint32_t a = first + j * side + i;
            generate_triangle(mesh, a, a + side, a + side + 1);
            generate_triangle(mesh, a, a + side + 1, a + 1);
        }
    }
}

/* Joins rings of `sides` vertices each: quads between neighbours, closed round the ring. `closed`
 * joins the last ring to the first as well. */
static void join_rings(generate_mesh *mesh, uint32_t first, uint32_t rings, uint32_t sides,
                       int closed) {
    for (uint32_t ring = 0; ring + !closed < rings; ring++) {
        uint32_t low = first + ring * sides, high = first + (ring + 1) % rings * sides;
        for (uint32_t j = 0; j < sides; j++) {
            uint32_t k = (j + 1) % sides;
            generate_triangle(mesh, low + j, low + k, high + k);
            generate_triangle(mesh, low + j, high + k, high + j);
        }
    }
}

void generate_lathe(generate_mesh *mesh, const double centre[3], const double (*profile)[2],
                    uint32_t count, uint32_t segments) {
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (uint32_t i = 0; i < count; i++) {
        const double *before = profile[i > 0 ? i - 1 : 0];
        const double *after = profile[i + 1 < count ? i + 1 : i];
        double out = after[1] - before[1], up = before[0] - after[0];
        for (uint32_t j = 0; j < segments; j++) {
            double s, c;
            generate_turn(-(double)j / segments, &s, &c);
            generate_vertex(mesh, centre[0] + profile[i][0] * c, centre[1] + profile[i][1],
                            centre[2] + profile[i][0] * s);
            generate_normal(mesh, out * c, up, out * s);
        }
    }
    join_rings(mesh, first, count, segments, 0);
}

/* Two unit vectors that make a right-handed frame with the unit vector `axis`. */
static void frame_about(const double axis[3], double u[3], double v[3]) {
    const double x[3] = {1, 0, 0}, y[3] = {0, 1, 0};
    generate_cross(axis[0] * axis[0] < 0.5 ? x : y, axis, u);
    generate_normalize(u);
    generate_cross(axis, u, v);
}

void generate_torus(generate_mesh *mesh, const double centre[3], double ring, double tube,
                    const double axis[3], uint32_t segments, uint32_t sides) {
    uint32_t first = (uint32_t)mesh->vertex_count;
    double n[3] = {axis[0], axis[1], axis[2]}, u[3], v[3];
    generate_normalize(n);
    frame_about(n, u, v);
    for (uint32_t i = 0; i < segments; i++) {
        double si, ci;
        generate_turn((double)i / segments, &si, &ci);
        for (uint32_t j = 0; j < sides; j++) {
            double sj, cj, d[3], p[3];
            generate_turn(-(double)j / sides, &sj, &cj);
            for (int k = 0; k < 3; k++) {
                double out = u[k] * ci + v[k] * si;
                d[k] = out * cj + n[k] * sj;
                p[k] = centre[k] + out * ring + d[k] * tube;
            }
            generate_vertex(mesh, p[0], p[1], p[2]);
            generate_normal(mesh, d[0], d[1], d[2]);
        }
    }
    join_rings(mesh, first, segments, sides, 1);
}

/* Ribbons have no inside, so their one quad a segment is not closed round. */
static void join_ribbon(generate_mesh *mesh, uint32_t first, uint32_t rings) {
    for (uint32_t i = 0; i + 1 < rings; i++) {
        uint32_t a = first + 2 * i;
        generate_triangle(mesh, a, a + 1, a + 3);
        generate_triangle(mesh, a, a + 3, a + 2);
    }
}

void generate_tube(generate_mesh *mesh, const double (*points)[3], const double (*across)[3],
                   uint32_t count, double radius, double taper, uint32_t sides) {
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (uint32_t i = 0; i < count; i++) {
        const double *before = points[i > 0 ? i - 1 : 0];
        const double *after = points[i + 1 < count ? i + 1 : i];
        double tangent[3], other[3];
        for (int k = 0; k < 3; k++)
            tangent[k] = after[k] - before[k];
        generate_normalize(tangent);
        generate_cross(tangent, across[i], other);
        double r = count > 1 ? radius * (1 - (1 - taper) * i / (count - 1)) : radius;
        for (uint32_t j = 0; j < sides; j++) {
            double s, c, d[3];
            generate_turn((double)j / sides, &s, &c);
            for (int k = 0; k < 3; k++)
                d[k] = across[i][k] * c + other[k] * s;
            generate_vertex(mesh, points[i][0] + r * d[0], points[i][1] + r * d[1],
                            points[i][2] + r * d[2]);
            if (sides == 2)
                generate_normal(mesh, other[0], other[1], other[2]);
            else
                generate_normal(mesh, d[0], d[1], d[2]);
        }
    }
    if (sides == 2)
        join_ribbon(mesh, first, count);
    else
        join_rings(mesh, first, count, sides, 0);
}
