#pragma once
// Shadow maps: the baseline of AQVC Fig. 8. Depths traced once per light, then a plain depth test per
// query, with a constant and a slope-scaled bias and without any filter.
//
// A point light has a cube of six square maps; a depth is measured along the axis of its face. A directional
// light has one square map over the scene's bounding sphere. The bias is in depth: a constant part, and a
// multiple of what the receiver's tangent plane gains in depth over half a texel both ways. With a multiple
// of 1 a plane never shadows itself: in a cube z/(1 + e) >= z(1 − e), in a directional map the gain is
// linear.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/frame.h"
#include "viscache/math/parallel.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

struct ShadowMapSettings {
    int resolution = 1024;  ///< texels along an edge of a square map
    double bias = 1e-4;     ///< × diameter of the scene's bounding sphere
    double slope_bias = 1;  ///< × depth gained by the receiver's plane over half a texel, both ways
    bool vpls = false;      ///< maps for virtual point lights too, not only for the scene's lights
    uint64_t max_bytes = 4ull << 30;
    /// Throws std::invalid_argument saying what must hold.
    void validate() const;
};

/// Sixteen points that ask, side by side.
struct Receivers16 {
    float x[16], y[16], z[16];
    float nx[16], ny[16], nz[16];  ///< unit geometric normals; zero: no slope
};

/// What maps need to know of a scene.
struct ShadowMapExtent {
    Vec3 center;
    float radius = 1;         ///< of the bounding sphere
    float offset_extent = 1;  ///< Scene::offset_extent
};

/// The maps of a frame's shared lights. Immutable once built; the same for any number of threads.
class ShadowMaps {
public:
    /// Traces the maps of all `lights`, whose groups must differ. Throws std::invalid_argument where they
    /// would take more than settings.max_bytes, Cancelled as `control` says.
    ShadowMaps(const RayCaster& caster, const ShadowMapExtent& extent, const ShadowMapSettings& settings,
               std::span<const FarEnds* const> lights, int threads, Control& control);

    /// True if the group has maps, one per column.
    bool covers(const FarEnds& lights) const;
    /// Bit i: receiver i is lit by light k of a group that `covers` allowed.
    uint16_t lit16(const FarEnds& lights, size_t k, const Receivers16& receivers) const;

    /// Depths of a light of a group: (faces, rows, columns), infinite where nothing was hit.
    std::span<const float> depths(const FarEnds& lights, size_t k) const;
    /// Texels = rays of a group; 0 without maps.
    uint64_t rays(int group) const { return groups_[size_t(group)].depth.size(); }
    uint64_t rays() const;
    uint64_t bytes() const { return rays() * sizeof(float); }
    size_t maps() const;

private:
    struct Group {
        Semantic semantic = Semantic::kPoint;
        size_t count = 0;   ///< lights
        size_t texels = 0;  ///< of one light
        std::vector<float> depth;
    };
    void trace_rows(const RayCaster& caster, const FarEnds& lights, size_t k, size_t first, size_t last);
    Ray texel_ray(const FarEnds& lights, size_t k, size_t row, size_t column) const;
    uint16_t lit_by_point(const float* depth, Vec3 light, const Receivers16& receivers) const;
    uint16_t lit_by_direction(const float* depth, Vec3 towards, const Receivers16& receivers) const;

    ShadowMapExtent extent_;
    int resolution_;
    float bias_, slope_;
    std::array<Group, kLightGroups> groups_;
};

}  // namespace viscache
