#include "viscache/formats/loading.h"

#include <charconv>
#include <filesystem>
#include <fstream>

#include "viscache/formats/allowed_files.h"
#include "viscache/scene/vertex_limit.h"

namespace viscache::loading {

void fail(const std::string& where, const std::string& what) {
    throw SceneError(printable(where + ": " + what));
}

namespace {

/// Length in bytes of the UTF-8 character at `i`; 0 if there is no valid one.
size_t character_length(std::string_view text, size_t i) {
    const auto byte = [&](size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned char first = byte(i);
    if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
    const size_t n = first >= 0xc2 && first < 0xe0   ? 2
                     : (first & 0xf0) == 0xe0        ? 3
                     : first >= 0xf0 && first < 0xf5 ? 4
                                                     : 0;
    if (n == 0 || i + n > text.size()) return 0;
    for (size_t k = 1; k < n; ++k)
        if ((byte(i + k) & 0xc0) != 0x80) return 0;
    // Reject overlong forms, surrogates and code points beyond U+10FFFF.
    const unsigned char second = byte(i + 1);
    if ((first == 0xe0 && second < 0xa0) || (first == 0xed && second >= 0xa0) ||
        (first == 0xf0 && second < 0x90) || (first == 0xf4 && second >= 0x90))
        return 0;
    return n;
}

}  // namespace

std::string printable(std::string text) {
    for (size_t i = 0; i < text.size();) {
        const size_t n = character_length(text, i);
        if (n == 0) text[i] = '?';
        i += std::max<size_t>(n, 1);
    }
    return text;
}

std::string at_line(const std::string& file, size_t line) { return file + ":" + std::to_string(line); }

void check_allowed(const std::string& path, const std::string& where) {
    if (const AllowedFiles* allowed = AllowedFiles::current(); allowed && !allowed->allows(path))
        fail(where, "the file lies outside of the scene's folder; allow_outside=True permits that");
}

uint64_t check_file(const std::string& path, const std::string& asked_at) {
    namespace fs = std::filesystem;
    const std::string where = asked_at.empty() ? path : asked_at + ": " + path;
    std::error_code error;
    if (path.find('\0') != std::string::npos) fail(asked_at, "a file name holds a zero byte");
    check_allowed(path, where);
    if (!fs::exists(path, error)) fail(where, "the file does not exist");
    if (!fs::is_regular_file(path, error)) fail(where, "not a regular file");
    const uint64_t size = fs::file_size(path, error);
    if (error) fail(where, "the file cannot be read: " + error.message());
    if (size == 0) fail(where, "the file is empty");
    if (size > kMaxFileBytes)
        fail(where, "the file has " + std::to_string(size) + " bytes, at most 8 GiB are read");
    return size;
}

std::string read_file(const std::string& path, const std::string& asked_at) {
    const uint64_t size = check_file(path, asked_at);
    const std::string where = asked_at.empty() ? path : asked_at + ": " + path;
    std::ifstream in(path, std::ios::binary);
    std::string content(size, '\0');
    if (!in.read(content.data(), std::streamsize(size))) fail(where, "the file cannot be read");
    return content;
}

std::string resolve(const std::string& base_file, const std::string& name) {
    std::string clean = name;
    std::replace(clean.begin(), clean.end(), '\\', '/');
    return (std::filesystem::path(base_file).parent_path() / clean).lexically_normal().string();
}

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
    return out;
}

std::string extension_of(const std::string& path) {
    return lower(std::filesystem::path(path).extension().string());
}

std::optional<double> parse_number(std::string_view token) {
    if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc() || end != token.data() + token.size()) return {};
    return value;
}

std::optional<int64_t> parse_integer(std::string_view token) {
    if (token.size() > 1 && token[0] == '+' && token[1] != '-') token.remove_prefix(1);
    int64_t value = 0;
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), value);
    if (error != std::errc() || end != token.data() + token.size()) return {};
    return value;
}

LineIndex::LineIndex(std::string_view text) : starts_{0} {
    for (size_t i = 0; i < text.size(); ++i)
        if (text[i] == '\n') starts_.push_back(i + 1);
}

size_t LineIndex::line(size_t offset) const {
    return size_t(std::upper_bound(starts_.begin(), starts_.end(), offset) - starts_.begin());
}

void Loading::warn(const std::string& where, const std::string& text) {
    if (strict) fail(where, text);
    note(where, text);
}

void Loading::note(const std::string& where, const std::string& text) {
    const auto [at, is_new] = said_.try_emplace(text, Said{scene.warnings.size(), 1, {}});
    if (is_new) return scene.warnings.push_back({where, text});
    Said& said = at->second;
    ++said.times;
    const bool is_told = where == scene.warnings[said.index].where ||
                         std::find(said.also.begin(), said.also.end(), where) != said.also.end();
    if (said.also.size() < 2 && !is_told) said.also.push_back(where);
}

void Loading::count_warnings() {
    for (const auto& [text, said] : said_) {
        if (said.times == 1) continue;
        std::string& told = scene.warnings[said.index].text;
        told += " (" + std::to_string(said.times) + " times";
        for (size_t i = 0; i < said.also.size(); ++i) told += (i ? " and " : ", also at ") + said.also[i];
        told += ")";
    }
}

int Loading::add_material(const Material& material) {
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

bool Loading::has_mesh_file(const std::string& path, const std::string& where) {
    std::error_code error;
    // First, since even the answer whether a file exists says something about the machine.
    check_allowed(path, where + ": " + path);
    if (std::filesystem::exists(path, error)) return true;
    if (!skip_missing)
        fail(where + ": " + path, "the file does not exist; missing=\"skip\" leaves such shapes out");
    warn(where, "the file '" + path + "' does not exist; the shape is left out");
    return false;
}

void set_look_up(Image& image, LookUp look_up) {
    image.nearest = look_up.nearest;
    image.wrap_u = look_up.u;
    image.wrap_v = look_up.v;
}

std::optional<Wrap> wrap_named(std::string_view name) {
    if (name == "repeat") return Wrap::kRepeat;
    if (name == "mirror") return Wrap::kMirror;
    if (name == "clamp") return Wrap::kClamp;
    return {};
}

int Loading::add_image(const std::string& path, const std::string& where, bool srgb, LookUp look_up) {
    // One file may serve as a colour and as numbers, or be looked up in two ways: each is an image of its
    // own.
    const auto [found, is_new] = images_.try_emplace({path, srgb, look_up}, int(scene.images.size()));
    if (is_new) {
        Image image;
        image.path = path;
        image.where = where;
        image.srgb = srgb;
        set_look_up(image, look_up);
        scene.images.push_back(std::move(image));
    }
    return found->second;
}

int Loading::add_checkerboard(Rgb a, Rgb b, const std::string& where) {
    const auto [found, is_new] =
        checkerboards_.try_emplace({a.x, a.y, a.z, b.x, b.y, b.z}, int(scene.images.size()));
    if (is_new) {
        Image image;
        image.where = where;
        image.srgb = false;
        image.nearest = true;
        image.width = image.height = 2;
        image.channels = 3;
        // The row at the top is v > 1/2
        image.pixels = {b.x, b.y, b.z, a.x, a.y, a.z, a.x, a.y, a.z, b.x, b.y, b.z};
        scene.images.push_back(std::move(image));
    }
    return found->second;
}

int Loading::add_mesh(Mesh mesh, const std::string& where) {
    // Every mesh of every format passes here, so the rest of the program indexes without checks.
    check_mesh(mesh, where);
    scene.meshes.push_back(std::move(mesh));
    return int(scene.meshes.size()) - 1;
}

void Loading::set_environment(const Environment& environment, const std::string& where) {
    if (scene.environment) return warn(where, "a second environment light is skipped; the first one is kept");
    add_environment(environment, where);
}

void Loading::add_environment(Environment environment, const std::string& where) {
    constexpr size_t kMostAdded = 15;  // each is as much work as a sky of its own
    // Keep the rotation: remove translation and scale.
    auto& m = environment.to_world.m;
    for (int j = 0; j < 3; ++j) {
        const double l = std::sqrt(m[0][j] * m[0][j] + m[1][j] * m[1][j] + m[2][j] * m[2][j]);
        if (!(l > 0) || !std::isfinite(l)) fail(where, "the environment's transform is singular");
        for (int i = 0; i < 3; ++i) m[i][j] /= l;
    }
    for (int i = 0; i < 3; ++i) m[i][3] = 0;
    if (!scene.environment) {
        scene.environment = environment;
    } else if (environment.image < 0 && scene.environment->image < 0) {
        scene.environment->scale += environment.scale;
    } else {
        if (scene.added_environments.size() >= kMostAdded)
            fail(where, "at most 16 infinite lights with images are added up");
        scene.added_environments.push_back(environment);
        note(where, "infinite lights with images add up; their sum is resampled into one map");
    }
}

namespace {

std::string text_of(Vec3 p) {
    return "(" + std::to_string(p.x) + ", " + std::to_string(p.y) + ", " + std::to_string(p.z) + ")";
}

void check_size(size_t have, size_t vertices, const char* what, const std::string& where) {
    // Normals and texture coordinates are given for all vertices or for none.
    if (have != 0 && have != vertices)
        fail(where, std::to_string(have) + " " + what + " for " + std::to_string(vertices) + " vertices");
}

}  // namespace

void check_mesh(const Mesh& mesh, const std::string& where) {
    if (mesh.triangles.empty()) fail(where, "the mesh has no triangles");
    const size_t n = mesh.vertices.size();
    // Indices have 32 bits.
    if (n > 0xffffffffull) fail(where, "more than 2^32 - 1 vertices");
    for (size_t i = 0; i < n; ++i) {
        const Vec3 p = mesh.vertices[i];
        if (!is_usable_vertex(p))
            fail(where, "vertex " + std::to_string(i) + " is " + text_of(p) +
                            "; coordinates must be finite and at most 1e12");
    }
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Vec3u t = mesh.triangles[i];
        const uint32_t worst = std::max({t.x, t.y, t.z});
        if (worst >= n)
            fail(where, "triangle " + std::to_string(i) + " uses vertex index " + std::to_string(worst) +
                            ", the mesh has " + std::to_string(n) + " vertices");
    }
    check_size(mesh.normals.size(), n, "normals", where);
    check_size(mesh.uvs.size(), n, "texture coordinates", where);
    check_size(mesh.colors.size(), n, "colours", where);
    for (size_t i = 0; i < mesh.normals.size(); ++i)
        if (!is_finite(mesh.normals[i])) fail(where, "normal " + std::to_string(i) + " is not finite");
    for (size_t i = 0; i < mesh.uvs.size(); ++i)
        if (!std::isfinite(mesh.uvs[i].x) || !std::isfinite(mesh.uvs[i].y))
            fail(where, "texture coordinate " + std::to_string(i) + " is not finite");
    if (!is_finite(mesh.emission)) fail(where, "the emission is not finite");
}

void transform_mesh(Mesh& mesh, const Affine& t) {
    for (Vec3& p : mesh.vertices) p = t.point(p);
    // Normals are multiplied by the inverse transpose, which keeps them perpendicular to the surface.
    for (Vec3& n : mesh.normals) n = normalize(t.normal(n));
}

void transform_uvs(Mesh& mesh, const UvTransform& t) {
    if (t.is_identity()) return;
    for (Vec2& uv : mesh.uvs) uv = t(uv);
}

bool is_clamped(Rgb c) { return !(max_component(c) < 1.001f && std::min({c.x, c.y, c.z}) > -0.001f); }

Material colored_material() {
    Material m;
    m.base_color = {1, 1, 1};
    m.alpha_cutoff = -1;
    return m;
}

bool uses_image(const Material& material) {
    const int images[] = {material.base_texture, material.alpha_texture, material.metallic_roughness_texture,
                          material.roughness_texture};
    return std::any_of(std::begin(images), std::end(images), [](int image) { return image >= 0; });
}

void add_triangle_uvs(Mesh& mesh, std::initializer_list<CornerUvs> turns) {
    // Coordinates that differ from triangle to triangle need vertices that no two triangles share.
    if (!mesh.uvs.empty()) return;
    Mesh split;
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Vec3u t = mesh.triangles[i];
        const uint32_t corners[3] = {t.x, t.y, t.z};
        const CornerUvs& uvs = turns.begin()[i % turns.size()];
        for (int k = 0; k < 3; ++k) {
            split.vertices.push_back(mesh.vertices[corners[k]]);
            if (!mesh.normals.empty()) split.normals.push_back(mesh.normals[corners[k]]);
            if (!mesh.colors.empty()) split.colors.push_back(mesh.colors[corners[k]]);
            split.uvs.push_back(uvs[size_t(k)]);
        }
        const auto first = uint32_t(3 * i);
        mesh.triangles[i] = {first, first + 1, first + 2};
    }
    mesh.vertices = std::move(split.vertices);
    mesh.normals = std::move(split.normals);
    mesh.colors = std::move(split.colors);
    mesh.uvs = std::move(split.uvs);
}

// The winding says which side is the front; normals only shade.
void flip_winding(Mesh& mesh) {
    for (Vec3u& t : mesh.triangles) std::swap(t.y, t.z);
}

void flip_normals(Mesh& mesh) {
    flip_winding(mesh);
    for (Vec3& n : mesh.normals) n = -n;
}

void wind_by_normals(Mesh& mesh) {
    if (mesh.normals.size() != mesh.vertices.size()) return;
    for (Vec3u& t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t.x], n = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
        // Three normals together, since one at a sharp edge may point to the other side.
        if (dot(cross(mesh.vertices[t.y] - a, mesh.vertices[t.z] - a), n) < 0) std::swap(t.y, t.z);
    }
}

void append_mesh(Mesh& a, const Mesh& b) {
    const auto base = uint32_t(a.vertices.size());
    // One part without normals leaves the whole without, since they are per vertex.
    if (base && a.normals.empty() != b.normals.empty())
        a.normals.clear();
    else
        a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
    if (base && a.uvs.empty() != b.uvs.empty())
        a.uvs.clear();
    else
        a.uvs.insert(a.uvs.end(), b.uvs.begin(), b.uvs.end());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const Vec3u& t : b.triangles) a.triangles.push_back({t.x + base, t.y + base, t.z + base});
}

bool is_finite(const Affine& t) {
    for (const auto& row : t.m)
        for (double x : row)
            if (!std::isfinite(x)) return false;
    return true;
}

std::optional<Affine> inverse_of(const Affine& t) {
    const double det = t.determinant();
    // The determinant may underflow or overflow although all entries are finite.
    if (!is_finite(t) || !std::isfinite(det) || det == 0) return {};
    Affine r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int a = (j + 1) % 3, b = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            r.m[i][j] = (t.m[a][c] * t.m[b][d] - t.m[a][d] * t.m[b][c]) / det;
        }
    for (int i = 0; i < 3; ++i)
        r.m[i][3] = -(r.m[i][0] * t.m[0][3] + r.m[i][1] * t.m[1][3] + r.m[i][2] * t.m[2][3]);
    if (!is_finite(r)) return {};
    return r;
}

Affine translation(double x, double y, double z) {
    Affine t;
    t.m[0][3] = x;
    t.m[1][3] = y;
    t.m[2][3] = z;
    return t;
}

Affine scaling(double x, double y, double z) {
    Affine t;
    t.m[0][0] = x;
    t.m[1][1] = y;
    t.m[2][2] = z;
    return t;
}

Affine rotation(double degrees, double x, double y, double z, bool unit_axis) {
    const double length = unit_axis ? std::sqrt(x * x + y * y + z * z) : 1;
    Affine t;
    // An axis of zero names no rotation.
    if (!(length > 0)) return t;
    const double a[3] = {x / length, y / length, z / length};
    const double angle = degrees * kDegree;
    const double c = std::cos(angle), s = std::sin(angle);
    // Rodrigues' formula: c I + s [a]x + (1 - c) a aᵀ.
    const double cross[3][3] = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) t.m[i][j] = (i == j ? c : 0) + s * cross[i][j] + (1 - c) * a[i] * a[j];
    return t;
}

std::optional<double> uniform_scale(const Affine& t) {
    double dots[3][3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            dots[i][j] = t.m[0][i] * t.m[0][j] + t.m[1][i] * t.m[1][j] + t.m[2][i] * t.m[2][j];
    const double s2 = (dots[0][0] + dots[1][1] + dots[2][2]) / 3;
    // The columns must be perpendicular and equally long, up to the rounding of what files write: Mᵀ M = s²
    // I.
    if (!(s2 > 0) || !std::isfinite(s2)) return {};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (std::abs(dots[i][j] - (i == j ? s2 : 0)) > 1e-4 * s2) return {};
    return std::sqrt(s2);
}

void crop_camera(Camera& c, int left, int top, int width, int height) {
    const double across = double(c.width) / width, upwards = double(c.height) / height;
    const double right = (left + width / 2.0) / c.width - 0.5, below = (top + height / 2.0) / c.height - 0.5;
    // The plane of the picture stays where it is; the part that is kept lies beside the axis, in sizes of
    // that part.
    c.shift_x = float((c.shift_x + right) * across);
    c.shift_y = float((c.shift_y - below) * upwards);
    const double kept = c.fov_is_horizontal ? across : upwards;
    // The tangent of half the angle is proportional to the size of the picture.
    c.fov_y_rad = float(2 * std::atan(std::tan(c.fov_y_rad / 2.0) / kept));
    c.view_height = float(c.view_height / kept);
    c.width = width;
    c.height = height;
}

void set_metal(Material& m, Rgb eta, Rgb k) {
    constexpr float kLargest = 1e4f;
    const auto channel = [&](float x, float y) {
        // η = k = 0 names no metal. η = 0 with k = 1 reflects everything.
        return x > 0 || y > 0 ? std::clamp(y, 0.f, kLargest) : 1.f;
    };
    m.metal.eta = max({0, 0, 0}, min(Rgb{1, 1, 1} * kLargest, eta));
    m.metal.k = {channel(eta.x, k.x), channel(eta.y, k.y), channel(eta.z, k.z)};
    const bool perfect = max_component(m.metal.eta) == 0 && m.metal.k == Rgb{1, 1, 1};
    // Its reflectance is 1 at all angles, by Schlick's approximation too
    if (perfect && (m.kind == MaterialKind::kMirror || m.specular == Rgb{1, 1, 1})) m.metal = {};
}

// Fresnel's reflectance at normal incidence.
float dielectric_f0(float eta) { return (eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)); }

// Below 1e-3 the lobe of a microfacet model is too narrow for single precision.
float clamp_roughness(float alpha) { return std::isfinite(alpha) ? std::clamp(alpha, 1e-3f, 1.f) : 1.f; }

Rgb clamp01(Rgb c) { return max({0, 0, 0}, min({1, 1, 1}, c)); }

}  // namespace viscache::loading
