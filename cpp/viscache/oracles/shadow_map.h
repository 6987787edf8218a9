#pragma once
// Shadow maps: the baseline of AQVC Fig. 8. Depths are traced once per light. A query is one depth test with
// a constant and a slope-scaled bias, without filtering.
//
// A point light has a cube of six square maps; depth is measured along the axis of the face. A directional
// light has one square map over the bounding sphere of the scene. The slope bias is a multiple of the depth
// difference of the tangent plane of the receiver over half a texel in both directions. With a multiple of 1,
// a plane never shadows itself: in a cube z/(1 + e) >= z(1 − e), and in a directional map the difference is
// linear.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/frame.h"
#include "viscache/math/parallel.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/parameter_row.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// What each is, and its range: kShadowMapRows.
struct ShadowMapSettings {
    int resolution = 1024;
    double bias = 1e-4;
    double slope_bias = 1;
    bool vpls = false;
    uint64_t max_bytes = 4ull << 30;
    /// Throws std::invalid_argument with a message that says what must hold.
    void validate() const;
};

// clang-format off
inline constexpr std::tuple kShadowMapRows{
    row("resolution", &ShadowMapSettings::resolution, {.low = 1, .high = 16384},
        "Texels along an edge of a map."),
    row("bias", &ShadowMapSettings::bias, {.low = 0, .high = 1},
        "Constant part of the bias, in diameters of the scene's bounding sphere."),
    row("slope_bias", &ShadowMapSettings::slope_bias, {.low = 0, .high = 1e6},
        "Multiple of the depth that the receiver's tangent plane gains over half a texel both ways. 1 "
        "suffices for planes; less gives acne, more lets light through near contacts."),
    row("vpls", &ShadowMapSettings::vpls,
        "Maps for virtual point lights too: six maps each. The lights are traced twice."),
    row("max_bytes", &ShadowMapSettings::max_bytes, {.low = 1},
        "Refuse maps that would take more: 4 bytes per texel, 24·resolution² per point light."),
};
// clang-format on

inline void ShadowMapSettings::validate() const { check_rows(kShadowMapRows, *this); }

/// Sixteen receivers as arrays.
struct Receivers16 {
    float x[16], y[16], z[16];
    float nx[16], ny[16], nz[16];  ///< unit geometric normals; zero for no slope bias
};

/// Data of a scene for its maps.
struct ShadowMapExtent {
    Vec3 center;
    float radius = 1;  ///< radius of the bounding sphere
};

/// The maps of the shared lights of a frame. Immutable after construction, and the same for any number of
/// threads.
class ShadowMaps {
public:
    /// Traces the maps of all `lights`, whose groups must differ. Throws std::invalid_argument if they need
    /// more than settings.max_bytes, and Cancelled if `control` requests it.
    ShadowMaps(const RayCaster& caster, const ShadowMapExtent& extent, const ShadowMapSettings& settings,
               std::span<const FarEnds* const> lights, int threads, Control& control);

    /// True if the group has maps, one per column.
    bool covers(const FarEnds& lights) const;
    /// Bit i is 1 if light k illuminates receiver i. `covers` must be true for the group.
    uint16_t lit16(const FarEnds& lights, size_t k, const Receivers16& receivers) const;

    /// Depths of a light: (faces, rows, columns), infinite without a hit.
    std::span<const float> depths(const FarEnds& lights, size_t k) const;
    /// Number of texels, and so of rays, of a group; 0 without maps.
    uint64_t rays(int group) const { return groups_[size_t(group)].depth.size(); }
    uint64_t rays() const;
    uint64_t bytes() const { return rays() * sizeof(float); }
    size_t maps() const;

private:
    struct Group {
        Semantic semantic = Semantic::kPoint;
        size_t count = 0;   ///< number of lights
        size_t texels = 0;  ///< texels per light
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
