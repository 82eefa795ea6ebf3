/* SPDX-License-Identifier: MIT
 *
 * The one C++ file of the loader: checked JSON through tinygltf into the flat view of gltf.h. It
 * opens no file and decodes no image, and nothing is thrown out of it. The view's strings and
 * number arrays are tinygltf's own, kept alive by the owner.
 */
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <fstream>
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <tiny_gltf.h>
#pragma GCC diagnostic pop

extern "C" {
#include "scene/gltf.h"
}

#include <deque>
#include <vector>

namespace {

using tinygltf::ExtensionMap;
using tinygltf::Value;

/* Arrays inside arrays live in deques of vectors: their addresses stay put as more are added. */
struct Owner {
    tinygltf::Model model;
    std::vector<gltf_view> views;
    std::vector<gltf_accessor> accessors;
    std::vector<gltf_mesh> meshes;
    std::vector<gltf_node> nodes;
    std::vector<gltf_material> materials;
    std::vector<gltf_texture> textures;
    std::vector<gltf_sampler> samplers;
    std::vector<gltf_channel> channels;
    std::vector<gltf_skin> skins;
    std::vector<scene_camera> cameras;
    std::vector<scene_light> lights;
    std::vector<gltf_scene_list> scenes;
    std::deque<std::vector<gltf_attribute>> attributes;
    std::deque<std::vector<gltf_attributes>> targets;
    std::deque<std::vector<gltf_primitive>> primitives;
};

uint32_t index_of(int value) {
    return value < 0 ? SCENE_NONE : static_cast<uint32_t>(value);
}

const char *text_of(const std::string &text) {
    return text.empty() ? nullptr : text.c_str();
}

/* ---- members of extension objects, which the check has already held against the rules ---- */

const Value *find(const ExtensionMap &extensions, const char *name) {
    auto at = extensions.find(name);
    return at == extensions.end() ? nullptr : &at->second;
}

double number(const Value &object, const char *key, double otherwise) {
    return object.Has(key) && object.Get(key).IsNumber() ? object.Get(key).GetNumberAsDouble()
                                                         : otherwise;
}

void numbers(const Value &object, const char *key, double *out, size_t count) {
    if (!object.Has(key))
        return;
    const Value &array = object.Get(key);
    for (size_t i = 0; i < count && i < array.ArrayLen(); i++)
        out[i] = array.Get(static_cast<int>(i)).GetNumberAsDouble();
}

/* ---- materials ---- */

void read_transform(const ExtensionMap &extensions, gltf_texture_use *use) {
    const Value *transform = find(extensions, "KHR_texture_transform");
    if (!transform)
        return;
    numbers(*transform, "offset", use->offset, 2);
    numbers(*transform, "scale", use->scale, 2);
    use->rotation = number(*transform, "rotation", 0.0);
    use->uv = static_cast<uint32_t>(number(*transform, "texCoord", use->uv));
}

gltf_texture_use no_texture() {
    gltf_texture_use use = {};
    use.texture = SCENE_NONE;
    use.scale[0] = use.scale[1] = 1.0;
    return use;
}

template <typename Info> gltf_texture_use texture_use(const Info &info) {
    gltf_texture_use use = no_texture();
    use.texture = index_of(info.index);
    use.uv = static_cast<uint32_t>(info.texCoord);
    read_transform(info.extensions, &use);
    return use;
}

void read_transmission(const Value &transmission, gltf_material *out) {
    out->values.transmission = static_cast<float>(number(transmission, "transmissionFactor", 0.0));
    if (!transmission.Has("transmissionTexture"))
        return;
    const Value &info = transmission.Get("transmissionTexture");
    out->transmission.texture = static_cast<uint32_t>(number(info, "index", 0.0));
    out->transmission.uv = static_cast<uint32_t>(number(info, "texCoord", 0.0));
    if (info.Has("extensions") && info.Get("extensions").IsObject())
        read_transform(info.Get("extensions").Get<Value::Object>(), &out->transmission);
}

void read_material_extensions(const ExtensionMap &extensions, gltf_material *out) {
    double strength = 1.0;
    if (const Value *emissive = find(extensions, "KHR_materials_emissive_strength"))
        strength = number(*emissive, "emissiveStrength", 1.0);
    for (float &channel : out->values.emissive)
        channel = static_cast<float>(channel * strength);
    if (const Value *ior = find(extensions, "KHR_materials_ior"))
        out->values.ior = static_cast<float>(number(*ior, "ior", 1.5));
    if (const Value *transmission = find(extensions, "KHR_materials_transmission"))
        read_transmission(*transmission, out);
    out->values.unlit = find(extensions, "KHR_materials_unlit") ? 1 : 0;
}

gltf_material material_of(const tinygltf::Material &m) {
    gltf_material out = {};
    const tinygltf::PbrMetallicRoughness &pbr = m.pbrMetallicRoughness;
    out.values = scene_default_material();
    out.name = text_of(m.name);
    out.values.alpha = m.alphaMode == "MASK"    ? SCENE_MASK
                       : m.alphaMode == "BLEND" ? SCENE_BLEND
                                                : SCENE_OPAQUE;
    out.values.alpha_cutoff = static_cast<float>(m.alphaCutoff);
    for (size_t i = 0; i < 4; i++)
        out.values.base_color[i] = static_cast<float>(pbr.baseColorFactor[i]);
    out.values.metallic = static_cast<float>(pbr.metallicFactor);
    out.values.roughness = static_cast<float>(pbr.roughnessFactor);
    for (size_t i = 0; i < 3; i++)
        out.values.emissive[i] = static_cast<float>(m.emissiveFactor[i]);
    out.values.normal_scale = static_cast<float>(m.normalTexture.scale);
    out.values.occlusion_strength = static_cast<float>(m.occlusionTexture.strength);
    out.values.double_sided = m.doubleSided ? 1 : 0;
    out.base_color = texture_use(pbr.baseColorTexture);
    out.metallic_roughness = texture_use(pbr.metallicRoughnessTexture);
    out.normal = texture_use(m.normalTexture);
    out.occlusion = texture_use(m.occlusionTexture);
    out.emissive = texture_use(m.emissiveTexture);
    out.transmission = no_texture();
    read_material_extensions(m.extensions, &out);
    return out;
}

/* ---- geometry ---- */

gltf_accessor accessor_of(const tinygltf::Accessor &a) {
    gltf_accessor out = {};
    out.view = index_of(a.bufferView);
    out.offset = a.byteOffset;
    out.count = a.count;
    out.component = static_cast<gltf_component>(a.componentType);
    out.width =
        static_cast<uint32_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(a.type)));
    out.columns = a.type == TINYGLTF_TYPE_MAT2   ? 2
                  : a.type == TINYGLTF_TYPE_MAT3 ? 3
                  : a.type == TINYGLTF_TYPE_MAT4 ? 4
                                                 : 1;
    out.normalized = a.normalized ? 1 : 0;
    if (a.sparse.isSparse) {
        out.sparse_count = static_cast<uint64_t>(a.sparse.count);
        out.sparse_index_view = index_of(a.sparse.indices.bufferView);
        out.sparse_index_offset = static_cast<uint64_t>(a.sparse.indices.byteOffset);
        out.sparse_index_component = static_cast<gltf_component>(a.sparse.indices.componentType);
        out.sparse_value_view = index_of(a.sparse.values.bufferView);
        out.sparse_value_offset = static_cast<uint64_t>(a.sparse.values.byteOffset);
    }
    return out;
}

gltf_attributes attributes_of(Owner *o, const std::map<std::string, int> &map) {
    std::vector<gltf_attribute> list;
    for (const auto &entry : map)
        list.push_back({entry.first.c_str(), index_of(entry.second)});
    o->attributes.push_back(std::move(list));
    return {o->attributes.back().data(), static_cast<uint32_t>(map.size())};
}

gltf_mesh mesh_of(Owner *o, const tinygltf::Mesh &m) {
    std::vector<gltf_primitive> primitives;
    for (const tinygltf::Primitive &p : m.primitives) {
        gltf_primitive out = {};
        std::vector<gltf_attributes> targets;
        for (const auto &target : p.targets)
            targets.push_back(attributes_of(o, target));
        o->targets.push_back(std::move(targets));
        out.attributes = attributes_of(o, p.attributes);
        out.targets = o->targets.back().data();
        out.target_count = static_cast<uint32_t>(p.targets.size());
        out.material = index_of(p.material);
        auto indices = p.attributes.find(GLTF_INDICES);
        out.indices = indices == p.attributes.end() ? SCENE_NONE : index_of(indices->second);
        out.mode = static_cast<uint32_t>(p.mode);
        primitives.push_back(out);
    }
    o->primitives.push_back(std::move(primitives));
    return {text_of(m.name), o->primitives.back().data(),
            static_cast<uint32_t>(m.primitives.size()), static_cast<uint32_t>(m.weights.size()),
            m.weights.data()};
}

/* ---- nodes and what hangs from them ---- */

void read_instancing(Owner *o, const Value &instancing, gltf_node *out) {
    if (!instancing.Has("attributes") || !instancing.Get("attributes").IsObject())
        return;
    std::vector<gltf_attribute> list;
    for (const auto &entry : instancing.Get("attributes").Get<Value::Object>())
        list.push_back({entry.first.c_str(), index_of(entry.second.GetNumberAsInt())});
    o->attributes.push_back(std::move(list));
    out->instancing.items = o->attributes.back().data();
    out->instancing.count = static_cast<uint32_t>(o->attributes.back().size());
}

gltf_node node_of(Owner *o, const tinygltf::Node &n) {
    gltf_node out = {};
    out.name = text_of(n.name);
    out.children = n.children.data();
    out.child_count = static_cast<uint32_t>(n.children.size());
    out.mesh = index_of(n.mesh);
    out.skin = index_of(n.skin);
    out.camera = index_of(n.camera);
    out.light = SCENE_NONE;
    out.matrix = n.matrix.size() == 16 ? n.matrix.data() : nullptr;
    out.rotation[3] = out.scale[0] = out.scale[1] = out.scale[2] = 1.0;
    std::copy(n.translation.begin(), n.translation.end(), out.translation);
    std::copy(n.rotation.begin(), n.rotation.end(), out.rotation);
    std::copy(n.scale.begin(), n.scale.end(), out.scale);
    out.weights = n.weights.data();
    out.weight_count = static_cast<uint32_t>(n.weights.size());
    if (const Value *light = find(n.extensions, "KHR_lights_punctual"))
        out.light = static_cast<uint32_t>(number(*light, "light", 0.0));
    if (const Value *instancing = find(n.extensions, "EXT_mesh_gpu_instancing"))
        read_instancing(o, *instancing, &out);
    return out;
}

scene_camera camera_of(const tinygltf::Camera &c) {
    scene_camera out = {};
    bool flat = c.type == "orthographic";
    out.name = const_cast<char *>(text_of(c.name));
    out.node = SCENE_NONE;
    out.projection = flat ? SCENE_ORTHOGRAPHIC : SCENE_PERSPECTIVE;
    out.yfov = static_cast<float>(c.perspective.yfov);
    out.aspect = static_cast<float>(c.perspective.aspectRatio);
    out.znear = static_cast<float>(flat ? c.orthographic.znear : c.perspective.znear);
    out.zfar = static_cast<float>(flat ? c.orthographic.zfar : c.perspective.zfar);
    out.xmag = static_cast<float>(c.orthographic.xmag);
    out.ymag = static_cast<float>(c.orthographic.ymag);
    scene_identity(out.world);
    return out;
}

scene_light light_of(const tinygltf::Light &l) {
    scene_light out = {};
    out.name = const_cast<char *>(text_of(l.name));
    out.node = SCENE_NONE;
    out.kind = l.type == "spot" ? SCENE_SPOT : l.type == "point" ? SCENE_POINT : SCENE_DIRECTIONAL;
    for (size_t i = 0; i < 3; i++)
        out.color[i] = static_cast<float>((l.color.size() == 3 ? l.color[i] : 1.0) * l.intensity);
    out.range = static_cast<float>(l.range);
    out.inner_cos = static_cast<float>(std::cos(l.spot.innerConeAngle));
    out.outer_cos = static_cast<float>(std::cos(l.spot.outerConeAngle));
    out.direction[2] = -1.0f;
    return out;
}

gltf_path path_of(const std::string &path) {
    return path == "translation" ? GLTF_TRANSLATION
           : path == "rotation"  ? GLTF_ROTATION
           : path == "scale"     ? GLTF_SCALE
                                 : GLTF_WEIGHTS;
}

/* False when a channel names a sampler that its animation does not have. */
bool read_channels(Owner *o, const char *name, base_error *err) {
    for (size_t a = 0; a < o->model.animations.size(); a++) {
        const tinygltf::Animation &animation = o->model.animations[a];
        for (size_t i = 0; i < animation.channels.size(); i++) {
            const tinygltf::AnimationChannel &channel = animation.channels[i];
            if (channel.target_node < 0 || channel.target_path == "pointer")
                continue;
            if (channel.sampler < 0 || size_t(channel.sampler) >= animation.samplers.size()) {
                base_fail(err, STRATA_ERROR_BAD_FILE,
                          "%s: animations[%zu].channels[%zu].sampler: there is no sampler %d", name,
                          a, i, channel.sampler);
                return false;
            }
            const tinygltf::AnimationSampler &sampler =
                animation.samplers[static_cast<size_t>(channel.sampler)];
            gltf_interpolation interpolation = sampler.interpolation == "STEP" ? GLTF_STEP
                                               : sampler.interpolation == "CUBICSPLINE"
                                                   ? GLTF_CUBIC
                                                   : GLTF_LINEAR;
            o->channels.push_back({static_cast<uint32_t>(a), static_cast<uint32_t>(i),
                                   index_of(channel.target_node), index_of(sampler.input),
                                   index_of(sampler.output), path_of(channel.target_path),
                                   interpolation});
        }
    }
    return true;
}

void read_model(Owner *o) {
    const tinygltf::Model &m = o->model;
    for (const auto &v : m.bufferViews)
        o->views.push_back(
            {index_of(v.buffer), v.byteOffset, v.byteLength, static_cast<uint32_t>(v.byteStride)});
    for (const auto &a : m.accessors)
        o->accessors.push_back(accessor_of(a));
    for (const auto &mesh : m.meshes)
        o->meshes.push_back(mesh_of(o, mesh));
    for (const auto &n : m.nodes)
        o->nodes.push_back(node_of(o, n));
    for (const auto &material : m.materials)
        o->materials.push_back(material_of(material));
    for (const auto &t : m.textures)
        o->textures.push_back({index_of(t.sampler), index_of(t.source)});
    for (const auto &s : m.samplers)
        o->samplers.push_back({s.magFilter, s.minFilter, s.wrapS, s.wrapT});
    for (const auto &s : m.skins)
        o->skins.push_back({s.joints.data(), static_cast<uint32_t>(s.joints.size()),
                            index_of(s.inverseBindMatrices)});
    for (const auto &c : m.cameras)
        o->cameras.push_back(camera_of(c));
    for (const auto &l : m.lights)
        o->lights.push_back(light_of(l));
    for (const auto &s : m.scenes)
        o->scenes.push_back({s.nodes.data(), static_cast<uint32_t>(s.nodes.size())});
}

template <typename T> void publish(const std::vector<T> &from, const T **items, uint32_t *count) {
    *items = from.data();
    *count = static_cast<uint32_t>(from.size());
}

void fill(const Owner &o, gltf_file *file) {
    publish(o.views, &file->views, &file->view_count);
    publish(o.accessors, &file->accessors, &file->accessor_count);
    publish(o.meshes, &file->meshes, &file->mesh_count);
    publish(o.nodes, &file->nodes, &file->node_count);
    publish(o.materials, &file->materials, &file->material_count);
    publish(o.textures, &file->textures, &file->texture_count);
    publish(o.samplers, &file->samplers, &file->sampler_count);
    publish(o.channels, &file->channels, &file->channel_count);
    publish(o.skins, &file->skins, &file->skin_count);
    publish(o.cameras, &file->cameras, &file->camera_count);
    publish(o.lights, &file->lights, &file->light_count);
    publish(o.scenes, &file->scenes, &file->scene_count);
    file->scene = index_of(o.model.defaultScene);
}

strata_result parse(const char *name, const char *text, size_t size, Owner *o, gltf_file *file,
                    base_error *err) {
    std::string trouble, remarks;
    if (size > 0xffffffffu)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: the JSON is too long", name);
    tinygltf::TinyGLTF loader;
    if (!loader.LoadASCIIFromString(&o->model, &trouble, &remarks, text,
                                    static_cast<unsigned int>(size), ""))
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: %s", name,
                         trouble.substr(0, trouble.find_first_of("\r\n")).c_str());
    if (!read_channels(o, name, err))
        return STRATA_ERROR_BAD_FILE;
    read_model(o);
    fill(*o, file);
    return STRATA_OK;
}

} // namespace

strata_result gltf_parse(const char *name, const char *text, size_t size, gltf_file *file,
                         base_error *err) {
    Owner *o = nullptr;
    strata_result result;
    try {
        o = new Owner;
        result = parse(name, text, size, o, file, err);
    } catch (const std::bad_alloc &) {
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", name);
    } catch (const std::exception &e) {
        result = base_fail(err, STRATA_ERROR_BAD_FILE, "%s: %s", name, e.what());
    } catch (...) {
        result = base_fail(err, STRATA_ERROR_BAD_FILE, "%s: tinygltf gave up", name);
    }
    if (result == STRATA_OK)
        file->owner = o;
    else
        delete o;
    return result;
}

void gltf_parse_free(gltf_file *file) {
    delete static_cast<Owner *>(file->owner);
    file->owner = nullptr;
}
