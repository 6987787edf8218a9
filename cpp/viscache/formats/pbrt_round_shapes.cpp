// pbrt text: spheres, disks, cylinders, cones and paraboloids.
#include "viscache/formats/pbrt_reader.h"

namespace viscache::loading {

namespace {

constexpr int kArcs = 24;  ///< pieces of a curved profile

double positive(const PbrtParams& params, const char* name, const std::string& type,
                const std::string& where) {
    const double x = params.number(name, 1);
    if (!(x > 0)) fail(where, std::string("the ") + name + " of a " + type + " must be > 0");
    return x;
}

/// Both bounds of the height in their order.
std::pair<double, double> heights(const PbrtParams& params, double low, double high) {
    return std::minmax({params.number("zmin", low), params.number("zmax", high)});
}

std::vector<ProfilePoint> sphere_profile(double radius, const PbrtParams& params) {
    const auto [low, high] = heights(params, -radius, radius);
    const double from = std::acos(std::clamp(low / radius, -1.0, 1.0)),
                 to = std::acos(std::clamp(high / radius, -1.0, 1.0));
    std::vector<ProfilePoint> arc;
    for (int i = 0; i <= kArcs; ++i) {
        const double theta = from + (to - from) * i / kArcs, s = std::sin(theta), c = std::cos(theta);
        arc.push_back({radius * s, radius * c, -c, s});
    }
    return arc;
}

std::vector<ProfilePoint> paraboloid_profile(double radius, const PbrtParams& params,
                                             const std::string& where) {
    auto [low, high] = heights(params, 0, 1);
    low = std::max(0.0, low);
    if (!(high > low)) fail(where, "zmax of a paraboloid must exceed its zmin");
    const double inner = std::sqrt(low / high);
    std::vector<ProfilePoint> arc;
    for (int i = 0; i <= kArcs; ++i) {
        const double t = inner + (1 - inner) * i / kArcs;
        arc.push_back({radius * t, high * t * t, radius, 2 * high * t});
    }
    return arc;
}

Mesh disk(double radius, double phi_max, const PbrtParams& params) {
    const double height = params.number("height", 0), inner = params.number("innerradius", 0);
    if (inner > 0 || params.number("phimax", 360) < 360)
        return revolved_mesh({{radius, height, -1, 0}, {inner, height, -1, 0}}, phi_max);
    Mesh mesh = disk_mesh();
    for (Vec3& p : mesh.vertices) p = {p.x * float(radius), p.y * float(radius), float(height)};
    return mesh;
}

}  // namespace

bool is_whole_sphere(const PbrtParams& params) {
    const double radius = params.number("radius", 1);
    return params.number("zmin", -radius) <= -radius && params.number("zmax", radius) >= radius &&
           params.number("phimax", 360) >= 360;
}

Mesh textured_disk(const PbrtParams& params) {
    const auto radius = float(params.number("radius", 1)), height = float(params.number("height", 0));
    Mesh mesh = polar_disk_mesh();
    for (Vec3& p : mesh.vertices) p = {p.x * radius, p.y * radius, height};
    for (Vec2& uv : mesh.uvs) uv = {uv.y, 1 - uv.x};
    return mesh;
}

/// A surface of revolution; empty if the type is none.
std::optional<Mesh> round_shape(const std::string& type, const PbrtParams& params, const std::string& where) {
    if (type != "sphere" && type != "disk" && type != "cylinder" && type != "cone" && type != "paraboloid")
        return {};
    const double radius = positive(params, "radius", type, where);
    const double phi_max = std::min(params.number("phimax", 360), 360.0) * kDegree;
    if (!(phi_max > 0)) fail(where, "'phimax' must be > 0");
    if (type == "sphere" && is_whole_sphere(params)) return sphere_mesh({0, 0, 0}, float(radius));
    if (type == "sphere") return revolved_mesh(sphere_profile(radius, params), phi_max);
    if (type == "disk") return disk(radius, phi_max, params);
    if (type == "paraboloid") return revolved_mesh(paraboloid_profile(radius, params, where), phi_max);
    if (type == "cone") {
        const double height = positive(params, "height", type, where);
        return revolved_mesh({{radius, 0, -radius, height}, {0, height, -radius, height}}, phi_max);
    }
    const auto [low, high] = heights(params, -1, 1);
    return revolved_mesh({{radius, low, 0, 1}, {radius, high, 0, 1}}, phi_max);
}

}  // namespace viscache::loading
