#pragma once
// Code shared by the scene loaders: file positions, limits, checked meshes. Internal to the loaders.
#include <array>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "viscache/math/affine.h"
#include "viscache/scene/description.h"

namespace viscache::loading {

constexpr uint64_t kMaxFileBytes = uint64_t(8) << 30;
constexpr int kMaxDepth = 64;                             ///< maximum nesting of elements, includes and nodes
constexpr double kDegree = 3.14159265358979323846 / 180;  ///< in radians

/// Throws SceneError with the message "where: what".
[[noreturn]] void fail(const std::string& where, const std::string& what);

/// `text` with control characters and invalid UTF-8 replaced by '?', because names in files may contain any
/// bytes.
std::string printable(std::string text);

/// "file:line".
std::string at_line(const std::string& file, size_t line);

/// Throws SceneError if the scene may not read the file (allowed_files.h).
void check_allowed(const std::string& path, const std::string& where);
/// Size of a file. Throws SceneError if it is missing, empty, too large or not allowed (allowed_files.h).
uint64_t check_file(const std::string& path, const std::string& asked_at = "");
/// Content of a file. Throws SceneError as `check_file` does, and if it is unreadable.
std::string read_file(const std::string& path, const std::string& asked_at = "");

/// Path of `name` relative to the folder of `base_file`.
std::string resolve(const std::string& base_file, const std::string& name);

std::string lower(std::string_view text);
std::string extension_of(const std::string& path);  ///< lower case, with the dot

/// The number that `token` spells; empty unless the whole token is a number. Accepts a leading '+'.
std::optional<double> parse_number(std::string_view token);
std::optional<int64_t> parse_integer(std::string_view token);

/// 1-based line numbers of byte offsets in a text.
class LineIndex {
public:
    explicit LineIndex(std::string_view text);
    size_t line(size_t offset) const;

private:
    std::vector<size_t> starts_;
};

/// How pixels of an image are found.
struct LookUp {
    bool nearest = false;
    Wrap u = Wrap::kRepeat, v = Wrap::kRepeat;

    auto operator<=>(const LookUp&) const = default;
};
void set_look_up(Image& image, LookUp look_up);
/// "repeat", "mirror" or "clamp".
std::optional<Wrap> wrap_named(std::string_view name);

/// The scene under construction, with the rules that apply to every format.
class Loading {
public:
    Loading(SceneDescription& scene, bool strict, bool skip_missing)
        : scene(scene), strict(strict), skip_missing(skip_missing) {}

    SceneDescription& scene;
    const bool strict, skip_missing;
    Point origin{};  ///< what the caller wants as origin; a loader may place everything relative to it

    /// Reports something that makes the picture wrong; an error when strict.
    void warn(const std::string& where, const std::string& text);
    /// Reports something that leaves the picture right.
    void note(const std::string& where, const std::string& text);
    /// Texts that were reported at several places say so: how often, and the second and third place.
    void count_warnings();
    int add_material(const Material& material);
    /// False if the mesh file `path` is not there and may be left out, which is reported. Otherwise a missing
    /// file is an error.
    bool has_mesh_file(const std::string& path, const std::string& where);
    /// Index of the image `path`; adds the image if it is new.
    int add_image(const std::string& path, const std::string& where, bool srgb, LookUp look_up = {});
    /// Index of a checkerboard of two squares by two, one unit of texture coordinates wide. The square at
    /// (0, 0) has the colour `first`.
    int add_checkerboard(Rgb first, Rgb second, const std::string& where);
    /// Checks and adds a mesh. Error messages start with `where`.
    int add_mesh(Mesh mesh, const std::string& where);
    /// For formats with one environment: a second one is skipped, which is reported.
    void set_environment(const Environment& environment, const std::string& where);
    /// For formats whose infinite lights add up.
    void add_environment(Environment environment, const std::string& where);

private:
    /// How often a text was reported, and where after the first time.
    struct Said {
        size_t index;  ///< in the scene's warnings
        size_t times = 1;
        std::vector<std::string> also;
    };
    std::map<std::string, Said> said_;
    std::map<std::tuple<std::string, bool, LookUp>, int> images_;
    std::map<std::array<float, 6>, int> checkerboards_;
};

/// Affine map of texture coordinates. v grows upwards, as in meshes.
struct UvTransform {
    double m[2][3] = {{1, 0, 0}, {0, 1, 0}};

    bool operator==(const UvTransform&) const = default;
    /// The same map for coordinates whose v grows downwards.
    UvTransform downwards() const {
        return {{{m[0][0], -m[0][1], m[0][1] + m[0][2]}, {-m[1][0], m[1][1], 1 - m[1][1] - m[1][2]}}};
    }
    bool is_identity() const { return *this == UvTransform{}; }
    Vec2 operator()(Vec2 uv) const {
        return {float(m[0][0] * uv.x + m[0][1] * uv.y + m[0][2]),
                float(m[1][0] * uv.x + m[1][1] * uv.y + m[1][2])};
    }
};

/// The transform of texture coordinates that the images of one material share. A mesh has one set of
/// coordinates, to which the loaders apply it.
class MaterialUv {
public:
    /// Notes the transform of one more image. False if it differs from that of the images before.
    bool add(const UvTransform& t) {
        if (!found_) found_ = t;
        return *found_ == t;
    }
    UvTransform get() const { return found_.value_or(UvTransform{}); }

private:
    std::optional<UvTransform> found_;
};

void transform_uvs(Mesh& mesh, const UvTransform& t);
using CornerUvs = std::array<Vec2, 3>;
/// Gives the triangles of a mesh without texture coordinates these, in turn.
void add_triangle_uvs(Mesh& mesh, std::initializer_list<CornerUvs> turns);
/// Whether shapes of this material need texture coordinates.
bool uses_image(const Material& material);

/// Colours that a file gives to the vertices or the faces of a mesh; each may be empty.
struct FileColors {
    std::vector<VertexColor> vertices, faces;  ///< the latter: one per triangle
    bool clamped = false;                      ///< some were outside of [0, 1]
};
constexpr const char* kClampedColors = "colours must be in [0, 1]; they are clamped";
/// Whether a colour is outside of [0, 1], by more than rounding.
bool is_clamped(Rgb color);
/// The material of meshes with colours where a file names none: they are the base colour, and alpha is a
/// share.
Material colored_material();

/// Refuses non-finite or huge vertices, indices out of range, attribute counts that do not match, and meshes
/// without triangles.
void check_mesh(const Mesh& mesh, const std::string& where);

/// Applies a transform to vertices and normals.
void transform_mesh(Mesh& mesh, const Affine& t);
void flip_winding(Mesh& mesh);
void flip_normals(Mesh& mesh);
/// Turns triangles whose winding disagrees with their normals. The indices must be valid.
void wind_by_normals(Mesh& mesh);
/// Appends `b` to `a`. Normals and uvs are dropped unless both have them.
void append_mesh(Mesh& a, const Mesh& b);

/// Triangulates a simple polygon: convex ones as a fan from corner 0, others by ear clipping.
void triangulate(const std::vector<Vec3>& polygon, std::vector<Vec3u>& triangles);

/// The inverse; empty if `t` is singular or not finite.
std::optional<Affine> inverse_of(const Affine& t);
Affine translation(double x, double y, double z);
Affine scaling(double x, double y, double z);
/// `unit_axis` false: the axis counts with its length, by which the result scales, as in Mitsuba 3.
Affine rotation(double degrees, double x, double y, double z, bool unit_axis = true);
bool is_finite(const Affine& t);

/// Radius factor of a transform that maps spheres to spheres (rotation, reflection, uniform scale);
/// otherwise empty.
std::optional<double> uniform_scale(const Affine& t);

Mesh rectangle_mesh();  ///< [-1, 1]² at z = 0, facing +z
/// Gives a mesh the normals that Mitsuba computes: those of the triangles, weighted by their angles at a
/// vertex.
void smooth_normals(Mesh& mesh);
Mesh cube_mesh();  ///< [-1, 1]³, 12 triangles facing out
Mesh sphere_mesh(Vec3 center, float radius);
Mesh disk_mesh();  ///< unit disk at z = 0, facing +z; a polygon of the disk's area
/// The same with texture coordinates: the radius, and the angle in turns.
Mesh polar_disk_mesh();

/// A point of a profile in the half plane (r, z), with the tangent of the profile.
struct ProfilePoint {
    double r, z, dr, dz;
};
/// The surface that a profile sweeps around the z axis, with shading normals. Its front is on the right of
/// the profile: an upward line faces outwards. u grows with the angle, v along the profile. The polygon
/// around the axis has the circumference of the circle.
Mesh revolved_mesh(const std::vector<ProfilePoint>& profile, double phi_max_rad = 6.283185307179586);

/// Makes the picture of a camera the part of its film that begins at the pixel (left, top).
void crop_camera(Camera& camera, int left, int top, int width, int height);

/// Describes a mirror or a glossy material without a base by an index of refraction. A channel without one is
/// a perfect mirror.
void set_metal(Material& m, Rgb eta, Rgb k);
/// Reflectance at normal incidence of a dielectric.
float dielectric_f0(float eta);
float clamp_roughness(float alpha);
Rgb clamp01(Rgb c);

// Mesh files. `asked_at` is the place that names the file; the error for a missing file reports it.
// `asked_at` is empty for a file that is a scene.
Mesh read_ply(const std::string& path, Loading& loading, const std::string& asked_at = "",
              FileColors* colors = nullptr);
/// Returns one mesh per material, and adds the materials of the MTL files; without materials, one mesh, which
/// has no colours.
std::vector<Mesh> read_obj(const std::string& path, Loading& loading, bool with_materials,
                           const std::string& asked_at = "");
/// Shape `index` of the Mitsuba .serialized file with the content `bytes`. Sets `has_colors` if it has some.
Mesh read_serialized(const std::string& path, std::string_view bytes, size_t index,
                     bool* has_colors = nullptr);
size_t serialized_count(const std::string& path, std::string_view bytes);

// Scene files.
void load_obj(const std::string& path, Loading& loading);
void load_ply(const std::string& path, Loading& loading);
void load_serialized(const std::string& path, Loading& loading);
void load_mitsuba(const std::string& path, Loading& loading);
void load_pbrt(const std::string& path, Loading& loading);
void load_gltf(const std::string& path, Loading& loading);

}  // namespace viscache::loading
