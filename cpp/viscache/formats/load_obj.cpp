// Wavefront OBJ: lines, faces, and a mesh for each material. mtl.cpp reads the materials.
#include <unordered_map>

#include "viscache/formats/mtl.h"

namespace viscache::loading {

namespace {

constexpr size_t kMaxCorners = 1 << 20;  ///< maximum per face

/// The numbers of the rest of a line, which must hold `least` or more.
Numbers numbers(std::string_view rest, size_t least, const WavefrontLines& lines) {
    const Numbers found = numbers_of(rest);
    if (!found.wrong.empty())
        fail(lines.where(), "a finite number must stand here, got " + quoted(found.wrong));
    if (found.count < least)
        fail(lines.where(),
             std::to_string(least) + " numbers are needed, got " + std::to_string(found.count));
    return found;
}

/// What becomes of a line that is no geometry.
enum class ObjLine { kHarmless, kMaterial, kMaterialFile, kSmoothing, kPointOrLine, kCurve, kUnread };

constexpr std::pair<std::string_view, ObjLine> kObjKeys[] = {
    {"g", ObjLine::kHarmless},  // names
    {"o", ObjLine::kHarmless},     {"usemtl", ObjLine::kMaterial},   {"mtllib", ObjLine::kMaterialFile},
    {"s", ObjLine::kSmoothing},    {"p", ObjLine::kPointOrLine},     {"l", ObjLine::kPointOrLine},
    {"lod", ObjLine::kHarmless},  // how viewers draw
    {"bevel", ObjLine::kHarmless}, {"c_interp", ObjLine::kHarmless}, {"d_interp", ObjLine::kHarmless},
    {"vp", ObjLine::kCurve},       {"cstype", ObjLine::kCurve},      {"deg", ObjLine::kCurve},
    {"bmat", ObjLine::kCurve},     {"step", ObjLine::kCurve},        {"curv", ObjLine::kCurve},
    {"curv2", ObjLine::kCurve},    {"surf", ObjLine::kCurve},        {"parm", ObjLine::kCurve},
    {"trim", ObjLine::kCurve},     {"hole", ObjLine::kCurve},        {"scrv", ObjLine::kCurve},
    {"sp", ObjLine::kCurve},       {"end", ObjLine::kCurve},         {"con", ObjLine::kCurve},
    {"mg", ObjLine::kHarmless},    {"ctech", ObjLine::kCurve},       {"stech", ObjLine::kCurve},
};

ObjLine kind_of(std::string_view key) {
    for (const auto& [name, kind] : kObjKeys)
        if (name == key) return kind;
    return ObjLine::kUnread;
}

/// Indices from 0; -1: not given.
struct Corner {
    int32_t v = -1, t = -1, n = -1;
    bool operator==(const Corner&) const = default;
};

struct CornerHash {
    size_t operator()(const Corner& c) const {
        uint64_t h = uint64_t(c.v) * 0x9E3779B97F4A7C15ull ^ (uint64_t(c.t) + 1) * 0xC2B2AE3D27D4EB4Full ^
                     (uint64_t(c.n) + 1) * 0x165667B19E3779F9ull;
        return h ^ (h >> 29);
    }
};

struct Face {
    uint32_t count, line, state;
};

/// What holds for the faces that follow.
struct State {
    int name = -1;          ///< of the material, in `names`
    int64_t smoothing = 0;  ///< group; 0: none
};

/// What the lines hold.
struct Collected {
    explicit Collected(Loading& loading) : loading(loading) {}

    Loading& loading;
    std::vector<Vec3> positions, normals;
    std::vector<Vec2> uvs;
    std::vector<std::optional<Rgb>> colors;  ///< of the first vertices, as in the file; none: white
    std::vector<Corner> corners;             ///< of all faces, in their order
    std::vector<Face> faces;
    std::vector<State> states{State{}};
    std::map<std::string, int> name_ids;
    /// Names of materials and of MTL files, with the first place.
    std::vector<std::pair<std::string, std::string>> names, files;

    void take(std::string_view line, const WavefrontLines& lines);

private:
    void take_face(std::string_view rest, const WavefrontLines& lines);
    void take_smoothing(std::string_view rest, const WavefrontLines& lines);
    void take_files(std::string_view rest, const WavefrontLines& lines);
};

/// An index from 0 for one that counts from 1, or from the last entry if it is negative. Upper limits are
/// checked once the counts are known.
int32_t absolute(int64_t index, size_t count, const WavefrontLines& lines) {
    if (index > 0) return int32_t(index - 1);
    if (size_t(-index) > count)
        fail(lines.where(), "a face uses the relative index " + std::to_string(index) + " after " +
                                std::to_string(count) + " entries");
    return int32_t(int64_t(count) + index);
}

/// v, v/vt, v//vn or v/vt/vn. Slots may be empty.
void Collected::take_face(std::string_view rest, const WavefrontLines& lines) {
    // A negative index counts back from the entries read so far, so it is resolved here.
    const size_t counts[3] = {positions.size(), uvs.size(), normals.size()};
    size_t n = 0;
    for (std::string_view w; !(w = next_word(rest)).empty() && w[0] != '#'; ++n) {
        int32_t found[3] = {-1, -1, -1};
        size_t part = 0;
        for (size_t begin = 0; begin <= w.size(); ++part) {
            const size_t end = std::min(w.find('/', begin), w.size());
            const std::string_view digits = w.substr(begin, end - begin);
            const auto index = parse_integer(digits);
            if (part > 2 || (!index && !(part > 0 && digits.empty())) ||
                (index && std::abs(*index) > 0x7ffffffe))
                fail(lines.where(), "a face corner must be v, v/vt, v//vn or v/vt/vn, got " + quoted(w));
            if (index && *index == 0 && part == 0)
                fail(lines.where(), "indices start at 1, got 0 in " + quoted(w));
            if (index && *index == 0) loading.note(lines.where(), "an index of 0 counts as none");
            if (index && *index != 0) found[part] = absolute(*index, counts[part], lines);
            begin = end + 1;
        }
        corners.push_back({found[0], found[1], found[2]});
    }
    if (n > kMaxCorners) fail(lines.where(), "a face has " + std::to_string(n) + " corners");
    if (n >= 3) return faces.push_back({uint32_t(n), uint32_t(lines.number()), uint32_t(states.size() - 1)});
    loading.note(lines.where(), "a face of fewer than three corners is skipped");
    corners.resize(corners.size() - n);
}

void Collected::take_smoothing(std::string_view rest, const WavefrontLines& lines) {
    const std::string_view word = next_word(rest);
    const auto group = word == "on" ? 1 : word == "off" || word.empty() ? 0 : parse_integer(word);
    if (!group) loading.warn(lines.where(), "a smoothing group must be a number or off; off is used");
    states.push_back({states.back().name, group.value_or(0)});
}

/// Names of files end at the end of the line, or with ".mtl". They may have spaces.
void Collected::take_files(std::string_view rest, const WavefrontLines& lines) {
    std::string name;
    for (std::string_view w; !(w = next_word(rest)).empty();) {
        name += (name.empty() ? "" : " ") + std::string(w);
        if (!lower(w).ends_with(".mtl") && !trimmed(rest).empty()) continue;
        files.emplace_back(name, lines.where());
        name.clear();
    }
}

void Collected::take(std::string_view line, const WavefrontLines& lines) {
    const std::string_view key = next_word(line);
    if (key == "v") {
        const Numbers given = numbers(line, 3, lines);
        positions.push_back(given.first);
        if (given.count == 6) {
            colors.resize(positions.size() - 1);
            colors.push_back(given.next);
        }
    } else if (key == "vn") {
        normals.push_back(numbers(line, 3, lines).first);
    } else if (key == "vt") {
        const Vec3 uv = numbers(line, 1, lines).first;
        uvs.push_back({uv.x, uv.y});
    } else if (key == "f") {
        take_face(line, lines);
    } else if (key == "#MRGB") {
        loading.warn(lines.where(), "colours of vertices in comments of ZBrush (#MRGB) are not read");
    } else if (!key.empty() && key[0] != '#') {
        const ObjLine kind = kind_of(key);
        if (kind == ObjLine::kMaterial) {
            const auto [found, is_new] = name_ids.try_emplace(std::string(trimmed(line)), int(names.size()));
            if (is_new) names.emplace_back(found->first, lines.where());
            states.push_back({found->second, states.back().smoothing});
        } else if (kind == ObjLine::kMaterialFile) {
            take_files(line, lines);
        } else if (kind == ObjLine::kSmoothing) {
            take_smoothing(line, lines);
        } else if (kind == ObjLine::kPointOrLine) {
            loading.note(lines.where(), "points and lines have no surface; they are skipped");
        } else if (kind == ObjLine::kCurve) {
            loading.warn(lines.where(), "curves and free surfaces are not modelled; they are skipped");
        } else if (kind == ObjLine::kUnread) {
            loading.warn(lines.where(), "'" + std::string(key.substr(0, 60)) + "' is not read");
        }
    }
}

/// sRGB, as MeshLab and Blender write them; whole numbers are bytes where some are above 1.
std::vector<VertexColor> decoded_colors(const Collected& all, const std::string& path, Loading& loading) {
    using Color = std::optional<Rgb>;
    const auto whole = [](const Color& c) {
        return !c || *c == Rgb{std::round(c->x), std::round(c->y), std::round(c->z)};
    };
    const auto& given = all.colors;
    const bool outside =
        std::any_of(given.begin(), given.end(), [](const Color& c) { return c && is_clamped(*c); });
    const float scale = outside && std::all_of(given.begin(), given.end(), whole) ? 1 : 255;
    const auto byte = [&](float x) { return uint8_t(std::lround(std::clamp(x * scale, 0.f, 255.f))); };
    if (outside && scale == 255) loading.warn(path, kClampedColors);
    std::vector<VertexColor> colors(given.empty() ? 0 : all.positions.size());
    for (size_t i = 0; i < given.size(); ++i)
        if (given[i]) colors[i] = {byte(given[i]->x), byte(given[i]->y), byte(given[i]->z)};
    return colors;
}

void check_corner(const Corner& c, const Collected& all, const std::string& path, size_t line) {
    const auto check = [&](int64_t i, size_t count, const char* what) {
        if (i >= int64_t(count))
            fail(at_line(path, line), std::string("a face uses ") + what + " index " + std::to_string(i + 1) +
                                          ", the file has " + std::to_string(count));
    };
    check(c.v, all.positions.size(), "vertex");
    check(c.t, all.uvs.size(), "texture coordinate");
    check(c.n, all.normals.size(), "normal");
}

/// A mesh under construction. Equal (v, vt, vn) corners share one vertex.
struct Part {
    Mesh mesh;
    std::unordered_map<Corner, uint32_t, CornerHash> known;
    bool has_normals = false, lacks_normals = false;  ///< at some corners
    bool has_uvs = false;
    uint32_t without_uvs = 0;  ///< line of the first such face; 0: none

    uint32_t vertex(const Corner& c, const Collected& all, const std::vector<VertexColor>& colors) {
        const auto [found, is_new] = known.try_emplace(c, uint32_t(mesh.vertices.size()));
        if (!is_new) return found->second;
        mesh.vertices.push_back(all.positions[size_t(c.v)]);
        if (!colors.empty()) mesh.colors.push_back(colors[size_t(c.v)]);
        mesh.normals.push_back(c.n >= 0 ? all.normals[size_t(c.n)] : Vec3{});
        mesh.uvs.push_back(c.t >= 0 ? all.uvs[size_t(c.t)] : Vec2{});
        return found->second;
    }
};

/// Meshes by material. The map orders them by index, so the order of meshes does not depend on the faces.
using Parts = std::map<int, Part>;

/// Checks the corners, and finds what the faces of each mesh have and lack. `material`: of each state.
Parts check_faces(const Collected& all, const std::vector<int>& material, bool smooths,
                  const std::string& path) {
    Parts parts;
    const Corner* corner = all.corners.data();
    for (const Face& face : all.faces) {
        Part& part = parts[material[face.state]];
        // A mesh has normals at every vertex or at none.
        if (smooths && all.states[face.state].smoothing != 0) part.has_normals = true;
        for (const Corner* const end = corner + face.count; corner != end; ++corner) {
            check_corner(*corner, all, path, face.line);
            (corner->n >= 0 ? part.has_normals : part.lacks_normals) = true;
            if (corner->t >= 0)
                part.has_uvs = true;
            else if (part.without_uvs == 0)
                part.without_uvs = face.line;
        }
    }
    return parts;
}

/// Gives corners without a normal one, where the mesh has others: that of the smoothing group at this vertex,
/// otherwise that of the face.
void fill_normals(Collected& all, const std::vector<int>& material, bool smooths, const Parts& parts) {
    const auto given = all.normals.size();
    std::map<std::pair<int32_t, int64_t>, int32_t> of_group;
    Corner* corner = all.corners.data();
    for (const Face& face : all.faces) {
        Corner* const first = corner;
        corner += face.count;
        const Part& part = parts.at(material[face.state]);
        if (!part.has_normals || !part.lacks_normals) continue;
        const int64_t group = smooths ? all.states[face.state].smoothing : 0;
        const auto at = [&](size_t k) { return all.positions[size_t(first[k % face.count].v)]; };
        Vec3 normal{};
        for (size_t k = 2; k < face.count; ++k) normal += cross(at(k - 1) - at(0), at(k) - at(0));
        const float size = length(normal);
        normal = size > 0 ? normal / size : Vec3{0, 0, 1};
        int32_t of_face = -1;
        for (size_t k = 0; k < face.count; ++k) {
            if (first[k].n >= 0) continue;
            int32_t& n = group ? of_group.try_emplace({first[k].v, group}, -1).first->second : of_face;
            if (n < 0) {
                n = int32_t(all.normals.size());
                all.normals.push_back({});
            }
            first[k].n = n;
            // Weighted by the angle at the corner, as Mitsuba does
            const Vec3 a = at(k + 1) - at(k), b = at(k + face.count - 1) - at(k);
            const float angle = std::atan2(length(cross(a, b)), dot(a, b));
            all.normals[size_t(n)] += normal * (group && size > 0 ? angle : 1);
        }
    }
    for (size_t i = given; i < all.normals.size(); ++i) {
        Vec3& n = all.normals[i];
        n = length2(n) > 0 ? normalize(n) : Vec3{0, 0, 1};
    }
}

/// `colors`: of the vertices; may be empty.
void build_meshes(const Collected& all, const std::vector<int>& material,
                  const std::vector<VertexColor>& colors, Parts& parts) {
    std::vector<Vec3> polygon;
    std::vector<uint32_t> ids;
    std::vector<Vec3u> local;
    const Corner* corner = all.corners.data();
    for (const Face& face : all.faces) {
        Part& part = parts[material[face.state]];
        polygon.clear();
        ids.clear();
        local.clear();
        for (const Corner* const end = corner + face.count; corner != end; ++corner) {
            ids.push_back(part.vertex(*corner, all, colors));
            polygon.push_back(all.positions[size_t(corner->v)]);
        }
        triangulate(polygon, local);
        for (const Vec3u& t : local) part.mesh.triangles.push_back({ids[t.x], ids[t.y], ids[t.z]});
    }
    for (auto& [id, part] : parts) {
        part.known.clear();
        if (!part.has_normals) part.mesh.normals.clear();
        if (!part.has_uvs) part.mesh.uvs.clear();
    }
}

/// Gives a mesh its material, whose images need texture coordinates.
void set_look(Part& part, MtlReader& mtl, int index, Loading& loading, const std::string& path) {
    const MtlReader::Look look = index >= 0 ? mtl.look(index) : MtlReader::Look{};
    Mesh& mesh = part.mesh;
    const bool is_plain = index < 0 && !mesh.colors.empty();
    mesh.material = loading.add_material(is_plain ? colored_material() : look.material);
    mesh.emission = look.emission;
    mesh.emission_texture = look.emission_texture;
    if (index >= 0) mesh.name = mtl.name(index);
    if (part.without_uvs != 0 && (uses_image(look.material) || look.emission_texture >= 0))
        loading.warn(at_line(path, part.without_uvs),
                     "faces without texture coordinates show their image at (0, 0)");
    transform_uvs(mesh, look.uv.get());
}

}  // namespace

std::vector<Mesh> read_obj(const std::string& path, Loading& loading, bool with_materials,
                           const std::string& asked_at) {
    Collected all(loading);
    {
        // The text is as large as the meshes that follow; it is not needed any more then.
        const std::string text = read_file(path, asked_at);
        WavefrontLines lines(text, path);
        for (std::string_view line; lines.next(line);) all.take(line, lines);
    }
    if (all.faces.empty()) fail(path, "the file has no faces");
    // Meshes that another format names have a material of that format. Mitsuba does not read smoothing
    // groups.
    MtlReader mtl(loading);
    std::vector<int> of_name(with_materials ? all.names.size() : 0, -1), material;
    if (with_materials)
        for (const auto& [name, where] : all.files) mtl.read(resolve(path, name), where);
    for (size_t i = 0; i < of_name.size(); ++i)
        if ((of_name[i] = mtl.find(all.names[i].first)) < 0)
            loading.warn(all.names[i].second, "a material that no MTL file defines is grey");
    for (const State& state : all.states)
        material.push_back(state.name >= 0 && with_materials ? of_name[size_t(state.name)] : -1);

    Parts parts = check_faces(all, material, with_materials, path);
    fill_normals(all, material, with_materials, parts);
    build_meshes(all, material,
                 with_materials ? decoded_colors(all, path, loading) : std::vector<VertexColor>{}, parts);
    std::vector<Mesh> meshes;
    for (auto& [id, part] : parts) {
        if (with_materials) set_look(part, mtl, id, loading, path);
        check_mesh(part.mesh, path);
        meshes.push_back(std::move(part.mesh));
    }
    return meshes;
}

void load_obj(const std::string& path, Loading& loading) {
    for (Mesh& mesh : read_obj(path, loading, true)) loading.add_mesh(std::move(mesh), path);
}

}  // namespace viscache::loading
