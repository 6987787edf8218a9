#pragma once
// Environment light on the equal-area octahedral map: N × N texels of equal solid angle, constant inside.
#include <vector>

#include "viscache/math/affine.h"
#include "viscache/sampling/distribution.h"
#include "viscache/scene/description.h"

namespace viscache {

class EnvironmentMap {
public:
    struct Sample {
        Vec3 wi;
        Rgb radiance;
        float pdf;  ///< per solid angle, > 0
    };
    /// Throws SceneError for radiance that is negative or not finite.
    static EnvironmentMap constant(Rgb radiance);
    /// Resamples a lat-long image (convention in description.h), scaled to the power of its pixels.
    /// `resolution` is a power of two in [2, 4096]; 0 = texels no larger than the source's at its equator.
    /// Throws SceneError for an image without pixels, negative or non-finite colours, a `to_world` that is no
    /// rotation, or when resampling alone changes the power by more than 2 %.
    static EnvironmentMap from_latlong(const Image& image, Rgb scale, const Affine& to_world,
                                       int resolution = 0);

    /// Radiance from the unit direction wi: its texel's value, with which `sample` and `pdf` agree.
    Rgb eval(Vec3 wi) const { return is_constant() ? pixels_[0] : pixels_[texel(wi)]; }
    /// A direction by luminance; uniform over the sphere for constant and black maps.
    Sample sample(Vec2 u) const;
    /// Density of `sample` per solid angle.
    float pdf(Vec3 wi) const;
    /// Integral of luminance over the sphere.
    double total_power() const { return total_power_; }
    /// Resampled over source power before the correction: how well the resampling kept the light.
    double power_ratio() const { return power_ratio_; }
    bool is_constant() const { return resolution_ == 1; }
    int resolution() const { return resolution_; }
    /// Row-major over the octahedral square, row = second coordinate.
    const std::vector<Rgb>& pixels() const { return pixels_; }

private:
    EnvironmentMap() = default;
    size_t texel(Vec3 wi) const;
    double power() const;
    void build_tables();

    int resolution_ = 1;
    std::vector<Rgb> pixels_;
    Distribution1D rows_;                  ///< empty: sampled uniformly
    std::vector<Distribution1D> columns_;  ///< per row; empty where the row is black
    double total_power_ = 0, power_ratio_ = 1;
};

}  // namespace viscache
