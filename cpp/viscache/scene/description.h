#pragma once
// The mutable description of a scene, as loaders and programs fill it before it is frozen into a `Scene`.
#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "viscache/math/affine.h"
#include "viscache/scene/camera.h"
#include "viscache/scene/image.h"
#include "viscache/scene/material.h"
#include "viscache/scene/spot_cone.h"
#include "viscache/scene/vertex_color.h"

namespace viscache {

/// A scene file or array that cannot be used. The message names the file, the place and what was found.
class SceneError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

struct Mesh {
    std::string name;
    std::vector<Vec3> vertices;
    std::vector<Vec3u> triangles;
    std::vector<Vec3> normals;  ///< shading normals per vertex; empty: the geometric normal
    std::vector<Vec2> uvs;      ///< per vertex; empty: (0, 0). v grows upwards: row 0 of an image is v = 1
    std::vector<VertexColor> colors;  ///< per vertex; empty: white
    int material = 0;
    Rgb emission{};             ///< radiance of an area light; zero: not a light
    int emission_texture = -1;  ///< image that multiplies `emission`; -1: none
    bool emits_two_sided = false;
    bool in_world = true;  ///< false: visible only through instances
};

/// A group of meshes placed by one transform. Instancing has one level: a group holds no instances.
struct Instance {
    std::vector<int> meshes;
    Affine to_world;
};

struct PointLight {
    Vec3 position;
    Rgb intensity;  ///< W/sr; of a spot light: along its axis
    SpotCone cone{};
};

struct DirectionalLight {
    Vec3 direction;  ///< unit vector *towards* the light
    Rgb irradiance;  ///< W/m² on a surface that faces it
};

/// A sphere that emits light. It is sampled analytically and traced as a tessellation, whose triangles are
/// not counted.
struct SphereLight {
    Vec3 center;
    float radius = 1;
    Rgb radiance;
};

struct Environment {
    Rgb scale{1, 1, 1};  ///< constant radiance, or a factor on the image
    int image = -1;      ///< lat-long image; -1: constant radiance
    Affine to_world;  ///< rotation from the map's frame to the world. In the map's frame, direction d is at u
                      ///< = atan2(d.x, -d.z)/2π mod 1 (column, left to right) and v = acos(d.y)/π (row, top
                      ///< to bottom), as in Mitsuba 3
};

struct Warning {
    std::string where;  ///< "file:line"
    std::string text;   ///< what is not modelled, and what replaces it
};

/// A point in double precision.
using Point = std::array<double, 3>;

struct SceneDescription {
    std::string name;
    Point origin{};  ///< point of the world that lies at (0, 0, 0); all other coordinates are relative to it
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Material> materials;
    std::vector<Image> images;
    std::vector<PointLight> point_lights;
    std::vector<DirectionalLight> directional_lights;
    std::vector<SphereLight> sphere_lights;
    std::optional<Environment> environment;
    std::vector<Environment> added_environments;  ///< become one with `environment` when frozen
    std::vector<Camera> cameras;
    std::vector<Warning> warnings;
};

}  // namespace viscache
