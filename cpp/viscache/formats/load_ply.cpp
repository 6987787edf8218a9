// PLY polygon files: ascii, and binary of both orders of bytes.
#include <bit>
#include <cstring>

#include "viscache/formats/ply_header.h"
#include "viscache/scene/face_colors.h"

namespace viscache::loading {

using namespace ply;

namespace {

/// What does not change the picture, by element.
struct LeftOut {
    std::string_view element, names;
};
constexpr LeftOut kLeftOut[] = {
    // What scanners measured and editors marked
    {"vertex", " quality confidence intensity flags radius density curvature label class id "},
    {"face", " quality flags area label class id "},
    // Flat normals follow from the corners; these coordinates place the picture of a TextureFile, and
    // texels of pbrt's Ptex
    {"face", " nx ny nz texcoord texnumber face_indices "},
    {"edge", {}},
    {"camera", {}},
};

/// `property` empty: the element as a whole.
bool is_left_out(std::string_view element, std::string_view property) {
    // CloudCompare's fields of measured numbers
    if (element == "vertex" && property.starts_with("scalar_")) return true;
    const std::string word = " " + std::string(property) + " ";
    for (const LeftOut& row : kLeftOut)
        if (row.element == element &&
            (property.empty() ? row.names.empty() : row.names.find(word) != row.names.npos))
            return true;
    return false;
}

/// Reads values one after the other, from text or bytes.
class PlyValues {
public:
    PlyValues(std::string_view data, const PlyHeader& h, const std::string& path)
        : data_(data),
          at_(h.end),
          line_(h.lines + 1),
          ascii_(h.ascii),
          swapped_(h.big_endian != (std::endian::native == std::endian::big)),
          path_(&path) {}

    std::string where() const {
        return ascii_ ? at_line(*path_, line_) : *path_ + ": byte " + std::to_string(at_);
    }
    size_t left() const { return data_.size() - at_; }

    double next(Type type) {
        if (ascii_) return next_word();
        const size_t size = size_of(type);
        if (left() < size) fail(where(), "the file ends inside the data");
        const char* p = data_.data() + at_;
        at_ += size;
        switch (type) {
            case Type::kInt8: return get<int8_t>(p);
            case Type::kUint8: return get<uint8_t>(p);
            case Type::kInt16: return get<int16_t>(p);
            case Type::kUint16: return get<uint16_t>(p);
            case Type::kInt32: return get<int32_t>(p);
            case Type::kUint32: return get<uint32_t>(p);
            case Type::kFloat: return double(get<float>(p));
            case Type::kDouble: return get<double>(p);
        }
        return 0;
    }

    /// Length of a list. Refused if the rest of the file cannot hold that many entries.
    uint64_t next_count(const Property& p) {
        const double n = next(p.count_type);
        // A count of 2³² in a short file must not become a loop of 2³² steps or an array of that size.
        const uint64_t room = left() / (ascii_ ? 1 : size_of(p.type)) + 1;
        if (!(n >= 0) || n != std::floor(n) || n > double(room))
            fail(where(), "list '" + p.name + "' has a count that the file cannot hold");
        return uint64_t(n);
    }

private:
    template <class T>
    T get(const char* p) const {
        char bytes[sizeof(T)];
        std::memcpy(bytes, p, sizeof(T));
        if (swapped_) std::reverse(bytes, bytes + sizeof(T));
        return std::bit_cast<T>(bytes);
    }

    double next_word() {
        // strchr also finds the zero that ends its list, so a zero byte in the file is excluded by hand.
        while (at_ < data_.size() && std::strchr(" \t\r\n", data_[at_]) && data_[at_] != '\0')
            line_ += data_[at_++] == '\n';
        size_t end = at_;
        while (end < data_.size() && !(std::strchr(" \t\r\n", data_[end]) && data_[end] != '\0')) ++end;
        if (end == at_) fail(where(), "the file ends inside the data");
        const auto value = parse_number(data_.substr(at_, end - at_));
        if (!value)
            fail(where(), "a number must stand here, got '" +
                              std::string(data_.substr(at_, std::min<size_t>(end - at_, 40))) + "'");
        at_ = end;
        return *value;
    }

    std::string_view data_;
    size_t at_, line_;
    bool ascii_, swapped_;
    const std::string* path_;
};

/// Smallest possible size of a row of the element, in bytes.
uint64_t least_row_bytes(const Element& e, bool ascii) {
    uint64_t bytes = 0;
    // A value in text takes a digit and a separator. A list may be empty: its count alone is sure.
    for (const Property& p : e.properties) bytes += ascii ? 2 : size_of(p.is_list ? p.count_type : p.type);
    return bytes;
}

void check_count(const Element& e, const PlyValues& values, bool ascii, const std::string& path) {
    const uint64_t row = least_row_bytes(e, ascii);
    if (e.count == 0) return;
    // The counts of the header size the arrays, so they are compared with the bytes that are there. The last
    // value of a text may lack its separator: + 1.
    if (row == 0 || e.count > (values.left() + 1) / row)
        fail(path, "element '" + e.name + "' is said to have " + std::to_string(e.count) +
                       " rows, the file cannot hold them");
}

/// Slot of a vertex property: 0-2 position, 3-5 normal, 6-7 uv, -1 ignored.
int slot_of(const std::string& name) {
    const char* const names[8][4] = {{"x", "", "", ""},
                                     {"y", "", "", ""},
                                     {"z", "", "", ""},
                                     {"nx", "", "", ""},
                                     {"ny", "", "", ""},
                                     {"nz", "", "", ""},
                                     {"u", "s", "texture_u", "texture_s"},
                                     {"v", "t", "texture_v", "texture_t"}};
    for (int slot = 0; slot < 8; ++slot)
        for (const char* known : names[slot])
            if (*known && name == known) return slot;
    return -1;
}

/// The colour of a row. Whole numbers are bytes, or 16 bits, of sRGB, as scanners, MeshLab and Blender write
/// them; real numbers are linear and in [0, 1], as Mitsuba writes and reads them.
class RowColor {
public:
    RowColor(const Element& e, bool wanted) {
        constexpr const char* kNames[4][4] = {{"red", "r", "diffuse_red", "color_0"},
                                              {"green", "g", "diffuse_green", "color_1"},
                                              {"blue", "b", "diffuse_blue", "color_2"},
                                              {"alpha", "a", "diffuse_alpha", "color_3"}};
        bool has[4] = {};
        for (const Property& p : e.properties) {
            channels_.push_back(-1);
            if (p.is_list) continue;
            for (int c = 0; c < 4; ++c)
                for (const char* name : kNames[c])
                    if (p.name == name) channels_.back() = c;
            if (channels_.back() < 0) continue;
            has[channels_.back()] = true;
            linear_ = p.type == Type::kFloat || p.type == Type::kDouble;
            // Programs with integers of 32 bits write bytes into them
            largest_ = linear_ ? 1 : p.type == Type::kUint16 ? 65535 : 255;
        }
        given_ = wanted && has[0] && has[1] && has[2];
        row_[3] = largest_;
    }
    bool takes(size_t property) const { return given_ && channels_[property] >= 0; }
    bool given() const { return given_; }
    void take(size_t property, double value) {
        if (takes(property)) row_[channels_[property]] = value;
    }
    VertexColor get(FileColors& colors) const {
        const Rgb c{float(row_[0]), float(row_[1]), float(row_[2])};
        if (linear_ && is_clamped(c)) colors.clamped = true;
        if (linear_) return vertex_color(c, float(row_[3]));
        const auto byte = [&](int c) {
            return uint8_t(std::lround(std::clamp(row_[c] / largest_, 0.0, 1.0) * 255));
        };
        return {byte(0), byte(1), byte(2), byte(3)};
    }

private:
    std::vector<int> channels_;  ///< by property; -1: none
    double row_[4] = {}, largest_ = 255;
    bool linear_ = false, given_ = false;
};

void read_vertices(Mesh& mesh, Element& e, PlyValues& values, FileColors* colors) {
    RowColor color(e, colors != nullptr);
    std::vector<int> slots;
    bool has[8] = {};
    for (const Property& p : e.properties) {
        slots.push_back(p.is_list ? -1 : slot_of(p.name));
        if (slots.back() >= 0) has[slots.back()] = true;
    }
    if (!has[0] || !has[1] || !has[2]) fail(values.where(), "vertices must have x, y and z");
    // A normal with a missing component is as good as none.
    const bool normals = has[3] && has[4] && has[5], uvs = has[6] && has[7];
    for (size_t k = 0; k < slots.size(); ++k)
        e.properties[k].is_read =
            color.takes(k) || (slots[k] >= 0 && (slots[k] < 3 || (slots[k] < 6 ? normals : uvs)));
    for (uint64_t i = 0; i < e.count; ++i) {
        float row[8] = {};
        for (size_t k = 0; k < slots.size(); ++k) {
            const Property& p = e.properties[k];
            if (p.is_list) {
                for (uint64_t n = values.next_count(p); n > 0; --n) values.next(p.type);
            } else {
                const double x = values.next(p.type);
                color.take(k, x);
                if (slots[k] >= 0) row[slots[k]] = float(x);
            }
        }
        mesh.vertices.push_back({row[0], row[1], row[2]});
        if (normals) mesh.normals.push_back({row[3], row[4], row[5]});
        if (uvs) mesh.uvs.push_back({row[6], row[7]});
        if (color.given()) colors->vertices.push_back(color.get(*colors));
    }
}

/// The index of a vertex, which may have a signed or a real type.
uint32_t corner(double x, uint64_t vertices, const PlyValues& values) {
    // Only whole numbers that fit 32 bits may be converted
    const bool is_index = x >= 0 && x < 4294967295.0 && x == std::floor(x);
    if (!is_index || uint64_t(x) >= vertices)
        fail(values.where(), "a face uses vertex index " +
                                 (is_index ? std::to_string(uint64_t(x)) : std::to_string(x)) +
                                 ", the file has " + std::to_string(vertices) + " vertices");
    return uint32_t(x);
}

/// Whether the diagonal from the first corner divides four corners in two triangles that look to one side.
bool folds(const Mesh& mesh, const std::vector<uint32_t>& face) {
    const Vec3 a = mesh.vertices[face[0]], diagonal = mesh.vertices[face[2]] - a;
    return !(dot(cross(mesh.vertices[face[1]] - a, diagonal), cross(diagonal, mesh.vertices[face[3]] - a)) >=
             0);
}

void add_face(Mesh& mesh, const std::vector<uint32_t>& face) {
    if (face.size() == 3 || (face.size() == 4 && !folds(mesh, face))) {
        for (size_t k = 1; k + 1 < face.size(); ++k)
            mesh.triangles.push_back({face[0], face[k], face[k + 1]});
        return;
    }
    std::vector<Vec3> polygon;
    std::vector<Vec3u> local;
    for (uint32_t i : face) polygon.push_back(mesh.vertices[i]);
    triangulate(polygon, local);
    for (const Vec3u& t : local) mesh.triangles.push_back({face[t.x], face[t.y], face[t.z]});
}

/// A strip: each corner makes a triangle with the two before it, and every other triangle is turned. -1
/// begins another strip.
void add_strip(Mesh& mesh, const Property& p, uint64_t n, PlyValues& values) {
    uint32_t a = 0, b = 0;
    for (uint64_t before = 0; n > 0; --n) {
        const double x = values.next(p.type);
        if (x == -1) {
            before = 0;
            continue;
        }
        const uint32_t c = corner(x, mesh.vertices.size(), values);
        // Strips are joined by triangles without area
        if (before >= 2 && a != b && b != c && c != a)
            mesh.triangles.push_back(before % 2 ? Vec3u{b, a, c} : Vec3u{a, b, c});
        a = b;
        b = c;
        ++before;
    }
}

void skip_values(const Property& p, PlyValues& values) {
    for (uint64_t n = p.is_list ? values.next_count(p) : 1; n > 0; --n) values.next(p.type);
}

/// Faces or strips. The vertices must have been read.
void read_faces(Mesh& mesh, Element& e, PlyValues& values, Loading& loading, FileColors* colors) {
    const bool strips = e.name == "tristrips";
    bool found = false;
    RowColor color(e, colors != nullptr);
    std::vector<uint32_t> face;
    for (size_t k = 0; k < e.properties.size(); ++k) {
        Property& p = e.properties[k];
        const bool corners = p.is_list && (p.name == "vertex_indices" || p.name == "vertex_index");
        p.is_read = corners || color.takes(k);
        found = found || corners;
    }
    if (!found) fail(values.where(), e.name + (strips ? "" : "s") + " must have the list vertex_indices");
    // What another element has given is white
    if (color.given()) colors->faces.resize(mesh.triangles.size());
    for (uint64_t i = 0; i < e.count; ++i) {
        for (size_t k = 0; k < e.properties.size(); ++k) {
            const Property& p = e.properties[k];
            if (!p.is_read) {
                skip_values(p, values);
                continue;
            }
            if (!p.is_list) {
                color.take(k, values.next(p.type));
                continue;
            }
            uint64_t n = values.next_count(p);
            if (strips) {
                add_strip(mesh, p, n, values);
                continue;
            }
            face.clear();
            for (; n > 0; --n) face.push_back(corner(values.next(p.type), mesh.vertices.size(), values));
            if (face.size() < 3)
                loading.note(values.where(), "a face of fewer than three corners is left out");
            else
                add_face(mesh, face);
        }
        // All triangles of the face, however many they are
        if (color.given()) colors->faces.resize(mesh.triangles.size(), color.get(*colors));
    }
}

void skip_rows(const Element& e, PlyValues& values) {
    for (uint64_t i = 0; i < e.count; ++i)
        for (const Property& p : e.properties) skip_values(p, values);
}

/// A renderer's scene decides what its meshes have, and leaves the rest; a file that is a scene means what it
/// holds.
void tell_unread(const PlyHeader& h, const std::string& path, bool is_scene, Loading& loading) {
    const auto tell = [&](size_t line, const std::string& what) {
        const std::string where = at_line(path, line);
        return is_scene ? loading.warn(where, what) : loading.note(where, what);
    };
    if (h.texture_line && is_scene) tell(h.texture_line, "the picture of a TextureFile is not read");
    for (const Element& e : h.elements) {
        if (!e.is_read && e.count > 0 && !is_left_out(e.name, ""))
            tell(e.line, "element '" + e.name + "' is not read");
        for (const Property& p : e.properties)
            if (e.is_read && !p.is_read && !is_left_out(e.name, p.name))
                tell(p.line, "property '" + p.name + "' of element '" + e.name + "' is not read");
    }
}

}  // namespace

Mesh read_ply(const std::string& path, Loading& loading, const std::string& asked_at, FileColors* colors) {
    const std::string text = read_file(path, asked_at);
    PlyHeader header = read_ply_header(text, path);
    Mesh mesh;
    PlyValues values(text, header, path);
    uint64_t vertices = 0;
    for (const Element& e : header.elements)
        if (e.name == "vertex") vertices = e.count;
    const auto read = [&](Element& e, PlyValues& from) {
        e.is_read = true;
        mesh.triangles.reserve(mesh.triangles.size() + e.count);
        read_faces(mesh, e, from, loading, colors);
    };
    // Elements are stored in the order of the header, which need not begin with the vertices
    std::vector<std::pair<Element*, PlyValues>> later;
    for (Element& e : header.elements) {
        check_count(e, values, header.ascii, path);
        const bool faces = e.name == "face" || e.name == "tristrips";
        if (e.name == "vertex") {
            if (!mesh.vertices.empty()) fail(path, "the element 'vertex' is given twice");
            e.is_read = true;
            // `check_count` has bounded the count by the size of the file.
            mesh.vertices.reserve(e.count);
            read_vertices(mesh, e, values, colors);
        } else if (faces && mesh.vertices.size() == vertices) {
            read(e, values);
        } else {
            if (faces) later.emplace_back(&e, values);
            skip_rows(e, values);
        }
    }
    for (auto& [element, from] : later) read(*element, from);
    if (mesh.triangles.empty()) fail(path, "the file has no faces");
    if (colors && !colors->faces.empty()) colors->faces.resize(mesh.triangles.size());
    check_mesh(mesh, path);
    tell_unread(header, path, asked_at.empty(), loading);
    return mesh;
}

void load_ply(const std::string& path, Loading& loading) {
    FileColors colors;
    Mesh mesh = read_ply(path, loading, "", &colors);
    mesh.name = loading.scene.name;
    if (!colors.vertices.empty())
        mesh.colors = std::move(colors.vertices);
    else if (!colors.faces.empty())
        color_faces(mesh, colors.faces);
    if (colors.clamped) loading.warn(path, kClampedColors);
    const auto is_clear = [](VertexColor c) { return c.a == 0; };
    if (!mesh.colors.empty() && std::all_of(mesh.colors.begin(), mesh.colors.end(), is_clear)) {
        loading.note(path, "the alpha of all colours is 0; it is taken for 1");
        for (VertexColor& c : mesh.colors) c.a = 255;
    }
    mesh.material = loading.add_material(mesh.colors.empty() ? Material{} : colored_material());
    loading.add_mesh(std::move(mesh), path);
}

}  // namespace viscache::loading
