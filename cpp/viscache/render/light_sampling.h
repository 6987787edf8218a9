#pragma once
// Choosing lights: emission of light paths, and points on area lights for one eye point.
#include <optional>

#include "viscache/sampling/distribution.h"
#include "viscache/sampling/rng.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/query.h"

namespace viscache {

enum class LightKind { kPoint, kDirectional, kTriangle, kSphere, kEnvironment };

/// Light from infinity: parallel rays.
inline bool is_infinite(LightKind k) { return k == LightKind::kDirectional || k == LightKind::kEnvironment; }

/// Start of a light path.
struct Emission {
    Ray ray;
    Rgb flux;  ///< emitted power divided by the probability of this start, W
    LightKind kind = LightKind::kPoint;
    Vec3 point{};            ///< on the light; where the ray starts, for light from infinity
    Vec3 normal{};           ///< of an area light on the side of the ray; else zero
    bool two_sided = false;  ///< an area light that shines from both sides
    Rgb radiance{};          ///< what leaves: radiance, intensity (point) or irradiance (directional)
    double pdf_point = 1;  ///< of the point per m², or of the direction of the environment per sr; the choice
                           ///< of the light included
    double pdf_ray = 1;    ///< of the ray, given that: per sr, or per m² across the rays from infinity
};

/// Chooses a light by power, then a ray it emits.
class LightSampler {
public:
    explicit LightSampler(const Scene& scene);
    bool empty() const { return choice_.size() == 0; }
    std::optional<Emission> emit(Rng& rng) const;

    /// `Emission::pdf_point` of a point that shines with this radiance.
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
    Vec3 ray_end;  ///< spawned off the light's own surface
    Rgb radiance;
    float pdf_area;  ///< probability density per m² of light, light choice included
    float pdf_even;  ///< the same, were all of a light that a point can see sampled evenly: of no eye point
};
/// Chooses by power; triangles uniformly, spheres in the cone they span. Empty when the light turns its back.
std::optional<AreaSample> sample_area_light(const Scene& scene, Vec3 from, float u_choice, Vec2 u);

}  // namespace viscache
