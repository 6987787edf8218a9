// glTF 2.0: what the file says that is not read. tinygltf drops keys that it does not know, so this looks at
// the JSON itself.
#include <cstring>
#include <set>
#include <unordered_map>

#include "viscache/formats/gltf_reader.h"

namespace viscache::loading {

namespace {

constexpr int kMaxJsonDepth = 256;
// Texts of warnings with a name in them; a hostile file could bring a million names.
constexpr size_t kMostNames = 32, kLongestName = 100;

/// The keys of a kind of object, which is its place in the document or the name of an extension. "key:kind"
/// holds objects of another kind. All of them are read, or warned of where they are read, but these, which
/// leave the picture right: min, max and target help graphics cards; scenes and skins that no node uses;
/// occlusion, which light transport computes; strength and scale, which belong to occlusion and to normal
/// maps; mimeType, which the bytes of an image tell; filters that shrink images.
constexpr std::pair<std::string_view, std::string_view> kKeys[] = {
    {"",
     "accessors:accessor animations asset buffers:buffer bufferViews:bufferView cameras:camera "
     "extensionsRequired extensionsUsed images:image materials:material meshes:mesh nodes:node "
     "samplers:sampler scene scenes:scene skins textures:texture"},
    {"scene", "nodes"},
    {"node", "camera children matrix mesh rotation scale skin translation weights"},
    {"mesh", "primitives:primitive weights"},
    {"primitive", "attributes indices material mode targets"},
    {"accessor", "bufferView byteOffset componentType count max min normalized sparse type"},
    {"bufferView", "buffer byteLength byteOffset byteStride target"},
    {"buffer", "byteLength uri"},
    {"camera", "orthographic:orthographic perspective:perspective type"},
    {"orthographic", "xmag ymag zfar znear"},
    {"perspective", "aspectRatio yfov zfar znear"},
    {"material",
     "alphaCutoff alphaMode doubleSided emissiveFactor emissiveTexture:textureInfo "
     "normalTexture:textureInfo occlusionTexture pbrMetallicRoughness:pbrMetallicRoughness"},
    {"pbrMetallicRoughness",
     "baseColorFactor baseColorTexture:textureInfo metallicFactor "
     "metallicRoughnessTexture:textureInfo roughnessFactor"},
    {"textureInfo", "index scale strength texCoord"},
    {"texture", "sampler source"},
    {"image", "bufferView mimeType uri"},
    {"sampler", "magFilter minFilter wrapS wrapT"},
    {"KHR_lights_punctual", "light lights:light"},
    {"light", "color intensity range spot:spot type"},
    {"spot", "innerConeAngle outerConeAngle"},
    {"KHR_materials_emissive_strength", "emissiveStrength"},
    {"KHR_materials_ior", "ior"},
    {"KHR_materials_pbrSpecularGlossiness",
     "diffuseFactor diffuseTexture:textureInfo glossinessFactor specularFactor specularGlossinessTexture"},
    {"KHR_materials_specular", "specularColorFactor specularColorTexture specularFactor specularTexture"},
    {"KHR_materials_transmission", "transmissionFactor transmissionTexture"},
    {"KHR_materials_unlit", ""},
    {"KHR_materials_volume", "attenuationColor attenuationDistance thicknessFactor thicknessTexture"},
    {"KHR_mesh_quantization", ""},
    {"KHR_texture_transform", "offset rotation scale texCoord"},
};
/// Extensions whose objects are not looked into: the reader warns of what it leaves out of them, or they tell
/// about the file (XMP), or the file holds the same without them, since it does not require them.
constexpr std::string_view kWhole[] = {
    "EXT_meshopt_compression", "EXT_texture_avif",   "EXT_texture_webp", "KHR_draco_mesh_compression",
    "KHR_materials_variants",  "KHR_texture_basisu", "KHR_xmp",          "KHR_xmp_json_ld",
    "MSFT_texture_dds",
};

struct Kind {
    bool extensions = false;                                 ///< keys are names of extensions
    std::unordered_map<std::string_view, const Kind*> keys;  ///< nullptr: not looked into
};

struct Kinds {
    std::unordered_map<std::string_view, Kind> of;
    Kind extensions{true, {}};

    Kinds() {
        for (const auto& row : kKeys) of[row.first];
        for (const auto& [name, text] : kKeys) {
            Kind& kind = of[name];
            kind.keys = {{"name", nullptr}, {"extras", nullptr}, {"extensions", &extensions}};
            for (size_t at = 0; at < text.size();) {
                const size_t end = std::min(text.find(' ', at), text.size());
                const std::string_view word = text.substr(at, end - at), key = word.substr(0, word.find(':'));
                kind.keys[key] = key == word ? nullptr : &of.at(word.substr(key.size() + 1));
                at = end + 1;
            }
            if (name.starts_with("KHR_")) extensions.keys[name] = &kind;
        }
        for (const auto& name : kWhole) extensions.keys[name] = nullptr;
        for (const GltfLayer& layer : kGltfLayers) extensions.keys[layer.extension] = nullptr;
    }
};

const Kinds& kinds() {
    static const Kinds all;
    return all;
}

/// One pass over well-formed JSON. tinygltf parses it afterwards, and refuses what is not.
class KeyWalk {
public:
    KeyWalk(std::string_view json, const std::string& path, Loading& loading)
        : json_(json), path_(path), loading_(loading) {}

    void run() {
        for (size_t i = 0; i < json_.size(); ++i) {
            switch (json_[i]) {
                case '"': i = text(i + 1); break;
                case '{':
                case '[': push(json_[i] == '['); break;
                case '}':
                case ']':
                    if (!levels_.empty()) levels_.pop_back();
                    break;
                case ',':
                    if (levels_.empty()) break;
                    ++levels_.back().index;
                    levels_.back().key_next = !levels_.back().is_array;
                    break;
                default: break;
            }
        }
    }

private:
    struct Level {
        const Kind* kind;  ///< of this object, or of the objects in this array
        bool is_array, key_next;
        size_t index = 0;
        std::string_view key{};
        const Kind* inner = nullptr;  ///< of what the key holds
    };

    void push(bool is_array) {
        // tinygltf recurses into nested values: deeper files would exhaust the stack
        if (levels_.size() >= kMaxJsonDepth) fail(path_, "the JSON is nested more than 256 deep");
        const Kind* kind = levels_.empty()           ? &kinds().of.at("")
                           : levels_.back().is_array ? levels_.back().kind
                                                     : levels_.back().inner;
        levels_.push_back({kind, is_array, !is_array});
    }

    /// From after the opening quote to the closing one.
    size_t text(size_t begin) {
        size_t end = begin;
        for (;; ++end) {
            const void* quote = std::memchr(json_.data() + end, '"', json_.size() - end);
            if (!quote) return json_.size();
            end = size_t(static_cast<const char*>(quote) - json_.data());
            size_t slashes = 0;
            while (end - slashes > begin && json_[end - slashes - 1] == '\\') ++slashes;
            if (slashes % 2 == 0) break;
        }
        if (!levels_.empty() && levels_.back().key_next) key(json_.substr(begin, end - begin));
        return end;
    }

    void key(std::string_view name) {
        Level& level = levels_.back();
        level.key_next = false;
        level.key = name;
        level.inner = nullptr;
        if (!level.kind) return;
        const auto found = level.kind->keys.find(name);
        if (found != level.kind->keys.end())
            level.inner = found->second;
        else
            report(name, level.kind->extensions);
    }

    void report(std::string_view name, bool is_extension) {
        std::string where = path_ + ": ";
        // Names may be as long as the file, and this may be asked a million times
        for (size_t i = 0; i < levels_.size() && where.size() < path_.size() + 500; ++i) {
            const Level& level = levels_[i];
            where += level.is_array ? "[" + std::to_string(level.index) + "]"
                                    : (i ? "." : "") + std::string(level.key.substr(0, kLongestName));
        }
        const bool is_named = names_.size() < kMostNames || names_.contains(name);
        if (is_named) names_.insert(name);
        const std::string shown = is_named ? " '" + std::string(name.substr(0, kLongestName)) + "'" : "";
        loading_.warn(printable(where),
                      printable(is_extension ? "the extension" + shown + " is not modelled; ignored"
                                             : "the property" + shown + " is not read"));
    }

    const std::string_view json_;
    const std::string& path_;
    Loading& loading_;
    std::vector<Level> levels_;
    std::set<std::string_view> names_;
};

}  // namespace

void check_gltf_keys(std::string_view json, const std::string& path, Loading& loading) {
    KeyWalk(json, path, loading).run();
}

bool reads_without(std::string_view extension) {
    if (extension == "EXT_meshopt_compression" || extension == "KHR_draco_mesh_compression") return false;
    if (kinds().extensions.keys.contains(extension)) return true;
    // What else changes looks only. Other extensions may change what is where
    for (const std::string_view start : {"KHR_materials_", "EXT_materials_", "KHR_texture_", "EXT_texture_",
                                         "KHR_animation_", "EXT_lights_"})
        if (extension.starts_with(start)) return true;
    return false;
}

}  // namespace viscache::loading
