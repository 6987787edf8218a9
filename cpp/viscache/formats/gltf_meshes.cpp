// glTF 2.0: converts accessors and primitives to meshes.
#include "viscache/formats/gltf_reader.h"

#include <cstring>

namespace viscache::loading {

namespace {

template <class T>
double value_at(const unsigned char* p, bool normalized) {
    T v;
    std::memcpy(&v, p, sizeof v);
    if constexpr (std::is_integral_v<T>)
        // As the standard says: signed integers have one value more below zero, which counts as −1
        if (normalized) return std::max(double(v) / double(std::numeric_limits<T>::max()), -1.0);
    return double(v);
}

std::string count_text(int index, const char* what, size_t count) {
    return std::string(what) + " " + std::to_string(index) + ", the file has " + std::to_string(count);
}

}  // namespace

static int component_bytes(int component, const std::string& place) {
    const int size = tinygltf::GetComponentSizeInBytes(uint32_t(component));
    if (size <= 0 || component == TINYGLTF_COMPONENT_TYPE_INT || component == TINYGLTF_COMPONENT_TYPE_DOUBLE)
        fail(place, "unknown component type " + std::to_string(component));
    return size;
}

double GltfReader::Elements::get(size_t element, int c) const {
    const unsigned char* p =
        data + element * stride + size_t(c) * size_t(tinygltf::GetComponentSizeInBytes(uint32_t(component)));
    switch (component) {
        case TINYGLTF_COMPONENT_TYPE_BYTE: return value_at<int8_t>(p, normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return value_at<uint8_t>(p, normalized);
        case TINYGLTF_COMPONENT_TYPE_SHORT: return value_at<int16_t>(p, normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return value_at<uint16_t>(p, normalized);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return value_at<uint32_t>(p, normalized);
        default: return value_at<float>(p, normalized);
    }
}

/// Elements in a buffer view, checked against its size. `like`: their number, type and size.
GltfReader::Elements GltfReader::elements_in(int index, size_t offset, Elements like,
                                             const std::string& place) const {
    if (index < 0 || size_t(index) >= model_.bufferViews.size())
        fail(place, count_text(index, "buffer view", model_.bufferViews.size()));
    const tinygltf::BufferView& view = model_.bufferViews[size_t(index)];
    if (view.buffer < 0 || size_t(view.buffer) >= model_.buffers.size())
        fail(place, count_text(view.buffer, "buffer", model_.buffers.size()));
    const auto& data = model_.buffers[size_t(view.buffer)].data;
    // All elements must lie inside the view, and the view inside its buffer.
    const size_t element = like.stride, stride = view.byteStride ? view.byteStride : element;
    const bool view_fits = view.byteOffset <= data.size() && view.byteLength <= data.size() - view.byteOffset;
    const bool fits = view_fits && stride >= element && like.count > 0 && offset <= view.byteLength &&
                      element <= view.byteLength - offset &&
                      (like.count - 1) <= (view.byteLength - offset - element) / stride;
    if (!fits)
        fail(place, std::to_string(like.count) + " elements of " + std::to_string(element) +
                        " bytes do not fit into the buffer of " + std::to_string(data.size()) + " bytes");
    like.data = data.data() + view.byteOffset + offset;
    like.stride = stride;
    return like;
}

/// The elements of a sparse accessor: those of its view, or zeros, of which some are replaced.
GltfReader::Elements GltfReader::replaced(const tinygltf::Accessor& a, Elements base,
                                          const std::string& place) const {
    constexpr size_t kMostZeros = size_t{1} << 24;  // a short file must not ask for much memory
    if (!base.data && base.count > kMostZeros)
        fail(place, "a sparse accessor without a buffer view must have at most 2^24 elements");
    const size_t element = size_t(base.n) * size_t(component_bytes(base.component, place));
    auto all = std::make_shared<std::vector<unsigned char>>(base.count * element);
    for (size_t i = 0; base.data && i < base.count; ++i)
        std::memcpy(&(*all)[i * element], base.data + i * base.stride, element);
    const auto& [indices, values] = std::pair(a.sparse.indices, a.sparse.values);
    Elements of = base, at{nullptr, size_t(std::max(a.sparse.count, 0)), 0, indices.componentType, 1};
    at.stride = size_t(component_bytes(at.component, place));
    of.count = at.count;
    of.stride = element;
    at = elements_in(indices.bufferView, size_t(indices.byteOffset), at, place + " indices");
    of = elements_in(values.bufferView, size_t(values.byteOffset), of, place + " values");
    for (size_t i = 0; i < at.count; ++i) {
        const double k = at.get(i, 0);
        if (!(k >= 0 && k < double(base.count)))
            fail(place, "a sparse index must be below " + std::to_string(base.count));
        std::memcpy(&(*all)[size_t(k) * element], of.data + i * of.stride, element);
    }
    base.data = all->data();
    base.stride = element;
    base.owned = std::move(all);
    return base;
}

GltfReader::Elements GltfReader::elements(int index, const std::string& where) const {
    if (index < 0 || size_t(index) >= model_.accessors.size())
        fail(where, count_text(index, "accessor", model_.accessors.size()));
    const tinygltf::Accessor& a = model_.accessors[size_t(index)];
    const std::string place = where + ": accessor " + std::to_string(index);
    // The file is not trusted: each index and size is checked before it is used
    const int n = tinygltf::GetNumComponentsInType(uint32_t(a.type));
    if (n <= 0) fail(place, "unknown type " + std::to_string(a.type));
    const size_t element = size_t(n) * size_t(component_bytes(a.componentType, place));
    Elements e{nullptr, a.count, element, a.componentType, n, a.normalized};
    if (!a.sparse.isSparse || a.bufferView >= 0) e = elements_in(a.bufferView, a.byteOffset, e, place);
    return a.sparse.isSparse ? replaced(a, e, place) : e;
}

std::vector<Vec3> GltfReader::vec3s(int accessor, const std::string& where) const {
    const Elements e = elements(accessor, where);
    if (e.n != 3)
        fail(where, "accessor " + std::to_string(accessor) + " must hold 3 components, it holds " +
                        std::to_string(e.n));
    std::vector<Vec3> out(e.count);
    for (size_t i = 0; i < e.count; ++i)
        out[i] = {float(e.get(i, 0)), float(e.get(i, 1)), float(e.get(i, 2))};
    return out;
}

/// COLOR_0: linear, of floats, bytes or 16 bits, with or without alpha.
std::vector<VertexColor> GltfReader::colors(const tinygltf::Primitive& p, const std::string& where) const {
    const auto given = p.attributes.find("COLOR_0");
    if (given == p.attributes.end()) return {};
    Elements e = elements(given->second, where);
    if (e.n != 3 && e.n != 4) fail(where, "colours must hold 3 or 4 components");
    e.normalized = true;  // as the standard demands of integers
    // The alpha of an opaque material counts for nothing, and neither does that of its vertices
    const bool opaque = p.material < 0 || model_.materials.at(size_t(p.material)).alphaMode == "OPAQUE";
    std::vector<VertexColor> out(e.count);
    bool clamped = false;
    for (size_t i = 0; i < e.count; ++i) {
        const Rgb color{float(e.get(i, 0)), float(e.get(i, 1)), float(e.get(i, 2))};
        clamped = clamped || is_clamped(color);
        out[i] = vertex_color(color, e.n == 4 && !opaque ? float(e.get(i, 3)) : 1.f);
    }
    if (clamped) loading_.warn(where, kClampedColors);
    return out;
}

void GltfReader::add_triangles(viscache::Mesh& mesh, const tinygltf::Primitive& p, const std::string& where) {
    std::vector<uint32_t> corners;
    const size_t n = mesh.vertices.size();
    if (p.indices >= 0) {
        const Elements e = elements(p.indices, where);
        if (e.n != 1 || e.component == TINYGLTF_COMPONENT_TYPE_FLOAT)
            fail(where, "indices must be unsigned integers");
        for (size_t i = 0; i < e.count; ++i) {
            // A double holds every index of 32 bits
            const double x = e.get(i, 0);
            if (!(x >= 0 && x < double(n)))
                fail(where, "index " + std::to_string(int64_t(x)) + ", the primitive has " +
                                std::to_string(n) + " vertices");
            corners.push_back(uint32_t(x));
        }
    } else {
        for (size_t i = 0; i < n; ++i) corners.push_back(uint32_t(i));
    }
    const size_t m = corners.size();
    if (p.mode == TINYGLTF_MODE_TRIANGLES) {
        if (m % 3) fail(where, std::to_string(m) + " indices are not whole triangles");
        for (size_t i = 0; i + 2 < m; i += 3)
            mesh.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
    } else {
        // Every second triangle of a strip runs the other way, so two of its corners change places.
        // Those of a fan share corner 0
        const bool strip = p.mode == TINYGLTF_MODE_TRIANGLE_STRIP;
        for (size_t i = 0; i + 2 < m; ++i)
            mesh.triangles.push_back(strip ? Vec3u{corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]}
                                           : Vec3u{corners[i + 1], corners[i + 2], corners[0]});
    }
}

void GltfReader::check_attributes(const tinygltf::Primitive& p, const std::string& where) {
    // Sets of coordinates that no image names change nothing. Tangents belong to normal maps, joints and
    // weights to skins, which are warned of. Names with an underscore are the program's own. Colours of
    // other sets than 0 have no use in glTF
    constexpr std::string_view kStarts[] = {"POSITION", "NORMAL",  "TANGENT",  "TEXCOORD_",
                                            "COLOR_",   "JOINTS_", "WEIGHTS_", "_"};
    for (const auto& [name, accessor] : p.attributes) {
        const auto starts = [&name = name](std::string_view start) { return name.starts_with(start); };
        if (std::none_of(std::begin(kStarts), std::end(kStarts), starts))
            loading_.warn(where + " " + printable(name.substr(0, 100)), "an attribute is not read");
    }
}

std::optional<viscache::Mesh> GltfReader::primitive_mesh(const tinygltf::Primitive& p,
                                                         const std::string& where) {
    // A file that says nothing means triangles
    const int mode = p.mode < 0 ? TINYGLTF_MODE_TRIANGLES : p.mode;
    if (mode != TINYGLTF_MODE_TRIANGLES && mode != TINYGLTF_MODE_TRIANGLE_STRIP &&
        mode != TINYGLTF_MODE_TRIANGLE_FAN) {
        if (mode == TINYGLTF_MODE_POINTS)
            loading_.warn(where, "points are not modelled; they are skipped");
        else
            loading_.note(where, "lines have no surface; they are skipped");
        return {};
    }
    const auto position = p.attributes.find("POSITION");
    if (position == p.attributes.end()) {
        loading_.warn(where, "a primitive without POSITION is skipped");
        return {};
    }
    viscache::Mesh mesh;
    mesh.vertices = vec3s(position->second, where);
    const Look& seen = look(p.material);
    if (const auto normal = p.attributes.find("NORMAL"); normal != p.attributes.end())
        mesh.normals = vec3s(normal->second, where);
    if (const auto uv = p.attributes.find("TEXCOORD_" + std::to_string(seen.texcoord));
        uv != p.attributes.end()) {
        const Elements e = elements(uv->second, where);
        if (e.n != 2) fail(where, "texture coordinates must hold 2 components");
        // Row 0 of an image is v = 0 in glTF.
        for (size_t i = 0; i < e.count; ++i) mesh.uvs.push_back({float(e.get(i, 0)), 1 - float(e.get(i, 1))});
    }
    mesh.colors = colors(p, where);
    if (mesh.uvs.empty() && uses_image(loading_.scene.materials[size_t(seen.material)]))
        loading_.warn(where, "a mesh without texture coordinates shows one texel of its images");
    check_attributes(p, where);
    // Once per mesh, so that textures are looked up without a matrix
    transform_uvs(mesh, seen.uv.get());
    tinygltf::Primitive known = p;
    known.mode = mode;
    add_triangles(mesh, known, where);
    mesh.material = seen.material;
    mesh.emission = seen.emission;
    mesh.emission_texture = seen.emission_texture;
    mesh.emits_two_sided = seen.two_sided;
    check_mesh(mesh, where);
    return mesh;
}

std::vector<viscache::Mesh> GltfReader::meshes_of(int index) {
    const tinygltf::Mesh& in = model_.meshes[size_t(index)];
    std::vector<viscache::Mesh> out;
    for (size_t i = 0; i < in.primitives.size(); ++i) {
        const std::string where =
            path_ + ": mesh " + std::to_string(index) + " primitive " + std::to_string(i);
        if (auto mesh = primitive_mesh(in.primitives[i], where)) {
            mesh->name = in.name;
            out.push_back(std::move(*mesh));
        }
    }
    return out;
}

}  // namespace viscache::loading
