#pragma once
// Reads glTF 2.0 and GLB scenes with tinygltf. Internal to the loader.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <memory>

#include <set>

#include "viscache/formats/clip_planes.h"
#include "viscache/formats/loading.h"

namespace viscache::loading {

/// An extension of materials that is not modelled, and the number or colour that switches it on.
struct GltfLayer {
    const char *extension, *factor;
};
constexpr GltfLayer kGltfLayers[] = {
    {"KHR_materials_anisotropy", "anisotropyStrength"},
    {"KHR_materials_clearcoat", "clearcoatFactor"},
    {"KHR_materials_diffuse_transmission", "diffuseTransmissionFactor"},
    {"KHR_materials_dispersion", "dispersion"},
    {"KHR_materials_iridescence", "iridescenceFactor"},
    {"KHR_materials_sheen", "sheenColorFactor"},
};

/// Warns of keys and extensions that are not read. Refuses JSON that is nested too deep.
void check_gltf_keys(std::string_view json, const std::string& path, Loading& loading);
/// Whether a file that requires the extension has the right shapes here: it is read, or changes looks alone.
bool reads_without(std::string_view extension);

class GltfReader {
public:
    GltfReader(const std::string& path, Loading& loading) : path_(path), loading_(loading) {}
    void read_scene();

private:
    /// What a glTF material contributes to the meshes that use it.
    struct Look {
        int material = -1;
        Rgb emission{};
        int emission_texture = -1;
        bool two_sided = false;
        bool colored = false;  ///< meshes with colours use it
        int texcoord = 0;      ///< index of the texture coordinate set
        MaterialUv uv;         ///< what the images make of the coordinates
    };
    /// Elements of an accessor, with bounds checks.
    struct Elements {
        const unsigned char* data = nullptr;
        size_t count = 0, stride = 0;
        int component = 0, n = 0;
        bool normalized = false;
        std::shared_ptr<std::vector<unsigned char>> owned{};  ///< what `data` points to; null: a buffer

        double get(size_t element, int c) const;
    };
    struct Placed {
        int mesh;
        Affine to_world;
    };

    // load_gltf.cpp: files, nodes, placement
    void parse();
    void check_extensions();
    void visit(int node, const Affine& parent, int depth);
    Affine local_transform(const tinygltf::Node& node, const std::string& where);
    void add_camera(int camera, const Affine& t, const std::string& where);
    void add_light(const tinygltf::Node& node, const Affine& t, const std::string& where);
    void place_all();
    void bake(std::vector<viscache::Mesh> meshes, const Affine& t, const std::string& where);

    // gltf_meshes.cpp
    Elements elements(int accessor, const std::string& where) const;
    Elements elements_in(int view, size_t offset, Elements like, const std::string& place) const;
    Elements replaced(const tinygltf::Accessor& accessor, Elements base, const std::string& place) const;
    std::vector<Vec3> vec3s(int accessor, const std::string& where) const;
    std::vector<VertexColor> colors(const tinygltf::Primitive& p, const std::string& where) const;
    std::vector<viscache::Mesh> meshes_of(int mesh);
    std::optional<viscache::Mesh> primitive_mesh(const tinygltf::Primitive& p, const std::string& where);
    void check_attributes(const tinygltf::Primitive& p, const std::string& where);
    void add_triangles(viscache::Mesh& mesh, const tinygltf::Primitive& p, const std::string& where);

    // gltf_materials.cpp
    const Look& look(int material);
    viscache::Material surface(const tinygltf::Material& in, Look& look, const std::string& where);
    void transmission(viscache::Material& m, const tinygltf::Material& in, const std::string& where);
    double transmitted_share(const tinygltf::Material& in, const std::string& where);
    Rgb attenuation(const tinygltf::Material& in, double thickness, const std::string& where);
    void unlit(viscache::Material& m, Look& look, const std::string& where);
    tinygltf::Material as_metallic_roughness(tinygltf::Material in, const std::string& where);
    void check_layers(const tinygltf::Material& in, const std::string& where);
    void alpha(viscache::Material& m, const tinygltf::Material& in, const std::string& where);
    void emission(Look& look, const tinygltf::Material& in, const std::string& where);
    Rgb dielectric_specular(const tinygltf::Material& in, const std::string& where);
    double extension_number(const tinygltf::Material& in, const char* extension, const char* name,
                            double fallback) const;
    int image_source(int texture, const std::string& where) const;
    std::string image_bytes(int source, const std::string& where) const;
    std::string image_path(int source) const;
    int add_texture(Look& look, const tinygltf::TextureInfo& info, bool srgb, const std::string& where);
    LookUp look_up(int texture, const std::string& where) const;
    void roughness(viscache::Material& m, const tinygltf::Material& in, Look& look, const std::string& where);
    std::optional<viscache::Image> decoded(int texture, bool srgb, const std::string& where);

    const std::string path_;
    Loading& loading_;
    tinygltf::Model model_;
    std::vector<char> visited_;
    std::vector<Placed> placed_;
    std::vector<std::pair<std::string, ClipPlanes>> planes_;  ///< of each camera, with its place
    std::map<int, Look> looks_;
    std::set<int> colored_;  ///< materials of primitives with colours
    /// Scene image of an embedded one; key: index, sRGB or linear, look-up.
    std::map<std::tuple<int, bool, LookUp>, int> embedded_;
};

}  // namespace viscache::loading
