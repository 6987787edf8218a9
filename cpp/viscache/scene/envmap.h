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
        float pdf;  ///< per solid angle
    };
    static EnvironmentMap constant(Rgb radiance);
    /// Resamples a lat-long image (convention in description.h). `resolution` 0: texels of the source's solid angle.
    /// Throws SceneError for negative or non-finite pixels, an image that is all black, or when the
    /// resampled power is off by more than 2 %.
    static EnvironmentMap from_latlong(const Image& image, Rgb scale, const Affine& to_world, int resolution = 0);

    Rgb eval(Vec3 wi) const { return is_constant() ? pixels_[0] : pixels_[texel(wi)]; }
    Sample sample(Vec2 u) const;
    float pdf(Vec3 wi) const;
    /// Integral of luminance over the sphere.
    double total_power() const { return total_power_; }
    /// Resampled over source power before the correction: how well the resampling kept the light.
    double power_ratio() const { return power_ratio_; }
    bool is_constant() const { return resolution_ == 1; }
    int resolution() const { return resolution_; }
    const std::vector<Rgb>& pixels() const { return pixels_; }

private:
    size_t texel(Vec3 wi) const;
    void build_tables();

    int resolution_ = 1;
    std::vector<Rgb> pixels_;
    Distribution1D choice_;
    double total_power_ = 0, power_ratio_ = 1;
};

}  // namespace viscache
