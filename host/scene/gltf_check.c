/* SPDX-License-Identifier: MIT
 *
 * The first step of the glTF loader: JSON text to a document that is safe to hand to tinygltf,
 * which believes what it reads. Everything known is held against gltf_rules.h; everything else is
 * dropped.
 */
#include "scene/gltf.h"
#include "scene/gltf_rules.h"

#include <float.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_ELEMENTS (1u << 20) /* objects in one array */
#define MAX_DEPTH    32         /* nested objects and arrays */

typedef struct checker {
    const char *name;
    json_t *root;
    base_error *err;
    char path[256]; /* where the walk stands: "meshes[0].primitives[1].mode" */
    size_t path_length;
} checker;

static strata_result fail(checker *c, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static strata_result fail(checker *c, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return base_fail(c->err, STRATA_ERROR_BAD_FILE, "%s: %s%s%s", c->name, c->path,
                     c->path_length ? ": " : "", text);
}

/* Extend the path; both return the length to go back to. */
static size_t enter_key(checker *c, const char *key) {
    size_t before = c->path_length;
    int wrote =
        snprintf(c->path + before, sizeof c->path - before, "%s%.60s", before ? "." : "", key);
    if (wrote > 0)
        c->path_length = strlen(c->path);
    return before;
}

static size_t enter_element(checker *c, size_t index) {
    size_t before = c->path_length;
    int wrote = snprintf(c->path + before, sizeof c->path - before, "[%zu]", index);
    if (wrote > 0)
        c->path_length = strlen(c->path);
    return before;
}

static void leave(checker *c, size_t before) {
    c->path_length = before;
    c->path[before] = '\0';
}

/* ---- single values --------------------------------------------------------------------------- */

static strata_result check_object(checker *c, json_t *object, const rule *members);

static const char *type_name(const json_t *value) {
    static const char *const names[] = {"an object", "an array", "text",  "an integer",
                                        "a number",  "true",     "false", "null"};
    return names[json_typeof(value)];
}

/* Some writers print integers as 24.0: taken for what they are. */
static int whole_number(const json_t *value, int64_t *out) {
    if (json_is_integer(value)) {
        *out = json_integer_value(value);
        return 1;
    }
    double real = json_is_real(value) ? json_real_value(value) : 0.5;
    if (fabs(real) > 9007199254740992.0 || real != floor(real))
        return 0;
    *out = (int64_t)real;
    return 1;
}

static size_t elements_of(const checker *c, const char *array) {
    const json_t *from = c->root;
    if (strcmp(array, "lights") == 0)
        from = json_object_get(json_object_get(from, "extensions"), "KHR_lights_punctual");
    return json_array_size(json_object_get(from, array));
}

static strata_result check_index(checker *c, const json_t *value, const char *of, json_t **mended) {
    int64_t index;
    if (!whole_number(value, &index))
        return fail(c, "must be an index, is %s", type_name(value));
    size_t count = elements_of(c, of);
    if (index < 0 || (uint64_t)index >= count)
        return fail(c, "there is no %s[%lld] (%zu exist)", of, (long long)index, count);
    if (json_is_real(value))
        *mended = json_integer(index);
    return STRATA_OK;
}

static strata_result check_count(checker *c, const json_t *value, int64_t limit, json_t **mended) {
    int64_t count;
    if (!whole_number(value, &count))
        return fail(c, "must be a whole number, is %s", type_name(value));
    if (count < 0 || count > limit)
        return fail(c, "%lld is out of range", (long long)count);
    if (json_is_real(value))
        *mended = json_integer(count);
    return STRATA_OK;
}

/* Is `text` one of those in "a|b|c"? */
static int among(const char *text, const char *choices) {
    size_t length = strlen(text);
    for (const char *at = choices; at; at = strchr(at, '|') ? strchr(at, '|') + 1 : NULL)
        if (length > 0 && strncmp(at, text, length) == 0 && (at[length] == '|' || !at[length]))
            return 1;
    return 0;
}

static strata_result check_code(checker *c, const json_t *value, const char *of, json_t **mended) {
    int64_t code;
    char text[32];
    if (!whole_number(value, &code))
        return fail(c, "must be a whole number, is %s", type_name(value));
    snprintf(text, sizeof text, "%lld", (long long)code);
    if (!among(text, of))
        return fail(c, "%s is none of %s", text, of);
    if (json_is_real(value))
        *mended = json_integer(code);
    return STRATA_OK;
}

static strata_result check_number(checker *c, const json_t *value, int positive) {
    if (!json_is_number(value))
        return fail(c, "must be a number, is %s", type_name(value));
    double number = json_number_value(value);
    if (!(fabs(number) <= (double)FLT_MAX))
        return fail(c, "%g is beyond what a float holds", number);
    if (positive && !(number > 0.0))
        return fail(c, "must be above 0, is %g", number);
    return STRATA_OK;
}

static strata_result check_text(checker *c, const json_t *value, const char *choices) {
    if (!json_is_string(value))
        return fail(c, "must be text, is %s", type_name(value));
    if (choices && !among(json_string_value(value), choices))
        return fail(c, "'%.40s' is none of %s", json_string_value(value), choices);
    return STRATA_OK;
}

/* ---- arrays and objects ---------------------------------------------------------------------- */

static strata_result check_map(checker *c, json_t *map, const char *of) {
    const char *key;
    json_t *value;
    void *next;
    if (!json_is_object(map))
        return fail(c, "must be an object, is %s", type_name(map));
    json_object_foreach_safe(map, next, key, value) {
        json_t *mended = NULL;
        size_t before = enter_key(c, key);
        strata_result result = check_index(c, value, of, &mended);
        if (result != STRATA_OK)
            return result;
        leave(c, before);
        if (mended)
            json_object_set_new(map, key, mended);
    }
    return STRATA_OK;
}

static strata_result check_element(checker *c, json_t *element, const rule *r, json_t **mended) {
    switch (r->kind) {
    case RULE_INDICES:
        return check_index(c, element, r->of, mended);
    case RULE_MAPS:
        return check_map(c, element, r->of);
    case RULE_NUMBERS:
        return check_number(c, element, 0);
    case RULE_TEXTS:
        return check_text(c, element, NULL);
    default:
        return check_object(c, element, r->members);
    }
}

static strata_result check_array(checker *c, json_t *array, const rule *r) {
    if (!json_is_array(array))
        return fail(c, "must be an array, is %s", type_name(array));
    size_t count = json_array_size(array);
    if (r->kind == RULE_NUMBERS && r->size != 0 && count != r->size)
        return fail(c, "must hold %u numbers, holds %zu", r->size, count);
    if (r->kind != RULE_NUMBERS && count > MAX_ELEMENTS)
        return fail(c, "has %zu elements, the limit is %u", count, MAX_ELEMENTS);
    for (size_t i = 0; i < count; i++) {
        json_t *mended = NULL;
        size_t before = enter_element(c, i);
        strata_result result = check_element(c, json_array_get(array, i), r, &mended);
        if (result != STRATA_OK)
            return result;
        leave(c, before);
        if (mended)
            json_array_set_new(array, i, mended);
    }
    return STRATA_OK;
}

static strata_result check_member(checker *c, json_t *value, const rule *r, json_t **mended) {
    switch (r->kind) {
    case RULE_INDEX:
        return check_index(c, value, r->of, mended);
    case RULE_COUNT:
        return check_count(c, value, INT64_C(9007199254740992), mended);
    case RULE_SMALL:
        return check_count(c, value, INT32_MAX, mended);
    case RULE_CODE:
        return check_code(c, value, r->of, mended);
    case RULE_NUMBER:
    case RULE_POSITIVE:
        return check_number(c, value, r->kind == RULE_POSITIVE);
    case RULE_TEXT:
    case RULE_CHOICE:
        return check_text(c, value, r->of);
    case RULE_FLAG:
        return json_is_boolean(value) ? STRATA_OK
                                      : fail(c, "must be true or false, is %s", type_name(value));
    case RULE_MAP:
        return check_map(c, value, r->of);
    case RULE_OBJECT:
        return check_object(c, value, r->members);
    default:
        return check_array(c, value, r);
    }
}

static const rule *find_rule(const rule *members, const char *key) {
    for (const rule *r = members; r->key; r++)
        if (strcmp(r->key, key) == 0)
            return r;
    return NULL;
}

/* Recursion ends with the rules: they nest eight deep. */
static strata_result check_object(checker *c, json_t *object, const rule *members) {
    const char *key;
    json_t *value;
    void *next;
    if (!json_is_object(object))
        return fail(c, "must be an object, is %s", type_name(object));
    json_object_foreach_safe(object, next, key, value) {
        const rule *r = find_rule(members, key);
        if (!r) {
            json_object_del(object, key);
            continue;
        }
        json_t *mended = NULL;
        size_t before = enter_key(c, key);
        strata_result result = check_member(c, value, r, &mended);
        if (result != STRATA_OK)
            return result;
        leave(c, before);
        if (mended)
            json_object_set_new(object, key, mended);
    }
    for (const rule *r = members; r->key; r++)
        if (r->required && !json_object_get(object, r->key))
            return fail(c, "has no '%s'", r->key);
    return STRATA_OK;
}

/* ---- the whole file -------------------------------------------------------------------------- */

/* tinygltf's JSON library and ours recurse or keep stacks per level: refuse depth before either. */
static strata_result check_depth(checker *c, const char *json, size_t size) {
    size_t depth = 0, line = 1;
    int inside = 0;
    for (size_t i = 0; i < size; i++) {
        char at = json[i];
        line += at == '\n';
        if (inside && at == '\\')
            i++;
        else if (at == '"')
            inside = !inside;
        else if (!inside && (at == '{' || at == '['))
            depth++;
        else if (!inside && (at == '}' || at == ']') && depth > 0)
            depth--;
        if (depth > MAX_DEPTH)
            return fail(c, "JSON line %zu: more than %d nested objects and arrays", line,
                        MAX_DEPTH);
    }
    return STRATA_OK;
}

static int is_supported(const char *extension) {
    for (size_t i = 0; i < BASE_COUNT(supported_extensions); i++)
        if (strcmp(supported_extensions[i], extension) == 0)
            return 1;
    return 0;
}

static strata_result check_extensions(checker *c, scene *s) {
    const json_t *required = json_object_get(c->root, "extensionsRequired");
    const json_t *used = json_object_get(c->root, "extensionsUsed");
    for (size_t i = 0; i < json_array_size(required); i++) {
        const char *extension = json_string_value(json_array_get(required, i));
        if (!is_supported(extension))
            return fail(c, "extensionsRequired[%zu]: %.80s is not supported", i, extension);
    }
    for (size_t i = 0; i < json_array_size(used); i++) {
        const char *extension = json_string_value(json_array_get(used, i));
        if (!is_supported(extension))
            scene_warn(s, "%s: extension %.80s is not supported: ignored", c->name, extension);
    }
    return STRATA_OK;
}

/* Before the members are looked at, since those of other versions are different ones. */
static strata_result check_version(checker *c) {
    const json_t *asset = json_object_get(c->root, "asset");
    const char *version = json_string_value(json_object_get(asset, "version"));
    const char *least = json_string_value(json_object_get(asset, "minVersion"));
    if (version && strncmp(version, "2.", 2) != 0)
        return fail(c, "asset.version: '%.20s' is not supported, only 2.0 is", version);
    if (least && strcmp(least, "2.0") != 0)
        return fail(c, "asset.minVersion: '%.20s' is not supported, only 2.0 is", least);
    return STRATA_OK;
}

/* The member that a camera's or light's type asks for. */
static strata_result check_kind(checker *c, const char *array, const json_t *list) {
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *element = json_array_get(list, i);
        const char *type = json_string_value(json_object_get(element, "type"));
        int plain = strcmp(type, "point") == 0 || strcmp(type, "directional") == 0;
        if (!plain && !json_object_get(element, type))
            return fail(c, "%s[%zu]: has no '%s'", array, i, type);
    }
    return STRATA_OK;
}

static strata_result check_kinds(checker *c) {
    const json_t *lights = json_object_get(
        json_object_get(json_object_get(c->root, "extensions"), "KHR_lights_punctual"), "lights");
    strata_result result = check_kind(c, "cameras", json_object_get(c->root, "cameras"));
    return result == STRATA_OK ? check_kind(c, "lights", lights) : result;
}

/* tinygltf refuses indices whose accessor has no view, which sparse ones need not have: they travel
 * among the attributes. */
static int disguise_indices(const checker *c) {
    const json_t *meshes = json_object_get(c->root, "meshes");
    for (size_t m = 0; m < json_array_size(meshes); m++) {
        const json_t *primitives = json_object_get(json_array_get(meshes, m), "primitives");
        for (size_t p = 0; p < json_array_size(primitives); p++) {
            json_t *primitive = json_array_get(primitives, p);
            json_t *attributes = json_object_get(primitive, "attributes");
            json_t *indices = json_object_get(primitive, "indices");
            json_object_del(attributes, GLTF_INDICES);
            if (indices && json_object_set(attributes, GLTF_INDICES, indices) != 0)
                return 0;
            json_object_del(primitive, "indices");
        }
    }
    return 1;
}

static uint32_t index_or_none(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return value ? (uint32_t)json_integer_value(value) : SCENE_NONE;
}

/* Buffers and images never reach tinygltf: files and pictures are read by our own code. */
static strata_result take_buffers_and_images(checker *c, gltf_document *document) {
    const json_t *buffers = json_object_get(c->root, "buffers");
    const json_t *images = json_object_get(c->root, "images");
    document->buffer_count = (uint32_t)json_array_size(buffers);
    document->image_count = (uint32_t)json_array_size(images);
    document->buffers = base_calloc(document->buffer_count, sizeof *document->buffers);
    document->images = base_calloc(document->image_count, sizeof *document->images);
    if (!document->buffers || !document->images)
        return base_fail(c->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", c->name);
    for (uint32_t i = 0; i < document->buffer_count; i++) {
        const json_t *buffer = json_array_get(buffers, i);
        document->buffers[i] = (gltf_buffer){
            .uri = json_string_value(json_object_get(buffer, "uri")),
            .length = (uint64_t)json_integer_value(json_object_get(buffer, "byteLength")),
        };
    }
    for (uint32_t i = 0; i < document->image_count; i++) {
        const json_t *image = json_array_get(images, i);
        document->images[i] = (gltf_image){
            .name = json_string_value(json_object_get(image, "name")),
            .uri = json_string_value(json_object_get(image, "uri")),
            .mime = json_string_value(json_object_get(image, "mimeType")),
            .view = index_or_none(image, "bufferView"),
        };
    }
    return STRATA_OK;
}

/* The root without buffers and images as text. */
static strata_result print_rest(checker *c, gltf_document *document) {
    json_t *rest = disguise_indices(c) ? json_copy(c->root) : NULL;
    if (rest) {
        json_object_del(rest, "buffers");
        json_object_del(rest, "images");
        document->text = json_dumps(rest, JSON_COMPACT);
        json_decref(rest);
    }
    if (!document->text)
        return base_fail(c->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", c->name);
    document->text_size = strlen(document->text);
    return STRATA_OK;
}

strata_result gltf_check(scene *s, const char *json, size_t size, gltf_document *document,
                         base_error *err) {
    checker c = {.name = s->path, .err = err};
    json_error_t trouble;
    *document = (gltf_document){0};
    size_t blank = 0;
    while (blank < size && json[blank] && strchr(" \t\r\n", json[blank]))
        blank++;
    if (blank == size || json[blank] != '{')
        return fail(&c, "is neither a GLB nor a JSON object");
    strata_result result = check_depth(&c, json, size);
    if (result != STRATA_OK)
        return result;
    c.root = document->root = json_loadb(json, size, 0, &trouble);
    if (!c.root)
        return fail(&c, "JSON line %d, column %d: %.160s", trouble.line, trouble.column,
                    trouble.text);
    result = check_version(&c);
    if (result == STRATA_OK)
        result = check_object(&c, c.root, root_rules);
    leave(&c, 0);
    if (result == STRATA_OK)
        result = check_extensions(&c, s);
    if (result == STRATA_OK)
        result = check_kinds(&c);
    if (result == STRATA_OK)
        result = take_buffers_and_images(&c, document);
    if (result == STRATA_OK)
        result = print_rest(&c, document);
    if (result != STRATA_OK)
        gltf_document_free(document);
    return result;
}

void gltf_document_free(gltf_document *document) {
    for (uint32_t i = 0; i < document->buffer_count && document->buffers; i++)
        free(document->buffers[i].owned);
    free(document->buffers);
    free(document->images);
    free(document->text);
    json_decref(document->root);
    *document = (gltf_document){0};
}
