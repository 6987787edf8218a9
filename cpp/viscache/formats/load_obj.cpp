// Wavefront OBJ and MTL. Geometry is read here: tinyobjloader reads malformed numbers as 0 and silently drops
// faces with a wrong index. The other lines are checked first, then read by tinyobjloader.
#include <functional>
#include <istream>
#include <streambuf>
#include <unordered_map>

#define TINYOBJLOADER_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <tiny_obj_loader.h>
#pragma GCC diagnostic pop

#include "viscache/formats/loading.h"

namespace viscache::loading {

namespace {

constexpr size_t kMaxCorners = 1 << 20;  ///< maximum per face

std::string_view next_word(std::string_view& line) {
    const size_t begin = std::min(line.find_first_not_of(" \t\r\n"), line.size());
    const size_t end = std::min(line.find_first_of(" \t\r\n", begin), line.size());
    const std::string_view word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

std::string_view trimmed(std::string_view line) {
    const size_t begin = std::min(line.find_first_not_of(" \t\r\n"), line.size());
    return line.substr(begin, line.find_last_not_of(" \t\r\n") + 1 - begin);
}

std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 60)) + "'"; }

/// Passes a text on line by line, and knows the number of the line that is parsed. Lines that are taken
/// before are not passed on.
class Lines : public std::streambuf {
public:
    /// Checks a line; true if nothing is left to do with it.
    using Take = std::function<bool(std::string_view, const Lines&)>;
    Lines(std::string& text, const std::string& path, Take take)
        : text_(text), path_(path), take_(std::move(take)) {}

    std::string where() const { return at_line(path_, line_); }
    size_t line() const { return line_; }

protected:
    int_type underflow() override {
        // One line at a time is the stream's buffer, without a copy: tinyobjloader asks for the next line
        // when it has parsed this one, so `line_` is its place.
        while (begin_ < text_.size()) {
            const size_t begin = begin_, end = std::min(text_.find('\n', begin), text_.size() - 1) + 1;
            begin_ = end;
            ++line_;
            const std::string_view line(text_.data() + begin, end - begin);
            // tinyobjloader works with C strings and would stop at a zero.
            if (line.find('\0') != std::string_view::npos) fail(where(), "a zero byte in a text file");
            if (take_(line, *this)) continue;
            setg(text_.data() + begin, text_.data() + begin, text_.data() + end);
            return traits_type::to_int_type(*gptr());
        }
        return traits_type::eof();
    }

private:
    std::string& text_;
    const std::string& path_;
    Take take_;
    size_t begin_ = 0, line_ = 0;
};

/// The first three numbers of the rest of a line, which must hold `least` or more. Of six numbers, `color`
/// gets the last three.
Vec3 numbers(std::string_view rest, size_t least, const Lines& lines, std::optional<Rgb>* color = nullptr) {
    float first[6] = {};
    size_t n = 0;
    for (std::string_view w; !(w = next_word(rest)).empty(); ++n) {
        const auto x = parse_number(w);
        if (!x || !std::isfinite(*x))
            fail(lines.where(), "a finite number must stand here, got " + quoted(w));
        if (n < 6) first[n] = float(*x);
    }
    if (n < least)
        fail(lines.where(), std::to_string(least) + " numbers are needed, got " + std::to_string(n));
    if (color && n == 6) *color = Rgb{first[3], first[4], first[5]};
    return {first[0], first[1], first[2]};
}

/// Refuses words in place of numbers, and warns of numbers out of range, which are clamped.
bool check_mtl_line(std::string_view line, const Lines& lines, Loading& loading) {
    const std::string_view key = next_word(line);
    const bool share = key == "Kd" || key == "Ks" || key == "d" || key == "Tr";
    if (!share && key != "Ke" && key != "Ns" && key != "Ni") return false;
    const std::string name(key);
    std::string_view rest = line;
    if (next_word(rest).empty()) {
        loading.warn(lines.where(), name + " has no number; it counts as 0");
        return false;
    }
    // `Kd spectral file.rfl` names a file in place of numbers.
    if (line.find("spectral") != std::string_view::npos) return false;
    const Vec3 v = numbers(line, 1, lines);
    const float least = std::min({v.x, v.y, v.z}), most = max_component(v);
    if (share && (least < 0 || most > 1))
        loading.warn(lines.where(),
                     name + " must be in [0, 1], got " + quoted(trimmed(line)) + "; it is clamped");
    return false;
}

Rgb obj_rgb(const tinyobj::real_t* c) { return {c[0], c[1], c[2]}; }

/// Converts an MTL material to the nearest material.
Material convert(const tinyobj::material_t& in, const std::string& mtl, Loading& loading) {
    Material m;
    m.base_color = clamp01(obj_rgb(in.diffuse));
    const Rgb specular = clamp01(obj_rgb(in.specular));
    // MTL's illumination models: 3, 5 and 8 reflect, 4, 6, 7 and 9 are glass, all others are diffuse with a
    // highlight.
    if (in.illum == 3 || in.illum == 5 || in.illum == 8) {
        m.kind = MaterialKind::kMirror;
        m.specular = max_component(specular) > 0 ? specular : Rgb{1, 1, 1};
    } else if (in.illum == 4 || in.illum == 6 || in.illum == 7 || in.illum == 9) {
        m.kind = MaterialKind::kDielectric;
        m.eta = in.ior > 1 ? in.ior : 1.5f;
    } else if (max_component(specular) > 0 && in.shininess > 1) {
        m.kind = MaterialKind::kGlossy;
        m.specular = specular;
        // The roughness whose lobe is as wide as a Phong lobe of this exponent (Walter et al. 2007).
        m.roughness = clamp_roughness(std::sqrt(2.f / (in.shininess + 2.f)));
    }
    const std::string where = mtl + ": material '" + in.name + "'";
    if (!in.diffuse_texname.empty())
        m.base_texture = loading.add_image(resolve(mtl, in.diffuse_texname), where, true);
    if (!in.alpha_texname.empty())
        m.alpha_texture = loading.add_image(resolve(mtl, in.alpha_texname), where, false);
    if (m.kind != MaterialKind::kDielectric && in.alpha_texname.empty())
        m.opacity = std::clamp(float(in.dissolve), 0.f, 1.f);
    if (!in.bump_texname.empty() || !in.normal_texname.empty())
        loading.warn(where, "bump maps are not modelled");
    return m;
}

/// Reads the MTL files that an OBJ file names.
class MtlReader : public tinyobj::MaterialReader {
public:
    MtlReader(const Lines& lines, const std::string& obj, Loading* loading)
        : lines_(lines), obj_(obj), loading_(loading) {}

    bool operator()(const std::string& name, std::vector<tinyobj::material_t>* materials,
                    std::map<std::string, int>* map, std::string*, std::string*) override {
        // Meshes that another format names have a material of that format.
        if (!loading_) return false;
        const std::string path = resolve(obj_, name);
        try {
            std::string text = read_file(path, lines_.where());
            Lines mtl(text, path, [this](std::string_view line, const Lines& at) {
                return check_mtl_line(line, at, *loading_);
            });
            std::istream in(&mtl);
            in.exceptions(std::ios::badbit);
            std::string warning, error;
            tinyobj::LoadMtl(map, materials, &in, &warning, &error);
        } catch (const SceneError& error) {
            loading_->warn(lines_.where(), std::string(error.what()) + "; its materials are left out");
            return false;
        }
        // The list has grown by the materials of this file. Their images are relative to it.
        files.resize(materials->size(), path);
        return true;
    }

    std::vector<std::string> files;  ///< the MTL file of each material

private:
    const Lines& lines_;
    const std::string& obj_;
    Loading* loading_;
};

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
    uint32_t count, line;
    int material;
};

/// What the lines hold.
struct Collected {
    std::vector<Vec3> positions, normals;
    std::vector<Vec2> uvs;
    std::vector<std::optional<Rgb>> colors;  ///< of the first vertices, as in the file; none: white
    std::vector<Corner> corners;             ///< of all faces, in their order
    std::vector<Face> faces;
    std::vector<tinyobj::material_t> materials;
    std::vector<std::pair<size_t, std::string>>
        unknown;  ///< line and name of each material that no MTL file defines
    int material = -1;

    bool take(std::string_view line, const Lines& lines);

private:
    void take_face(std::string_view rest, const Lines& lines);
};

/// An index from 0 for one that counts from 1, or from the last entry if it is negative. Upper limits are
/// checked once the counts are known.
int32_t absolute(int64_t index, size_t count, const Lines& lines) {
    if (index > 0) return int32_t(index - 1);
    if (size_t(-index) > count)
        fail(lines.where(), "a face uses the relative index " + std::to_string(index) + " after " +
                                std::to_string(count) + " entries");
    return int32_t(int64_t(count) + index);
}

/// v, v/vt, v//vn or v/vt/vn.
void Collected::take_face(std::string_view rest, const Lines& lines) {
    // A negative index counts back from the entries read so far, so it is resolved here.
    const size_t counts[3] = {positions.size(), uvs.size(), normals.size()};
    size_t n = 0;
    for (std::string_view w; !(w = next_word(rest)).empty(); ++n) {
        int32_t found[3] = {-1, -1, -1};
        size_t part = 0;
        for (size_t begin = 0; begin <= w.size(); ++part) {
            const size_t end = std::min(w.find('/', begin), w.size());
            const std::string_view digits = w.substr(begin, end - begin);
            const auto index = parse_integer(digits);
            const bool may_be_empty = part == 1;
            if (part > 2 || (!index && !(may_be_empty && digits.empty())) ||
                (index && std::abs(*index) > 0x7ffffffe))
                fail(lines.where(), "a face corner must be v, v/vt, v//vn or v/vt/vn, got " + quoted(w));
            if (index && *index == 0) fail(lines.where(), "indices start at 1, got 0 in " + quoted(w));
            if (index) found[part] = absolute(*index, counts[part], lines);
            begin = end + 1;
        }
        corners.push_back({found[0], found[1], found[2]});
    }
    if (n < 3) fail(lines.where(), "a face must have 3 or more corners, got " + std::to_string(n));
    if (n > kMaxCorners) fail(lines.where(), "a face has " + std::to_string(n) + " corners");
    faces.push_back({uint32_t(n), uint32_t(lines.line()), material});
}

/// Takes the lines of geometry, of which there are most.
bool Collected::take(std::string_view line, const Lines& lines) {
    const std::string_view key = next_word(line);
    if (key == "v") {
        std::optional<Rgb> color;
        positions.push_back(numbers(line, 3, lines, &color));
        if (color) {
            colors.resize(positions.size() - 1);
            colors.push_back(color);
        }
    } else if (key == "vn") {
        normals.push_back(numbers(line, 3, lines));
    } else if (key == "vt") {
        const Vec3 uv = numbers(line, 1, lines);
        uvs.push_back({uv.x, uv.y});
    } else if (key == "f") {
        take_face(line, lines);
    } else {
        return false;
    }
    return true;
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

/// What tinyobjloader says about the rest of the lines. `user` is the pair of what was collected and the
/// lines.
using Told = std::pair<Collected*, const Lines*>;
tinyobj::callback_t callbacks() {
    tinyobj::callback_t cb;
    cb.usemtl_cb = [](void* user, const char* name, int id) {
        const auto& [all, lines] = *static_cast<Told*>(user);
        all->material = id;
        if (id < 0) all->unknown.emplace_back(lines->line(), name);
    };
    cb.mtllib_cb = [](void* user, const tinyobj::material_t* materials, int n) {
        static_cast<Told*>(user)->first->materials.assign(materials, materials + n);
    };
    return cb;
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
    bool has_normals = true, has_uvs = true;

    uint32_t vertex(const Corner& c, const Collected& all, const std::vector<VertexColor>& colors) {
        const auto [found, is_new] = known.try_emplace(c, uint32_t(mesh.vertices.size()));
        if (!is_new) return found->second;
        mesh.vertices.push_back(all.positions[size_t(c.v)]);
        if (!colors.empty()) mesh.colors.push_back(colors[size_t(c.v)]);
        mesh.normals.push_back(c.n >= 0 ? all.normals[size_t(c.n)] : Vec3{});
        mesh.uvs.push_back(c.t >= 0 ? all.uvs[size_t(c.t)] : Vec2{});
        // A mesh has a normal at every vertex or none.
        has_normals = has_normals && c.n >= 0;
        has_uvs = has_uvs && c.t >= 0;
        return found->second;
    }
};

std::map<int, Part> build_parts(const Collected& all, Loading* materials, const std::string& path) {
    std::map<int, Part> parts;
    std::vector<Vec3> polygon;
    std::vector<uint32_t> ids;
    std::vector<Vec3u> local;
    const auto colors = materials ? decoded_colors(all, path, *materials) : std::vector<VertexColor>{};
    const Corner* corner = all.corners.data();
    for (const Face& face : all.faces) {
        // One mesh per material. The map orders them by index, so the order of meshes does not depend on the
        // faces.
        Part& part = parts[materials ? face.material : -1];
        polygon.clear();
        ids.clear();
        local.clear();
        for (const Corner* const end = corner + face.count; corner != end; ++corner) {
            check_corner(*corner, all, path, face.line);
            ids.push_back(part.vertex(*corner, all, colors));
            polygon.push_back(all.positions[size_t(corner->v)]);
        }
        triangulate(polygon, local);
        for (const Vec3u& t : local) part.mesh.triangles.push_back({ids[t.x], ids[t.y], ids[t.z]});
    }
    return parts;
}

}  // namespace

std::vector<Mesh> read_obj(const std::string& path, Loading* materials, const std::string& asked_at) {
    std::string text = read_file(path, asked_at);
    Collected all;
    Lines lines(text, path, [&](std::string_view line, const Lines& at) { return all.take(line, at); });
    std::istream in(&lines);
    in.exceptions(std::ios::badbit);
    MtlReader mtl(lines, path, materials);
    std::string warning, error;
    Told told{&all, &lines};
    if (!tinyobj::LoadObjWithCallback(in, callbacks(), &told, &mtl, &warning, &error))
        fail(lines.where(), error);
    // The text is as large as the meshes that follow; it is not needed any more.
    std::string().swap(text);
    if (all.faces.empty()) fail(path, "the file has no faces");

    std::vector<Mesh> meshes;
    std::map<int, int> material_of;
    for (auto& [id, part] : build_parts(all, materials, path)) {
        Mesh mesh = std::move(part.mesh);
        if (!part.has_normals) mesh.normals.clear();
        if (!part.has_uvs) mesh.uvs.clear();
        if (materials) {
            const bool known = id >= 0 && size_t(id) < all.materials.size();
            mesh.material = materials->add_material(
                known ? convert(all.materials[size_t(id)], mtl.files.at(size_t(id)), *materials)
                : mesh.colors.empty() ? Material{}
                                      : colored_material());
            if (known) {
                mesh.name = all.materials[size_t(id)].name;
                mesh.emission = obj_rgb(all.materials[size_t(id)].emission);
            }
        }
        check_mesh(mesh, path);
        meshes.push_back(std::move(mesh));
    }
    if (materials)
        for (const auto& [line, name] : all.unknown)
            materials->warn(at_line(path, line), "material '" + name + "' is not defined; grey is used");
    return meshes;
}

void load_obj(const std::string& path, Loading& loading) {
    for (Mesh& mesh : read_obj(path, &loading)) loading.add_mesh(std::move(mesh), path);
}

}  // namespace viscache::loading
