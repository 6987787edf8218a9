// glTF 2.0: converts metallic-roughness materials and their images to the nearest material.
#include "viscache/formats/gltf_reader.h"

#include "viscache/formats/decode_image.h"

namespace viscache::loading {

namespace {

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/// Decodes URL escapes such as "%20".
std::string url_decoded(const std::string& uri) {
    std::string out;
    for (size_t i = 0; i < uri.size(); ++i) {
        const int high = uri[i] == '%' && i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
        const int low = high >= 0 ? hex_digit(uri[i + 2]) : -1;
        if (low >= 0) {
            out += char(high * 16 + low);
            i += 2;
        } else {
            out += uri[i];
        }
    }
    return out;
}

Rgb gltf_rgb(const std::vector<double>& v, Rgb fallback) {
    return v.size() >= 3 ? Rgb{float(v[0]), float(v[1]), float(v[2])} : fallback;
}

/// A value of KHR_texture_transform.
const tinygltf::Value* transform_value(const tinygltf::TextureInfo& info, const char* name) {
    const auto found = info.extensions.find("KHR_texture_transform");
    if (found == info.extensions.end() || !found->second.IsObject() || !found->second.Has(name)) return {};
    return &found->second.Get(name);
}

int coordinates_of(const tinygltf::TextureInfo& info) {
    const tinygltf::Value* given = transform_value(info, "texCoord");
    return given && given->IsInt() ? given->GetNumberAsInt() : info.texCoord;
}

/// First scaled, then turned counter-clockwise, then moved; v grows downwards.
UvTransform uv_transform(const tinygltf::TextureInfo& info) {
    const auto pair = [&](const char* name, double fallback) -> std::array<double, 2> {
        const tinygltf::Value* v = transform_value(info, name);
        if (!v || !v->IsArray() || v->ArrayLen() != 2 || !v->Get(0).IsNumber() || !v->Get(1).IsNumber())
            return {fallback, fallback};
        return {v->Get(0).GetNumberAsDouble(), v->Get(1).GetNumberAsDouble()};
    };
    const tinygltf::Value* turned = transform_value(info, "rotation");
    const double angle = turned && turned->IsNumber() ? turned->GetNumberAsDouble() : 0;
    const double c = std::cos(angle), s = std::sin(angle);
    const auto [x, y] = pair("scale", 1);
    const auto [u, v] = pair("offset", 0);
    return {{{c * x, s * y, u}, {-s * x, c * y, v}}};
}

constexpr const char *kGlossiness = "KHR_materials_pbrSpecularGlossiness",
                     *kTransform = "KHR_texture_transform", *kVolume = "KHR_materials_volume";
/// Roughness below which transmission counts as smooth: the smallest lobe.
constexpr float kSmoothGlass = 1e-3f;

/// The extension of an object; nullptr if it has none.
const tinygltf::Value* extension_of(const tinygltf::ExtensionMap& extensions, const char* name) {
    const auto found = extensions.find(name);
    return found != extensions.end() && found->second.IsObject() ? &found->second : nullptr;
}

/// The `n` numbers of an array; empty if it is no such array.
std::vector<double> numbers_of(const tinygltf::Value& value, int n) {
    if (!value.IsArray() || value.ArrayLen() != size_t(n)) return {};
    std::vector<double> numbers;
    for (int i = 0; i < n; ++i) {
        if (!value.Get(i).IsNumber()) return {};
        numbers.push_back(value.Get(i).GetNumberAsDouble());
    }
    return numbers;
}

Rgb specular_of_glossiness(const tinygltf::Value& extension) {
    return clamp01(gltf_rgb(numbers_of(extension.Get("specularFactor"), 3), {1, 1, 1}));
}

/// The texture coordinates of a mesh are those of the first of these images.
int texcoord_of(const tinygltf::Material& in) {
    const auto& pbr = in.pbrMetallicRoughness;
    for (const auto& info : {pbr.baseColorTexture, pbr.metallicRoughnessTexture, in.emissiveTexture})
        if (info.index >= 0) return coordinates_of(info);
    return 0;
}

}  // namespace

int GltfReader::image_source(int texture, const std::string& where) const {
    if (texture < 0 || size_t(texture) >= model_.textures.size())
        fail(where, "texture " + std::to_string(texture) + ", the file has " +
                        std::to_string(model_.textures.size()));
    const int source = model_.textures[size_t(texture)].source;
    if (source >= 0 && size_t(source) >= model_.images.size())
        fail(where,
             "image " + std::to_string(source) + ", the file has " + std::to_string(model_.images.size()));
    return source;
}

std::string GltfReader::image_path(int source) const {
    const tinygltf::Image& image = model_.images[size_t(source)];
    return image.uri.empty() || !image.image.empty() ? "" : resolve(path_, url_decoded(image.uri));
}

std::string GltfReader::image_bytes(int source, const std::string& where) const {
    const tinygltf::Image& image = model_.images[size_t(source)];
    if (!image.image.empty()) return {image.image.begin(), image.image.end()};
    if (image.bufferView < 0) return read_file(image_path(source), where);
    if (size_t(image.bufferView) >= model_.bufferViews.size())
        fail(where, "the image's buffer view does not exist");
    const tinygltf::BufferView& view = model_.bufferViews[size_t(image.bufferView)];
    if (view.buffer < 0 || size_t(view.buffer) >= model_.buffers.size())
        fail(where, "the image's buffer does not exist");
    const auto& data = model_.buffers[size_t(view.buffer)].data;
    if (view.byteOffset > data.size() || view.byteLength > data.size() - view.byteOffset)
        fail(where, "the image does not fit into its buffer");
    return {data.begin() + std::ptrdiff_t(view.byteOffset),
            data.begin() + std::ptrdiff_t(view.byteOffset + view.byteLength)};
}

/// A decoded copy, for means and single channels. Empty if the image cannot be read and that is not an
/// error.
std::optional<viscache::Image> GltfReader::decoded(int texture, bool srgb, const std::string& where) {
    const int source = image_source(texture, where);
    if (source < 0) return {};
    try {
        return decode_image(image_bytes(source, where), where, srgb);
    } catch (const SceneError& error) {
        loading_.warn(where, std::string(error.what()) + "; the image is left out");
        return {};
    }
}

/// Filter and borders of the texture's sampler.
LookUp GltfReader::look_up(int texture, const std::string& where) const {
    const int index = model_.textures[size_t(texture)].sampler;
    if (index < 0) return {};
    if (size_t(index) >= model_.samplers.size())
        fail(where,
             "sampler " + std::to_string(index) + ", the file has " + std::to_string(model_.samplers.size()));
    const tinygltf::Sampler& in = model_.samplers[size_t(index)];
    const auto wrap = [](int mode) {
        return mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE     ? Wrap::kClamp
               : mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT ? Wrap::kMirror
                                                               : Wrap::kRepeat;
    };
    return {in.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST, wrap(in.wrapS), wrap(in.wrapT)};
}

int GltfReader::add_texture(Look& look, const tinygltf::TextureInfo& info, bool srgb,
                            const std::string& where) {
    const int texture = info.index, source = image_source(texture, where);
    if (source < 0) {
        // Images of formats that an extension brings, without one of glTF itself
        loading_.warn(where, model_.textures[size_t(texture)].extensions.empty()
                                 ? "a texture without an image is left out"
                                 : "the image of a texture's extension is not read; left out");
        return -1;
    }
    if (!look.uv.add(uv_transform(info).downwards()))
        loading_.warn(where,
                      "the images of a material share one transform of texture coordinates; that of the "
                      "first is used");
    const LookUp how = look_up(texture, where);
    if (const std::string path = image_path(source); !path.empty())
        return loading_.add_image(path, where, srgb, how);
    const auto [found, is_new] = embedded_.try_emplace({source, srgb, how}, -1);
    if (is_new)
        if (auto image = decoded(texture, srgb, where)) {
            set_look_up(*image, how);
            loading_.scene.images.push_back(std::move(*image));
            found->second = int(loading_.scene.images.size()) - 1;
        }
    return found->second;
}

double GltfReader::extension_number(const tinygltf::Material& in, const char* extension, const char* name,
                                    double fallback) const {
    const auto found = in.extensions.find(extension);
    if (found == in.extensions.end() || !found->second.IsObject() || !found->second.Has(name))
        return fallback;
    const tinygltf::Value& value = found->second.Get(name);
    return value.IsNumber() ? value.GetNumberAsDouble() : fallback;
}

/// Reflectance at normal incidence of what is no metal (KHR_materials_ior, KHR_materials_specular).
Rgb GltfReader::dielectric_specular(const tinygltf::Material& in, const std::string& where) {
    const float f0 = dielectric_f0(float(extension_number(in, "KHR_materials_ior", "ior", 1.5)));
    const auto found = in.extensions.find("KHR_materials_specular");
    if (found == in.extensions.end() || !found->second.IsObject()) return {f0, f0, f0};
    const Rgb color =
        max({0, 0, 0}, gltf_rgb(numbers_of(found->second.Get("specularColorFactor"), 3), {1, 1, 1}));
    if (found->second.Has("specularTexture") || found->second.Has("specularColorTexture"))
        loading_.warn(where, "a specular image is not modelled; its factor is used");
    const double factor = extension_number(in, "KHR_materials_specular", "specularFactor", 1);
    return clamp01(color * f0) * std::clamp(float(factor), 0.f, 1.f);
}

void GltfReader::alpha(viscache::Material& m, const tinygltf::Material& in, const std::string& where) {
    if (in.alphaMode != "MASK" && in.alphaMode != "BLEND") {
        if (in.alphaMode != "OPAQUE") loading_.warn(where, "an alphaMode of another name is OPAQUE here");
        return;
    }
    const auto& pbr = in.pbrMetallicRoughness;
    const double factor = pbr.baseColorFactor.size() == 4 ? pbr.baseColorFactor[3] : 1;
    const double cutoff = in.alphaCutoff;
    const auto image = m.base_texture >= 0 ? decoded(pbr.baseColorTexture.index, true, where) : std::nullopt;
    if (image && (image->channels == 2 || image->channels == 4)) {
        m.alpha_texture = m.base_texture;
    }
    if (in.alphaMode == "MASK") {
        if (m.alpha_texture < 0) m.opacity = factor < cutoff ? 0.f : 1.f;
        m.alpha_cutoff = factor > 0 ? float(cutoff / factor) : kInfinity;  // of the alpha of vertices
    } else {
        m.alpha_cutoff = -1;
        m.opacity = std::clamp(float(factor), 0.f, 1.f);
    }
}

/// Roughness and metal, by factors or by their image.
void GltfReader::roughness(viscache::Material& m, const tinygltf::Material& in, Look& look,
                           const std::string& where) {
    const auto& pbr = in.pbrMetallicRoughness;
    const auto& given = pbr.metallicRoughnessTexture;
    double metallic = pbr.metallicFactor, roughness = pbr.roughnessFactor;
    if (given.index >= 0 && coordinates_of(given) == look.texcoord) {
        m.metallic_roughness_texture = add_texture(look, given, false, where);
    } else if (given.index >= 0) {
        loading_.warn(where,
                      "a metallic-roughness image with texture coordinates of its own is not modelled; its "
                      "means are used");
        if (const auto image = decoded(given.index, false, where)) {
            const Rgb mean = mean_of(*image).color;
            roughness *= mean.y;
            metallic *= mean.z;
        }
    }
    metallic = std::clamp(metallic, 0.0, 1.0);
    m.roughness = clamp_roughness(float(roughness * roughness));
    if (m.metallic_roughness_texture >= 0 || m.base_texture >= 0 || metallic < 1 || look.colored) {
        m.metallic = float(metallic);
    } else {  // metal everywhere
        m.specular = m.base_color;
        m.base_color = {0, 0, 0};
        m.f90 = 1;
    }
}

/// The material of KHR_materials_pbrSpecularGlossiness in the words of metallic-roughness. Its specular
/// colour is that of `surface`.
tinygltf::Material GltfReader::as_metallic_roughness(tinygltf::Material in, const std::string& where) {
    const tinygltf::Value* given = extension_of(in.extensions, kGlossiness);
    if (!given) return in;
    auto& pbr = in.pbrMetallicRoughness;
    pbr = {};
    pbr.metallicFactor = 0;
    pbr.roughnessFactor = 1 - std::clamp(extension_number(in, kGlossiness, "glossinessFactor", 1), 0.0, 1.0);
    const Rgb specular = specular_of_glossiness(*given);
    const auto diffuse = numbers_of(given->Get("diffuseFactor"), 4);
    if (!diffuse.empty()) pbr.baseColorFactor = diffuse;
    // Its page: the diffuse colour loses the largest channel of the specular one
    for (size_t c = 0; c < 3; ++c) pbr.baseColorFactor[c] *= double(1 - max_component(specular));
    if (const tinygltf::Value& texture = given->Get("diffuseTexture"); texture.IsObject()) {
        pbr.baseColorTexture.index =
            texture.Get("index").IsInt() ? texture.Get("index").GetNumberAsInt() : -1;
        if (texture.Get("texCoord").IsInt())
            pbr.baseColorTexture.texCoord = texture.Get("texCoord").GetNumberAsInt();
        if (texture.Get("extensions").Has(kTransform))
            pbr.baseColorTexture.extensions[kTransform] = texture.Get("extensions").Get(kTransform);
    }
    if (given->Has("specularGlossinessTexture"))
        loading_.warn(where, "an image of specular and glossiness is not modelled; its factors are used");
    return in;
}

/// Warns of layers that are not modelled, where the file switches them on.
void GltfReader::check_layers(const tinygltf::Material& in, const std::string& where) {
    for (const GltfLayer& layer : kGltfLayers) {
        const tinygltf::Value* given = extension_of(in.extensions, layer.extension);
        if (!given) continue;
        const tinygltf::Value& factor = given->Get(layer.factor);
        bool is_on = factor.IsNumber() && factor.GetNumberAsDouble() != 0;
        for (const double channel : numbers_of(factor, 3)) is_on = is_on || channel != 0;
        if (is_on)
            loading_.warn(where,
                          "the extension '" + std::string(layer.extension) + "' is not modelled; ignored");
    }
}

double GltfReader::transmitted_share(const tinygltf::Material& in, const std::string& where) {
    constexpr const char* kTransmission = "KHR_materials_transmission";
    const double share = std::clamp(extension_number(in, kTransmission, "transmissionFactor", 0), 0.0, 1.0);
    if (!(share > 0)) return 0;
    const tinygltf::Value& image = extension_of(in.extensions, kTransmission)->Get("transmissionTexture");
    if (!image.IsObject()) return share;
    loading_.warn(where, "an image of transmission is not modelled; its mean is used");
    const int index = image.Get("index").IsInt() ? image.Get("index").GetNumberAsInt() : -1;
    const auto pixels = decoded(index, false, where);
    return pixels ? share * double(mean_of(*pixels).color.x) : share;
}

/// The tint of one of two surfaces between which light goes the given way.
Rgb GltfReader::attenuation(const tinygltf::Material& in, double thickness, const std::string& where) {
    const double distance = extension_number(in, kVolume, "attenuationDistance", 0);
    const auto color = numbers_of(extension_of(in.extensions, kVolume)->Get("attenuationColor"), 3);
    if (!(distance > 0) || color.empty() ||
        std::all_of(color.begin(), color.end(), [](double c) { return c == 1; }))
        return {1, 1, 1};
    loading_.warn(
        where,
        "attenuation by distance is not modelled; the two surfaces of the glass have the tint of its "
        "thickness");
    const auto kept = [&](double c) {
        return float(std::pow(std::clamp(c, 0.0, 1.0), thickness / distance / 2));
    };
    return {kept(color[0]), kept(color[1]), kept(color[2])};
}

/// KHR_materials_transmission and KHR_materials_volume. Needs the rest of the material.
void GltfReader::transmission(viscache::Material& m, const tinygltf::Material& in, const std::string& where) {
    const double share = transmitted_share(in, where);
    // Metals let nothing through
    if (!(share > 0) || (m.metallic_roughness_texture < 0 && in.pbrMetallicRoughness.metallicFactor >= 1))
        return;
    const double thickness = extension_number(in, kVolume, "thicknessFactor", 0);
    const bool is_solid = thickness > 0, is_whole = m.metallic == 0 && share >= 1;
    const bool is_smooth = m.roughness <= kSmoothGlass;
    m.two_sided = true;
    m.transmission = m.base_color * float(share);
    if (is_solid) m.transmission = m.transmission * attenuation(in, thickness, where);
    if (!is_smooth) loading_.warn(where, "rough transmission is not modelled; it is as through smooth glass");
    const bool is_glass = is_whole && (is_solid || is_smooth);
    if (is_glass) {
        m.kind = MaterialKind::kDielectric;
        m.metallic_roughness_texture = -1;
    }
    if (is_solid && is_glass) {
        // Fresnel's own formulas, of which Schlick's is an approximation
        m.coat = CoatKind::kNone;
        m.f90 = 1;
        m.eta = float(extension_number(in, "KHR_materials_ior", "ior", 1.5));
        if (!(m.eta > 0)) fail(where, "an index of refraction must be > 0");
        if (in.extensions.contains("KHR_materials_specular"))
            loading_.warn(where,
                          "KHR_materials_specular is not modelled for solid glass; its index alone counts");
        return;
    }
    if (is_solid) loading_.warn(where, "a solid that lets a part of the light through does not bend it here");
    m.thin = true;
    if (!is_glass) m.base_color = m.base_color * float(1 - share);
}

/// KHR_materials_unlit: a surface with the same colour under any light.
void GltfReader::unlit(viscache::Material& m, Look& look, const std::string& where) {
    loading_.warn(where, "an unlit material emits its base colour, and lights other surfaces with it");
    if (look.colored) loading_.warn(where, "colours of vertices do not tint what an unlit material emits");
    look.emission = m.base_color;
    look.emission_texture = m.base_texture;
    m.kind = MaterialKind::kDiffuse;
    m.coat = CoatKind::kNone;
    m.base_color = {0, 0, 0};
    m.base_texture = -1;
}

viscache::Material GltfReader::surface(const tinygltf::Material& in, Look& look, const std::string& where) {
    const auto& pbr = in.pbrMetallicRoughness;
    viscache::Material m;
    m.two_sided = in.doubleSided;
    m.kind = MaterialKind::kGlossy;
    m.coat = CoatKind::kFresnelMix;
    m.base_color = clamp01(gltf_rgb(pbr.baseColorFactor, {1, 1, 1}));
    if (pbr.baseColorTexture.index >= 0)
        m.base_texture = add_texture(look, pbr.baseColorTexture, true, where);
    alpha(m, in, where);
    check_layers(in, where);
    if (in.extensions.contains("KHR_materials_unlit")) {
        unlit(m, look, where);
        return m;
    }
    m.specular = dielectric_specular(in, where);
    m.f90 = std::clamp(float(extension_number(in, "KHR_materials_specular", "specularFactor", 1)), 0.f, 1.f);
    if (const tinygltf::Value* given = extension_of(in.extensions, kGlossiness)) {
        m.specular = specular_of_glossiness(*given);
        m.f90 = 1;
    }
    roughness(m, in, look, where);
    if (in.normalTexture.index >= 0) loading_.warn(where, "normal maps are not modelled; ignored");
    transmission(m, in, where);
    return m;
}

/// Needs the texture coordinates of the look.
void GltfReader::emission(Look& look, const tinygltf::Material& in, const std::string& where) {
    const Rgb e = max({0, 0, 0}, gltf_rgb(in.emissiveFactor, {0, 0, 0}));
    look.emission = e * float(extension_number(in, "KHR_materials_emissive_strength", "emissiveStrength", 1));
    if (!(max_component(look.emission) > 0) || in.emissiveTexture.index < 0) return;
    if (coordinates_of(in.emissiveTexture) == look.texcoord) {
        look.emission_texture = add_texture(look, in.emissiveTexture, true, where);
        return;
    }
    loading_.warn(where,
                  "an emissive image with texture coordinates of its own is not modelled; its mean is used");
    if (const auto image = decoded(in.emissiveTexture.index, true, where))
        look.emission = look.emission * mean_of(*image).color;
}

const GltfReader::Look& GltfReader::look(int index) {
    const auto [found, is_new] = looks_.try_emplace(index);
    if (!is_new) return found->second;
    const std::string where = path_ + ": material " + std::to_string(index);
    if (index >= 0 && size_t(index) >= model_.materials.size())
        fail(where, "the file has " + std::to_string(model_.materials.size()) + " materials");
    const tinygltf::Material in =
        as_metallic_roughness(index < 0 ? tinygltf::Material{} : model_.materials[size_t(index)], where);
    Look& look = found->second;
    look.texcoord = texcoord_of(in);
    look.colored = colored_.contains(index);
    look.material = loading_.add_material(surface(in, look, where));
    look.two_sided = in.doubleSided;
    if (!in.extensions.contains("KHR_materials_unlit")) emission(look, in, where);
    return look;
}

}  // namespace viscache::loading
