/* SPDX-License-Identifier: MIT
 *
 * What a glTF file may hold, as far as the loader reads it: one row a member. Included by
 * gltf_check.c alone, which walks a file's JSON by these tables.
 */
#ifndef STRATA_HOST_SCENE_GLTF_RULES_H
#define STRATA_HOST_SCENE_GLTF_RULES_H

typedef enum rule_kind {
    RULE_INDEX,    /* of an element of the top-level array `of` */
    RULE_INDICES,  /* array of such */
    RULE_MAP,      /* object whose members are such, whatever their names */
    RULE_MAPS,     /* array of such objects */
    RULE_COUNT,    /* integer, 0 .. 2^53 */
    RULE_SMALL,    /* integer, 0 .. 2^31 - 1 */
    RULE_CODE,     /* integer among those in `of`, separated by '|' */
    RULE_NUMBER,   /* that a finite float holds */
    RULE_POSITIVE, /* number above 0 */
    RULE_NUMBERS,  /* array of `size` numbers; of any length when size is 0 */
    RULE_TEXT,
    RULE_TEXTS,
    RULE_CHOICE, /* text among those in `of` */
    RULE_FLAG,
    RULE_OBJECT, /* with `members` */
    RULE_OBJECTS /* array of such */
} rule_kind;

typedef struct rule {
    const char *key; /* NULL ends a table */
    rule_kind kind;
    const char *of;
    const struct rule *members;
    unsigned size;
    unsigned required;
} rule;

/* A member of the extension object is read only when the extension is listed here. */
static const char *const supported_extensions[] = {
    "EXT_mesh_gpu_instancing", "KHR_lights_punctual",        "KHR_materials_emissive_strength",
    "KHR_materials_ior",       "KHR_materials_transmission", "KHR_materials_unlit",
    "KHR_mesh_quantization",   "KHR_texture_transform",
};

#define COMPONENT_CODES "5120|5121|5122|5123|5125|5126"

static const rule asset_rules[] = {
    {"version", .kind = RULE_TEXT, .required = 1},
    {"minVersion", .kind = RULE_TEXT},
    {0},
};

static const rule scene_rules[] = {
    {"nodes", .kind = RULE_INDICES, .of = "nodes"},
    {0},
};

/* ---- nodes ----------------------------------------------------------------------------------- */

static const rule node_light_rules[] = {
    {"light", .kind = RULE_INDEX, .of = "lights", .required = 1},
    {0},
};
static const rule instancing_rules[] = {
    {"attributes", .kind = RULE_MAP, .of = "accessors", .required = 1},
    {0},
};
static const rule node_extension_rules[] = {
    {"KHR_lights_punctual", .kind = RULE_OBJECT, .members = node_light_rules},
    {"EXT_mesh_gpu_instancing", .kind = RULE_OBJECT, .members = instancing_rules},
    {0},
};
static const rule node_rules[] = {
    {"name", .kind = RULE_TEXT},
    {"camera", .kind = RULE_INDEX, .of = "cameras"},
    {"children", .kind = RULE_INDICES, .of = "nodes"},
    {"skin", .kind = RULE_INDEX, .of = "skins"},
    {"matrix", .kind = RULE_NUMBERS, .size = 16},
    {"mesh", .kind = RULE_INDEX, .of = "meshes"},
    {"rotation", .kind = RULE_NUMBERS, .size = 4},
    {"scale", .kind = RULE_NUMBERS, .size = 3},
    {"translation", .kind = RULE_NUMBERS, .size = 3},
    {"weights", .kind = RULE_NUMBERS},
    {"extensions", .kind = RULE_OBJECT, .members = node_extension_rules},
    {0},
};

/* ---- meshes, accessors, buffers -------------------------------------------------------------- */

static const rule primitive_rules[] = {
    {"attributes", .kind = RULE_MAP, .of = "accessors", .required = 1},
    {"indices", .kind = RULE_INDEX, .of = "accessors"},
    {"material", .kind = RULE_INDEX, .of = "materials"},
    {"mode", .kind = RULE_CODE, .of = "0|1|2|3|4|5|6"},
    {"targets", .kind = RULE_MAPS, .of = "accessors"},
    {0},
};
static const rule mesh_rules[] = {
    {"name", .kind = RULE_TEXT},
    {"primitives", .kind = RULE_OBJECTS, .members = primitive_rules, .required = 1},
    {"weights", .kind = RULE_NUMBERS},
    {0},
};

static const rule sparse_indices_rules[] = {
    {"bufferView", .kind = RULE_INDEX, .of = "bufferViews", .required = 1},
    {"byteOffset", .kind = RULE_SMALL},
    {"componentType", .kind = RULE_CODE, .of = "5121|5123|5125", .required = 1},
    {0},
};
static const rule sparse_values_rules[] = {
    {"bufferView", .kind = RULE_INDEX, .of = "bufferViews", .required = 1},
    {"byteOffset", .kind = RULE_SMALL},
    {0},
};
static const rule sparse_rules[] = {
    {"count", .kind = RULE_SMALL, .required = 1},
    {"indices", .kind = RULE_OBJECT, .members = sparse_indices_rules, .required = 1},
    {"values", .kind = RULE_OBJECT, .members = sparse_values_rules, .required = 1},
    {0},
};
static const rule accessor_rules[] = {
    {"bufferView", .kind = RULE_INDEX, .of = "bufferViews"},
    {"byteOffset", .kind = RULE_COUNT},
    {"componentType", .kind = RULE_CODE, .of = COMPONENT_CODES, .required = 1},
    {"normalized", .kind = RULE_FLAG},
    {"count", .kind = RULE_COUNT, .required = 1},
    {"type", .kind = RULE_CHOICE, .of = "SCALAR|VEC2|VEC3|VEC4|MAT2|MAT3|MAT4", .required = 1},
    {"sparse", .kind = RULE_OBJECT, .members = sparse_rules},
    {0},
};
static const rule view_rules[] = {
    {"buffer", .kind = RULE_INDEX, .of = "buffers", .required = 1},
    {"byteOffset", .kind = RULE_COUNT},
    {"byteLength", .kind = RULE_COUNT, .required = 1},
    {"byteStride", .kind = RULE_SMALL},
    {0},
};
static const rule buffer_rules[] = {
    {"uri", .kind = RULE_TEXT},
    {"byteLength", .kind = RULE_COUNT, .required = 1},
    {0},
};

/* ---- materials, textures, images ------------------------------------------------------------- */

static const rule transform_rules[] = {
    {"offset", .kind = RULE_NUMBERS, .size = 2},
    {"rotation", .kind = RULE_NUMBER},
    {"scale", .kind = RULE_NUMBERS, .size = 2},
    {"texCoord", .kind = RULE_CODE, .of = "0|1|2|3|4|5|6|7"},
    {0},
};
static const rule texture_use_extension_rules[] = {
    {"KHR_texture_transform", .kind = RULE_OBJECT, .members = transform_rules},
    {0},
};
static const rule texture_use_rules[] = {
    {"index", .kind = RULE_INDEX, .of = "textures", .required = 1},
    {"texCoord", .kind = RULE_CODE, .of = "0|1|2|3|4|5|6|7"},
    {"scale", .kind = RULE_NUMBER},
    {"strength", .kind = RULE_NUMBER},
    {"extensions", .kind = RULE_OBJECT, .members = texture_use_extension_rules},
    {0},
};
static const rule pbr_rules[] = {
    {"baseColorFactor", .kind = RULE_NUMBERS, .size = 4},
    {"baseColorTexture", .kind = RULE_OBJECT, .members = texture_use_rules},
    {"metallicFactor", .kind = RULE_NUMBER},
    {"roughnessFactor", .kind = RULE_NUMBER},
    {"metallicRoughnessTexture", .kind = RULE_OBJECT, .members = texture_use_rules},
    {0},
};
static const rule emissive_strength_rules[] = {
    {"emissiveStrength", .kind = RULE_NUMBER},
    {0},
};
static const rule transmission_rules[] = {
    {"transmissionFactor", .kind = RULE_NUMBER},
    {"transmissionTexture", .kind = RULE_OBJECT, .members = texture_use_rules},
    {0},
};
static const rule ior_rules[] = {
    {"ior", .kind = RULE_NUMBER},
    {0},
};
static const rule no_rules[] = {
    {0},
};
static const rule material_extension_rules[] = {
    {"KHR_materials_emissive_strength", .kind = RULE_OBJECT, .members = emissive_strength_rules},
    {"KHR_materials_ior", .kind = RULE_OBJECT, .members = ior_rules},
    {"KHR_materials_transmission", .kind = RULE_OBJECT, .members = transmission_rules},
    {"KHR_materials_unlit", .kind = RULE_OBJECT, .members = no_rules},
    {0},
};
static const rule material_rules[] = {
    {"name", .kind = RULE_TEXT},
    {"pbrMetallicRoughness", .kind = RULE_OBJECT, .members = pbr_rules},
    {"normalTexture", .kind = RULE_OBJECT, .members = texture_use_rules},
    {"occlusionTexture", .kind = RULE_OBJECT, .members = texture_use_rules},
    {"emissiveTexture", .kind = RULE_OBJECT, .members = texture_use_rules},
    {"emissiveFactor", .kind = RULE_NUMBERS, .size = 3},
    {"alphaMode", .kind = RULE_CHOICE, .of = "OPAQUE|MASK|BLEND"},
    {"alphaCutoff", .kind = RULE_NUMBER},
    {"doubleSided", .kind = RULE_FLAG},
    {"extensions", .kind = RULE_OBJECT, .members = material_extension_rules},
    {0},
};
static const rule texture_rules[] = {
    {"sampler", .kind = RULE_INDEX, .of = "samplers"},
    {"source", .kind = RULE_INDEX, .of = "images"},
    {0},
};
static const rule sampler_rules[] = {
    {"magFilter", .kind = RULE_CODE, .of = "9728|9729"},
    {"minFilter", .kind = RULE_CODE, .of = "9728|9729|9984|9985|9986|9987"},
    {"wrapS", .kind = RULE_CODE, .of = "10497|33071|33648"},
    {"wrapT", .kind = RULE_CODE, .of = "10497|33071|33648"},
    {0},
};
static const rule image_rules[] = {
    {"name", .kind = RULE_TEXT},
    {"uri", .kind = RULE_TEXT},
    {"mimeType", .kind = RULE_TEXT},
    {"bufferView", .kind = RULE_INDEX, .of = "bufferViews"},
    {0},
};

/* ---- cameras, lights, skins, animations ------------------------------------------------------ */

static const rule perspective_rules[] = {
    {"aspectRatio", .kind = RULE_POSITIVE},
    {"yfov", .kind = RULE_POSITIVE, .required = 1},
    {"znear", .kind = RULE_POSITIVE, .required = 1},
    {"zfar", .kind = RULE_POSITIVE},
    {0},
};
static const rule orthographic_rules[] = {
    {"xmag", .kind = RULE_NUMBER, .required = 1},
    {"ymag", .kind = RULE_NUMBER, .required = 1},
    {"znear", .kind = RULE_NUMBER, .required = 1},
    {"zfar", .kind = RULE_POSITIVE, .required = 1},
    {0},
};
static const rule camera_rules[] = {
    {"name", .kind = RULE_TEXT},
    {"type", .kind = RULE_CHOICE, .of = "perspective|orthographic", .required = 1},
    {"perspective", .kind = RULE_OBJECT, .members = perspective_rules},
    {"orthographic", .kind = RULE_OBJECT, .members = orthographic_rules},
    {0},
};
static const rule spot_rules[] = {
    {"innerConeAngle", .kind = RULE_NUMBER},
    {"outerConeAngle", .kind = RULE_NUMBER},
    {0},
};
static const rule light_rules[] = {
    {"name", .kind = RULE_TEXT},
    {"color", .kind = RULE_NUMBERS, .size = 3},
    {"intensity", .kind = RULE_NUMBER},
    {"type", .kind = RULE_CHOICE, .of = "directional|point|spot", .required = 1},
    {"range", .kind = RULE_POSITIVE},
    {"spot", .kind = RULE_OBJECT, .members = spot_rules},
    {0},
};
static const rule lights_rules[] = {
    {"lights", .kind = RULE_OBJECTS, .members = light_rules, .required = 1},
    {0},
};
static const rule root_extension_rules[] = {
    {"KHR_lights_punctual", .kind = RULE_OBJECT, .members = lights_rules},
    {0},
};
static const rule skin_rules[] = {
    {"joints", .kind = RULE_INDICES, .of = "nodes", .required = 1},
    {"inverseBindMatrices", .kind = RULE_INDEX, .of = "accessors"},
    {0},
};
static const rule target_rules[] = {
    {"node", .kind = RULE_INDEX, .of = "nodes"},
    {"path", .kind = RULE_CHOICE, .of = "translation|rotation|scale|weights|pointer",
     .required = 1},
    {0},
};
static const rule channel_rules[] = {
    {"sampler", .kind = RULE_SMALL, .required = 1},
    {"target", .kind = RULE_OBJECT, .members = target_rules, .required = 1},
    {0},
};
static const rule animation_sampler_rules[] = {
    {"input", .kind = RULE_INDEX, .of = "accessors", .required = 1},
    {"output", .kind = RULE_INDEX, .of = "accessors", .required = 1},
    {"interpolation", .kind = RULE_CHOICE, .of = "LINEAR|STEP|CUBICSPLINE"},
    {0},
};
static const rule animation_rules[] = {
    {"channels", .kind = RULE_OBJECTS, .members = channel_rules, .required = 1},
    {"samplers", .kind = RULE_OBJECTS, .members = animation_sampler_rules, .required = 1},
    {0},
};

static const rule root_rules[] = {
    {"asset", .kind = RULE_OBJECT, .members = asset_rules, .required = 1},
    {"extensionsUsed", .kind = RULE_TEXTS},
    {"extensionsRequired", .kind = RULE_TEXTS},
    {"scene", .kind = RULE_INDEX, .of = "scenes"},
    {"scenes", .kind = RULE_OBJECTS, .members = scene_rules},
    {"nodes", .kind = RULE_OBJECTS, .members = node_rules},
    {"meshes", .kind = RULE_OBJECTS, .members = mesh_rules},
    {"accessors", .kind = RULE_OBJECTS, .members = accessor_rules},
    {"bufferViews", .kind = RULE_OBJECTS, .members = view_rules},
    {"buffers", .kind = RULE_OBJECTS, .members = buffer_rules},
    {"materials", .kind = RULE_OBJECTS, .members = material_rules},
    {"textures", .kind = RULE_OBJECTS, .members = texture_rules},
    {"samplers", .kind = RULE_OBJECTS, .members = sampler_rules},
    {"images", .kind = RULE_OBJECTS, .members = image_rules},
    {"cameras", .kind = RULE_OBJECTS, .members = camera_rules},
    {"skins", .kind = RULE_OBJECTS, .members = skin_rules},
    {"animations", .kind = RULE_OBJECTS, .members = animation_rules},
    {"extensions", .kind = RULE_OBJECT, .members = root_extension_rules},
    {0},
};

#endif
