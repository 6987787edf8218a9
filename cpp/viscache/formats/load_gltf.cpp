// glTF 2.0: the file, its nodes, cameras and lights, and the placement of meshes.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_INCLUDE_JSON
#include <nlohmann/json.hpp>

#include "viscache/formats/gltf_reader.h"

#include <filesystem>

namespace viscache::loading {

namespace {

// A glTF camera has an aspect ratio and no number of pixels.
constexpr float kDefaultHeight = 480;

/// Looks at the required extensions before the buffers, which may be readable with them alone.
void check_required(std::string_view json, const std::string& path) {
    if (json.find("\"extensionsRequired\"") == std::string_view::npos) return;
    const auto root = nlohmann::json::parse(json, nullptr, false);
    if (!root.is_object() || !root.contains("extensionsRequired")) return;
    for (const auto& name : root["extensionsRequired"]) {
        if (!name.is_string() || reads_without(name.get<std::string>())) continue;
        const std::string text = name.get<std::string>();
        const bool compressed = text == "EXT_meshopt_compression" || text == "KHR_draco_mesh_compression";
        fail(path,
             "the file requires the extension '" + text + "', which is not modelled" +
                 (compressed ? "; 'gltf-transform copy IN OUT' writes the file without compression" : ""));
    }
}

/// All files are read by `read_file`, which holds the rule of allowed files. Newer versions of tinygltf keep
/// their own functions unless one more is given.
template <class Callbacks, class Reader>
void set_file_callbacks(Reader& reader) {
    Callbacks fs{};
    fs.FileExists = [](const std::string& name, void*) {
        std::error_code error;
        return std::filesystem::is_regular_file(name, error);
    };
    fs.ExpandFilePath = [](const std::string& name, void*) { return name; };
    fs.ReadWholeFile = [](std::vector<unsigned char>* out, std::string*, const std::string& name, void*) {
        const std::string bytes = read_file(name);
        out->assign(bytes.begin(), bytes.end());
        return true;
    };
    fs.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
        return false;
    };
    if constexpr (requires { fs.GetFileSizeInBytes; })
        fs.GetFileSizeInBytes = [](size_t* size, std::string*, const std::string& name, void*) {
            *size = size_t(check_file(name));
            return true;
        };
    if constexpr (std::is_same_v<decltype(reader.SetFsCallbacks(fs)), bool>) {
        if (!reader.SetFsCallbacks(fs)) throw std::logic_error("tinygltf takes no functions that read files");
    } else {
        reader.SetFsCallbacks(fs);
    }
}

/// Keeps the bytes of data URIs. Images in buffers are read later, with bounds checks.
bool keep_image(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                int size, void*) {
    if (image->bufferView < 0 && size > 0) image->image.assign(bytes, bytes + size);
    return true;
}

std::string first_line(const std::string& text) {
    return text.substr(0, std::min(text.find('\n'), size_t(300)));
}

}  // namespace

void GltfReader::parse() {
    const std::string bytes = read_file(path_);
    // tinygltf and the GLB header count bytes with 32 bits.
    if (bytes.size() > 0xffffffffu) fail(path_, "a glTF file larger than 4 GiB");
    const bool binary = bytes.starts_with("glTF");
    uint32_t json_bytes = 0;
    // GLB: a header of 12 bytes, then chunks. The first is the JSON: its length at byte 12, its text from
    // byte 20.
    if (binary && bytes.size() >= 20) std::memcpy(&json_bytes, bytes.data() + 12, 4);
    const std::string_view json =
        binary ? std::string_view(bytes).substr(std::min<size_t>(20, bytes.size()), json_bytes) : bytes;
    check_gltf_keys(json, path_, loading_);
    check_required(json, path_);

    tinygltf::TinyGLTF reader;
    set_file_callbacks<tinygltf::FsCallbacks>(reader);
    reader.SetImageLoader(keep_image, nullptr);
    const std::string folder = std::filesystem::path(path_).parent_path().string();
    std::string error, warning;
    const auto size = static_cast<unsigned>(bytes.size());
    const bool ok =
        binary
            ? reader.LoadBinaryFromMemory(&model_, &error, &warning,
                                          reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
            : reader.LoadASCIIFromString(&model_, &error, &warning, bytes.data(), size, folder);
    if (!ok) fail(path_, error.empty() ? "not a glTF 2.0 file" : first_line(error));
    if (!model_.asset.version.starts_with("2"))
        fail(path_, "glTF version " + model_.asset.version + "; 2.x is read");
    const std::string& least = model_.asset.minVersion;
    if (!least.empty() && least != "2.0") fail(path_, "glTF version " + least + " is needed; 2.0 is read");
}

void GltfReader::check_extensions() {
    if (model_.extensions.contains("KHR_materials_variants"))
        loading_.note(path_, "variants of materials are not read; each mesh has its default material");
    if (!model_.animations.empty())
        loading_.warn(path_, "animations are not modelled; the scene at rest is used");
}

Affine GltfReader::local_transform(const tinygltf::Node& node, const std::string& where) {
    Affine t;
    if (node.matrix.size() == 16) {
        // glTF stores matrices by columns.
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 4; ++j) t.m[i][j] = node.matrix[size_t(j * 4 + i)];
    } else {
        // Without a matrix: translation · rotation · scale. The rotation is a quaternion (x, y, z, w) = (axis
        // sin(θ/2), cos(θ/2)).
        const auto& q = node.rotation;
        if (node.translation.size() == 3)
            t = translation(node.translation[0], node.translation[1], node.translation[2]);
        if (q.size() == 4) {
            const double s = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
            t = t * rotation(2 * std::atan2(s, q[3]) * 180 / 3.14159265358979323846, q[0], q[1], q[2]);
        }
        if (node.scale.size() == 3) t = t * scaling(node.scale[0], node.scale[1], node.scale[2]);
    }
    if (!is_finite(t)) fail(where, "the node's transform is not finite");
    return t;
}

void GltfReader::add_camera(int index, const Affine& t, const std::string& where) {
    if (index < 0 || size_t(index) >= model_.cameras.size())
        fail(where,
             "camera " + std::to_string(index) + ", the file has " + std::to_string(model_.cameras.size()));
    const tinygltf::Camera& in = model_.cameras[size_t(index)];
    const bool parallel = in.type == "orthographic";
    if (in.type != "perspective" && !parallel)
        return loading_.warn(where, "camera type '" + in.type + "' is not modelled; skipped");
    Camera c;
    if (!in.name.empty()) c.name = in.name;
    c.origin = t.point({0, 0, 0});
    // Cameras of glTF look along −z with y up. A scale in the node's transform must not tilt the frame: up is
    // made perpendicular again.
    c.forward = normalize(t.vector({0, 0, -1}));
    const Vec3 up = t.vector({0, 1, 0}), right = t.vector({1, 0, 0});
    c.up = normalize(up - c.forward * dot(up, c.forward));
    const Vec3 side = normalize(cross(c.forward, c.up));
    // A mirroring node mirrors the picture.
    c.right = dot(side, right) < 0 ? -side : side;
    if (length2(c.right) == 0) fail(where, "the camera's transform is singular");
    // The aspect ratio is optional.
    double aspect = in.perspective.aspectRatio > 0 ? in.perspective.aspectRatio : 16.0 / 9;
    if (parallel) {
        const double x = std::abs(in.orthographic.xmag), y = std::abs(in.orthographic.ymag);
        if (!(x > 0 && y > 0)) fail(where, "xmag and ymag of an orthographic camera must not be 0");
        // xmag and ymag are half extents.
        c.view_height = float(2 * y);
        aspect = x / y;
    } else {
        c.fov_y_rad = float(in.perspective.yfov);
    }
    c.height = int(kDefaultHeight);
    c.width = int(std::clamp(std::round(aspect * double(kDefaultHeight)), 1.0, 65536.0));
    const auto [near, far] = parallel ? std::pair(in.orthographic.znear, in.orthographic.zfar)
                                      : std::pair(in.perspective.znear, in.perspective.zfar);
    // No far plane is allowed
    planes_.push_back({where, {float(near), far > 0 ? float(far) : kInfinity}});
    loading_.scene.cameras.push_back(c);
}

void GltfReader::add_light(const tinygltf::Node& node, const Affine& t, const std::string& where) {
    const auto found = node.extensions.find("KHR_lights_punctual");
    if (found == node.extensions.end() || !found->second.IsObject()) return;
    const tinygltf::Value& value = found->second.Get("light");
    const int index = value.IsInt() ? value.GetNumberAsInt() : -1;
    if (index < 0 || size_t(index) >= model_.lights.size())
        fail(where,
             "light " + std::to_string(index) + ", the file has " + std::to_string(model_.lights.size()));
    const tinygltf::Light& in = model_.lights[size_t(index)];
    const float i = float(in.intensity);
    const Rgb color = in.color.size() == 3
                          ? Rgb{float(in.color[0]), float(in.color[1]), float(in.color[2])} * i
                          : Rgb{i, i, i};
    // KHR_lights_punctual lets a light end at its range, which no physical light does.
    if (in.range > 0)
        loading_.warn(where,
                      "the range of a light is not modelled; its light falls off with the distance alone");
    // One candela is taken as 1 W/sr, one lux as 1 W/m², as one nit of an emissive material is 1 W/(m²·sr).
    if (in.type == "point") {
        loading_.scene.point_lights.push_back({t.point({0, 0, 0}), color});
    } else if (in.type == "spot") {
        const double inner = in.spot.innerConeAngle, outer = in.spot.outerConeAngle;
        // The cosines order the two angles only in [0, π].
        if (!(inner >= 0 && inner <= outer && outer > 0 && outer <= M_PI))
            fail(where, "a spot light needs 0 <= innerConeAngle <= outerConeAngle");
        const Vec3 axis = normalize(t.vector({0, 0, -1}));
        if (length2(axis) == 0) fail(where, "the transform of a spot light must not be singular");
        const SpotCone cone{Falloff::kQuadratic, axis, float(std::cos(inner)), float(std::cos(outer))};
        loading_.scene.point_lights.push_back({t.point({0, 0, 0}), color, cone});
    } else if (in.type == "directional") {
        // The light shines along −z; a direction here points to the light.
        loading_.scene.directional_lights.push_back({normalize(t.vector({0, 0, 1})), color});
    } else {
        loading_.warn(where, "light type '" + in.type + "' is not modelled; skipped");
    }
}

void GltfReader::visit(int index, const Affine& parent, int depth) {
    const std::string where = path_ + ": node " + std::to_string(index);
    if (index < 0 || size_t(index) >= model_.nodes.size())
        fail(where, "the file has " + std::to_string(model_.nodes.size()) + " nodes");
    // This function recurses: a deeper chain of nodes would exhaust the stack.
    if (depth > 4096) fail(where, "nodes are nested more than 4096 deep");
    // glTF demands a tree. A cycle would recurse without end, and shared children could double the placed
    // nodes at each level.
    if (visited_[size_t(index)]) fail(where, "the node has two parents, or is its own ancestor");
    visited_[size_t(index)] = 1;
    const tinygltf::Node& node = model_.nodes[size_t(index)];
    // Finite factors may have an infinite product.
    const Affine t = parent * local_transform(node, where);
    if (!is_finite(t)) fail(where, "the node's transform is not finite");
    if (node.mesh >= 0) {
        if (size_t(node.mesh) >= model_.meshes.size())
            fail(where, "mesh " + std::to_string(node.mesh) + ", the file has " +
                            std::to_string(model_.meshes.size()));
        // Without weights the mesh is as its vertices say
        const auto& own = model_.meshes[size_t(node.mesh)].weights;
        const auto& weights = node.weights.empty() ? own : node.weights;
        if (std::any_of(weights.begin(), weights.end(), [](double w) { return w != 0; }))
            loading_.warn(where, "morph targets are not modelled; the mesh without them is used");
        if (node.skin >= 0) loading_.warn(where, "skins are not modelled; the mesh at rest is used");
        placed_.push_back({node.mesh, t});
    }
    if (node.camera >= 0) add_camera(node.camera, t, where);
    add_light(node, t, where);
    for (int child : node.children) visit(child, t, depth + 1);
}

void GltfReader::bake(std::vector<viscache::Mesh> meshes, const Affine& t, const std::string& where) {
    for (viscache::Mesh& mesh : meshes) {
        transform_mesh(mesh, t);
        // glTF: a mirrored node reverses the winding.
        if (t.determinant() < 0) flip_winding(mesh);
        loading_.add_mesh(std::move(mesh), where);
    }
}

void GltfReader::place_all() {
    std::map<int, int> uses;
    // Only a mesh that is placed more than once saves memory as an instance.
    for (const Placed& p : placed_) ++uses[p.mesh];
    std::map<int, std::vector<int>> groups;
    for (const Placed& p : placed_) {
        const std::string where = path_ + ": mesh " + std::to_string(p.mesh);
        std::vector<viscache::Mesh> meshes = meshes_of(p.mesh);
        bool emits = false;
        for (const viscache::Mesh& mesh : meshes) emits = emits || max_component(mesh.emission) > 0;
        // The triangles of lights must stand in the world, and a mirrored placement needs its own winding. A
        // flat one has no inverse, which instances need.
        if (uses[p.mesh] == 1 || emits || p.to_world.determinant() <= 0) {
            bake(std::move(meshes), p.to_world, where);
            continue;
        }
        const auto [group, is_new] = groups.try_emplace(p.mesh);
        if (is_new)
            for (viscache::Mesh& mesh : meshes) {
                mesh.in_world = false;
                group->second.push_back(loading_.add_mesh(std::move(mesh), where));
            }
        if (!group->second.empty()) loading_.scene.instances.push_back({group->second, p.to_world});
    }
}

void GltfReader::read_scene() {
    parse();
    check_extensions();
    const Point& origin = loading_.scene.origin = loading_.origin;
    // The origin moves the roots in double precision, before vertices are rounded to floats.
    const Affine to_scene = translation(-origin[0], -origin[1], -origin[2]);
    visited_.assign(model_.nodes.size(), 0);
    for (const tinygltf::Mesh& mesh : model_.meshes)
        for (const tinygltf::Primitive& p : mesh.primitives)
            if (p.attributes.contains("COLOR_0")) colored_.insert(p.material);
    if (model_.scenes.empty()) {
        // A file without scenes: every node without a parent is a root.
        std::vector<char> is_child(model_.nodes.size(), 0);
        for (const tinygltf::Node& node : model_.nodes)
            for (int child : node.children)
                if (child >= 0 && size_t(child) < is_child.size()) is_child[size_t(child)] = 1;
        for (size_t i = 0; i < is_child.size(); ++i)
            if (!is_child[i]) visit(int(i), to_scene, 0);
    } else {
        // Without a default scene, a viewer may choose: the first.
        const int chosen = std::max(model_.defaultScene, 0);
        if (size_t(chosen) >= model_.scenes.size())
            fail(path_, "scene " + std::to_string(chosen) + ", the file has " +
                            std::to_string(model_.scenes.size()));
        for (int root : model_.scenes[size_t(chosen)].nodes) visit(root, to_scene, 0);
    }
    place_all();
    for (size_t i = 0; i < planes_.size(); ++i)
        if (const auto& [where, planes] = planes_[i];
            cut_geometry(loading_.scene, loading_.scene.cameras[i], planes).any())
            loading_.warn(where, "near and far planes are not modelled; what they cut is seen");
}

void load_gltf(const std::string& path, Loading& loading) { GltfReader(path, loading).read_scene(); }

}  // namespace viscache::loading
