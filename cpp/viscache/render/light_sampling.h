#pragma once
// Choosing lights: emission of light paths, and points on area lights for one eye point.
#include <optional>

#include "viscache/sampling/distribution.h"
#include "viscache/sampling/rng.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/query.h"

namespace viscache {

/// Start of a light path.
struct Emission {
    Ray ray;
    Rgb flux;  ///< emitted power divided by the probability of this start, W
};

/// Chooses a light by power, then a ray it emits.
class LightSampler {
public:
    explicit LightSampler(const Scene& scene);
    bool empty() const { return choice_.size() == 0; }
    std::optional<Emission> emit(Rng& rng) const;

private:
    enum class Kind { kPoint, kDirectional, kTriangle, kSphere, kEnvironment };
    struct Entry {
        Kind kind;
        size_t index;
    };
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
};
/// Chooses by power; triangles uniformly, spheres in the cone they span. Empty when the light turns its back.
std::optional<AreaSample> sample_area_light(const Scene& scene, Vec3 from, float u_choice, Vec2 u);

}  // namespace viscache
