#pragma once
// Sampling of lights: starts of light paths, and points on area lights for one eye point.
#include <optional>

#include "viscache/sampling/distribution.h"
#include "viscache/sampling/rng.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/query.h"

namespace viscache {

class LightsAt;
struct LightPick;

enum class LightKind { kPoint, kDirectional, kTriangle, kSphere, kEnvironment };

/// Whether the light comes from infinity, as parallel rays.
inline bool is_infinite(LightKind k) { return k == LightKind::kDirectional || k == LightKind::kEnvironment; }

/// Start of a light path.
struct Emission {
    Ray ray;
    Rgb flux;  ///< emitted power divided by the probability of this start, W
    LightKind kind = LightKind::kPoint;
    Vec3 point{};            ///< point on the light; origin of the ray for light from infinity
    Vec3 normal{};           ///< for area lights, on the side of the ray; otherwise zero
    float extent = 0;        ///< of the light's surface (scene/surface_extent.h)
    bool two_sided = false;  ///< an area light that shines from both sides
    bool has_holes = false;  ///< a triangle that rays may pass
    Rgb radiance{};          ///< emitted radiance, intensity (point) or irradiance (directional)
    SpotCone cone{};         ///< for point lights
    double pdf_point = 1;  ///< density of the point per m², or of the direction per sr (environment), choice
                           ///< of the light included
    double pdf_ray = 1;    ///< conditional density of the ray: per sr, or per m² across parallel rays
};

/// Chooses a light by power, then one of its rays.
class LightSampler {
public:
    explicit LightSampler(const Scene& scene);
    bool empty() const { return choice_.size() == 0; }
    std::optional<Emission> emit(Rng& rng) const;

    /// `Emission::pdf_point` of a point on a triangle with this mean radiance.
    double pdf_point(Rgb radiance, bool two_sided) const;
    /// `Emission::pdf_point` of the environment in the direction wi.
    double pdf_environment(Vec3 wi) const;
    /// `Emission::pdf_ray` of light from infinity.
    double pdf_parallel() const;

private:
    struct Entry {
        LightKind kind;
        size_t index;
    };
    float disk_radius() const { return scene_.radius() * 1.001f; }
    Emission emit_from(const Entry& entry, Rng& rng) const;
    Emission emit_through_scene(Vec3 towards_light, Rgb irradiance, Rng& rng) const;

    const Scene& scene_;
    std::vector<Entry> entries_;
    Distribution1D choice_;
};

/// A point on an area light, as seen from one eye point.
struct AreaSample {
    Vec3 point, normal;
    Vec3 ray_end;  ///< offset from the surface of the light
    Rgb radiance;
    float pdf_area;  ///< density per m², choice of the light included
    float pdf_even;  ///< the same for a choice by power and even sampling of the side of a light that a point
                     ///< can see; independent of the eye point
    size_t light;    ///< over triangles, then spheres
};
/// A point on a chosen light: triangles are sampled uniformly, spheres in the cone they span. Empty if the
/// light faces away.
std::optional<AreaSample> sample_area_light(const LightsAt& at, const LightPick& pick, Vec2 u);

/// A point on a light that was found in another way. `normal`: of the light, on the side of the eye point,
/// which is outside of spheres; `weights`: barycentric weights of a triangle's vertices b and c.
AreaSample area_sample_at(const LightsAt& at, size_t light, Vec3 point, Vec3 normal, Vec2 weights);

}  // namespace viscache
