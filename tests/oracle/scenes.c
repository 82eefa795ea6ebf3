/* SPDX-License-Identifier: MIT
 *
 * Small glTF scenes that ask hard questions of capture and fold, built in code. Each is a GLB that
 * goes through the loader like any file. See oracle.h.
 *
 *   crossing  triangles that pass through each other, some opaque
 *   ties      transparent on opaque at the same depth, depths 0 and 1, in exact arithmetic
 *   inside    the eye among triangles that reach behind it; camera 0 infinite, 1 with a far plane
 *   mirror    one mesh placed by turns, mirrors, uneven scales; faces without a back; alpha tests
 *   edges     corners and edges on pixel centres, each pixel covered once; and mirrored
 *   bright    colours beyond the range of a half, alphas from 0 to 1
 *   clear     alphas of zero and nearly so, with light of their own
 *   opaque    nothing transparent at all
 */
#include "oracle/oracle.h"

#include <stdlib.h>
#include <string.h>

#include "scenes/glb.h"

typedef struct world {
    test_glb glb;
    base_text materials, meshes, nodes, cameras, roots;
    uint32_t material_count, mesh_count, node_count, camera_count;
    uint64_t random;
} world;

/* ---- building -------------------------------------------------------------------------------- */

static double between(world *w, double low, double high) {
    w->random = w->random * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(w->random >> 33) / 2147483648.0;
}

enum { SOLID = 0, BLEND = 1, DOUBLE = 2 };

/* Unlit, so that nothing but the base colour tells. */
static uint32_t material(world *w, unsigned kind, const double color[4]) {
    base_text_add(&w->materials,
                  "%s{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%g,%g,%g,%g]},"
                  "\"alphaMode\":\"%s\",\"doubleSided\":%s,"
                  "\"extensions\":{\"KHR_materials_unlit\":{}}}",
                  w->material_count ? "," : "", color[0], color[1], color[2], color[3],
                  kind & BLEND ? "BLEND" : "OPAQUE", kind & DOUBLE ? "true" : "false");
    return w->material_count++;
}

static uint32_t material_json(world *w, const char *json) {
    base_text_add(&w->materials, "%s%s", w->material_count ? "," : "", json);
    return w->material_count++;
}

/* Begins a mesh, or goes on with its next primitive when `more` is set. */
static uint32_t triangles(world *w, const float *corners, uint32_t count, uint32_t material_index,
                          int more) {
    const uint32_t positions = test_glb_floats(&w->glb, "VEC3", 3, count * 3, corners);
    if (more)
        w->meshes.data[w->meshes.length -= 2] = '\0';
    base_text_add(&w->meshes, "%s{\"attributes\":{\"POSITION\":%u},\"material\":%u}]}",
                  more            ? ","
                  : w->mesh_count ? ",{\"primitives\":["
                                  : "{\"primitives\":[",
                  positions, material_index);
    w->mesh_count += !more;
    return w->mesh_count - 1;
}

/* `more`: further members with a leading comma. */
static void node(world *w, const char *kind, uint32_t index, const char *more) {
    base_text_add(&w->nodes, "%s{\"%s\":%u%s}", w->node_count ? "," : "", kind, index, more);
    base_text_add(&w->roots, "%s%u", w->node_count ? "," : "", w->node_count);
    w->node_count++;
}

static void camera(world *w, const char *json, const char *place) {
    base_text_add(&w->cameras, "%s%s", w->camera_count ? "," : "", json);
    node(w, "camera", w->camera_count++, place);
}

#define PERSPECTIVE(more) "{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.9," more "}}"
#define ORTHOGRAPHIC                                                                               \
    "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,\"ymag\":1,\"znear\":0,\"zfar\":1}}"

/* Two triangles, counter-clockwise seen from +z. */
static void quad(float out[18], float x0, float y0, float x1, float y1, float z) {
    const float corners[18] = {x0, y0, z, x1, y0, z, x1, y1, z, x0, y0, z, x1, y1, z, x0, y1, z};
    memcpy(out, corners, sizeof corners);
}

static unsigned char *finish(world *w, size_t *size) {
    test_glb *g = &w->glb;
    test_glb_json(g, "\"extensionsUsed\":[\"KHR_materials_unlit\","
                     "\"KHR_materials_emissive_strength\",\"EXT_mesh_gpu_instancing\"]");
    base_text *const lists[] = {&w->materials, &w->meshes, &w->nodes, &w->cameras};
    static const char *const names[] = {"materials", "meshes", "nodes", "cameras"};
    for (int i = 0; i < 4; i++) {
        base_text_add(&g->rest, ",\"%s\":[%s]", names[i], lists[i]->data);
        base_text_free(lists[i]);
    }
    test_glb_json(g, "\"scene\":0,\"scenes\":[{\"nodes\":[%s]}]", w->roots.data);
    base_text_free(&w->roots);
    return test_glb_finish(g, size);
}

/* `count` triangles with corners in a box, half of it `reach` in x and y, `deep` in z. */
static void scatter(world *w, uint32_t count, unsigned kind, double reach, double deep) {
    float corners[64 * 9];
    const double color[4] = {between(w, 0.1, 1), between(w, 0.1, 1), between(w, 0.1, 1),
                             kind & BLEND ? between(w, 0.2, 0.6) : 1};
    for (uint32_t i = 0; i < count * 9; i++)
        corners[i] = (float)between(w, i % 3 == 2 ? -deep : -reach, i % 3 == 2 ? deep : reach);
    node(w, "mesh", triangles(w, corners, count, material(w, kind, color), 0), "");
}

/* ---- the scenes ------------------------------------------------------------------------------ */

static void crossing(world *w) {
    scatter(w, 12, BLEND | DOUBLE, 1.2, 1.2);
    scatter(w, 2, SOLID | DOUBLE, 0.8, 1.2);
    scatter(w, 12, BLEND | DOUBLE, 1.2, 1.2);
    scatter(w, 8, BLEND, 1.2, 1.2);
    camera(w, PERSPECTIVE("\"znear\":0.5,\"zfar\":20"), ",\"translation\":[0,0,3]");
}

/* Clip depth is z + 1, without any rounding. */
static void ties(world *w) {
    static const double colors[][4] = {{0.9, 0.2, 0.1, 1},    {0.2, 0.8, 0.3, 0.5},
                                       {0.1, 0.3, 0.9, 0.25}, {0.8, 0.8, 0.2, 0.5},
                                       {0.2, 0.7, 0.8, 0.4},  {0.9, 0.9, 0.9, 0.3}};
    static const float depths[] = {-0.5f, -0.5f, -0.5f, -0.25f, -0.75f, 0.0f, -1.0f};
    float corners[18];
    for (unsigned i = 0; i < 7; i++) {
        const float at = 0.07f * (float)i;
        quad(corners, -0.7f + at, -0.6f + at, 0.3f + at, 0.5f + at, depths[i]);
        node(w, "mesh", triangles(w, corners, 2, material(w, i ? BLEND : SOLID, colors[i % 6]), 0),
             "");
    }
    static const float tilted[9] = {-0.93f, 0.41f,  -0.3f, -0.11f, 0.87f,
                                    -0.9f,  -0.83f, 0.95f, -0.4f};
    for (unsigned i = 0; i < 3; i++)
        node(w, "mesh", triangles(w, tilted, 1, material(w, i ? BLEND : SOLID, colors[i]), 0), "");
    camera(w, ORTHOGRAPHIC, "");
}

static void inside(world *w) {
    scatter(w, 20, BLEND | DOUBLE, 3, 3);
    scatter(w, 3, SOLID | DOUBLE, 3, 3);
    scatter(w, 20, BLEND, 2, 4);
    camera(w, PERSPECTIVE("\"znear\":0.125"), "");
    camera(w, PERSPECTIVE("\"znear\":0.25,\"zfar\":2"), ",\"rotation\":[0,0.6,0,0.8]");
}

static void mirror(world *w) {
    static const float low[12 * 3] = {
        -1, -1, 0, 1,     -1,   0,    0, 1, 0.2f, -1, -1, 0, 0,     1,    0.2f, -0.4f, 0.1f, 0.9f,
        1,  -1, 0, -0.4f, 0.1f, 0.9f, 0, 1, 0.2f, -1, -1, 0, -0.4f, 0.1f, 0.9f, 1,     -1,   0};
    static const float flat[9] = {-0.5f, -0.9f, -0.1f, 0.8f, -0.2f, 0.3f, -0.1f, 0.6f, 0.1f};
    static const float places[9] = {-0.9f, 0.8f, -0.6f, 0.9f, 0.8f, -0.4f, 0.1f, -1.2f, 0.3f};
    const uint32_t one = material(w, BLEND, (const double[4]){0.9, 0.4, 0.2, 0.4});
    const uint32_t both = material(w, BLEND | DOUBLE, (const double[4]){0.3, 0.4, 0.9, 0.3});
    const uint32_t solid = material(w, SOLID, (const double[4]){0.2, 0.6, 0.3, 1});
    const uint32_t stays = material_json(
        w, "{\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5,\"pbrMetallicRoughness\":"
           "{\"baseColorFactor\":[1,1,0,0.5]},\"extensions\":{\"KHR_materials_unlit\":{}}}");
    const uint32_t goes = material_json(
        w, "{\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5,\"pbrMetallicRoughness\":"
           "{\"baseColorFactor\":[0,1,1,0.25]},\"extensions\":{\"KHR_materials_unlit\":{}}}");
    const uint32_t mesh = triangles(w, low, 4, one, 0);
    triangles(w, flat, 1, both, 1);
    triangles(w, flat, 1, solid, 1);
    node(w, "mesh", mesh, ",\"translation\":[-1.1,0.2,0]");
    node(w, "mesh", mesh, ",\"scale\":[-1,1,1],\"translation\":[1.3,0.1,0.4]");
    node(w, "mesh", mesh, ",\"scale\":[0.7,-0.5,1.3],\"rotation\":[0.2,0.4,0.4,0.8]");
    node(w, "mesh", mesh, ",\"scale\":[-0.6,-0.8,-0.9],\"translation\":[0.2,-0.9,-0.5]");
    node(w, "mesh", triangles(w, flat, 1, stays, 0), ",\"translation\":[0.6,0.9,-0.2]");
    node(w, "mesh", triangles(w, flat, 1, goes, 0), ",\"translation\":[-0.6,0.9,1]");
    char more[128];
    snprintf(more, sizeof more,
             ",\"scale\":[0.5,0.5,-0.5],\"extensions\":{\"EXT_mesh_gpu_instancing\":"
             "{\"attributes\":{\"TRANSLATION\":%u}}}",
             test_glb_floats(&w->glb, "VEC3", 3, 3, places));
    node(w, "mesh", mesh, more);
    camera(w, PERSPECTIVE("\"znear\":1,\"zfar\":16"), ",\"translation\":[0,0,4.5]");
}

/* Long ones through the whole image; every eighth is a line. */
static void slivers(world *w) {
    float corners[64 * 9];
    for (unsigned i = 0; i < 64; i++) {
        const double thick = i % 8 ? 0.0005 * i : 0, deep = between(w, 0.1, 1.5);
        const double x0 = between(w, -1, 1), y0 = between(w, -1, 1), x1 = between(w, -1, 1),
                     y1 = between(w, -1, 1);
        const double triangle[9] = {
            x0, y0, -deep, x1, y1, deep, (x0 + x1) / 2 + thick, (y0 + y1) / 2, 0};
        for (int k = 0; k < 9; k++)
            corners[i * 9 + (unsigned)k] = (float)triangle[k];
    }
    const uint32_t m = material(w, BLEND | DOUBLE, (const double[4]){0.9, 0.7, 0.3, 0.5});
    node(w, "mesh", triangles(w, corners, 64, m, 0), "");
    scatter(w, 2, SOLID | DOUBLE, 0.7, 0.5);
    camera(w, PERSPECTIVE("\"znear\":0.5,\"zfar\":20"), ",\"translation\":[0,0,3]");
}

/* For 32 x 32 pixels: corners at every other pixel's centre, the diagonals through those between.
 */
static void edges(world *w) {
    float *corners = base_calloc((size_t)17 * 17 * 18, sizeof *corners), *at = corners;
    assert_non_null(corners);
    for (int y = 0; y < 17; y++)
        for (int x = 0; x < 17; x++, at += 18) {
            const float left = (float)(4 * x - 1) / 32.0f - 1, low = (float)(4 * y - 1) / 32.0f - 1;
            quad(at, left, low, left + 0.125f, low + 0.125f, -0.5f);
            if ((x + y) % 2) { /* the other diagonal */
                memcpy(at + 6, at + 15, 3 * sizeof *at);
                memcpy(at + 9, at + 3, 3 * sizeof *at);
            }
        }
    const uint32_t m = material(w, BLEND | DOUBLE, (const double[4]){0.4, 0.6, 0.8, 0.5});
    const uint32_t mesh = triangles(w, corners, 17 * 17 * 2, m, 0);
    node(w, "mesh", mesh, "");
    node(w, "mesh", mesh, ",\"scale\":[-1,1,1],\"translation\":[0,0,0.25]");
    camera(w, ORTHOGRAPHIC, "");
    free(corners);
}

static void bright(world *w) {
    static const double alphas[] = {0, 1.0 / 512, 0.25, 0.875, 1 - 0x1p-24, 1};
    float corners[18];
    for (unsigned i = 0; i < BASE_COUNT(alphas); i++) {
        char json[256];
        snprintf(json, sizeof json,
                 "{\"alphaMode\":\"BLEND\",\"emissiveFactor\":[1,0.25,%g],"
                 "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.5,0.5,%.9g]},"
                 "\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":%g}}}",
                 0.1 * i, alphas[i], i % 2 ? 100000.0 : 1e-4);
        const float at = 0.09f * (float)i;
        quad(corners, -0.8f + at, -0.7f, 0.4f + at, 0.7f, -0.1f * (float)(i + 1));
        node(w, "mesh", triangles(w, corners, 2, material_json(w, json), 0), "");
    }
    camera(w, ORTHOGRAPHIC, "");
}

/* Glass so clear that it only adds light, between layers that hide nearly nothing and everything.
 */
static void clear(world *w) {
    static const double alphas[] = {0, 0x1p-20, 0, 0.5, 1 - 0x1p-24, 0, 0x1p-24, 1, 0, 0.25};
    float corners[18];
    for (unsigned i = 0; i < BASE_COUNT(alphas); i++) {
        char json[256];
        snprintf(json, sizeof json,
                 "{\"alphaMode\":\"BLEND\",\"emissiveFactor\":[%g,0.25,%g],"
                 "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.5,0.5,%.9g]}}",
                 0.9 - 0.08 * i, 0.1 * i, alphas[i]);
        const float at = 0.06f * (float)i;
        quad(corners, -0.8f + at, -0.9f + at, 0.4f + at, 0.3f + at, -0.05f * (float)(i + 1));
        node(w, "mesh", triangles(w, corners, 2, material_json(w, json), 0), "");
    }
    camera(w, ORTHOGRAPHIC, "");
}

static void opaque(world *w) {
    scatter(w, 3, SOLID | DOUBLE, 1, 1);
    camera(w, PERSPECTIVE("\"znear\":0.5,\"zfar\":20"), ",\"translation\":[0,0,3]");
}

unsigned char *oracle_scene_build(const char *name, size_t *size) {
    static const struct {
        const char *name;
        void (*build)(world *w);
    } scenes[] = {{"crossing", crossing}, {"ties", ties},       {"inside", inside},
                  {"mirror", mirror},     {"slivers", slivers}, {"edges", edges},
                  {"bright", bright},     {"opaque", opaque},   {"clear", clear}};
    for (size_t i = 0; i < BASE_COUNT(scenes); i++)
        if (strcmp(scenes[i].name, name) == 0) {
            world w = {.random = 1};
            scenes[i].build(&w);
            return finish(&w, size);
        }
    return NULL;
}
