#pragma once
// Environment light on the equal-area octahedral map: N × N texels of equal solid angle, each of constant
// radiance.
#include <span>
#include <vector>

#include "viscache/math/affine.h"
#include "viscache/math/octahedral.h"
#include "viscache/sampling/distribution2d.h"
#include "viscache/scene/description.h"
#include "viscache/scene/octahedral_texels.h"

namespace viscache {

class EnvironmentMap {
public:
    struct Sample {
        Vec3 wi;
        Rgb radiance;
        float pdf;  ///< per solid angle, > 0
    };
    /// Throws SceneError if the radiance is negative or not finite.
    static EnvironmentMap constant(Rgb radiance);
    /// Resamples a lat-long image (convention in description.h) and scales the result to the power of the
    /// image. `resolution` is a power of two in [2, 4096]; 0 chooses texels no larger than the image's
    /// pixels at the equator. The map is the same for any number of threads. Throws SceneError for an image
    /// without pixels, for negative or non-finite colours, or for a `to_world` that is not a rotation. Light
    /// in the narrow pixels at the poles is kept too.
    static EnvironmentMap from_latlong(const Image& image, Rgb scale, const Affine& to_world,
                                       int resolution = 0, int threads = 0);

    /// Radiance from the unit direction wi: the value of its texel, consistent with `sample` and `pdf`.
    Rgb eval(Vec3 wi) const { return texels_[is_constant() ? 0 : texel(direction_to_equal_area(wi))]; }
    /// Samples directions in proportion to luminance, one for each point of [0, 1)²; uniformly over the
    /// sphere for constant and black maps. Takes many points at once, because the tables of a large map
    /// exceed the CPU caches.
    void sample(std::span<const Vec2> u, std::span<Sample> samples) const;
    Sample sample(Vec2 u) const {
        Sample s;
        sample({&u, 1}, {&s, 1});
        return s;
    }
    /// Density of `sample` per solid angle.
    float pdf(Vec3 wi) const { return density(eval(wi)); }
    /// Radiance from unit directions, and the density of `sample` there. Takes many directions at once, like
    /// `sample`.
    void look_up(std::span<const Vec3> wi, std::span<Sample> found) const;
    /// Integral of luminance over the sphere.
    double total_power() const { return total_power_; }
    /// Power of the resampled map before the correction, divided by the power of the image.
    double power_ratio() const { return power_ratio_; }
    bool is_constant() const { return resolution() == 1; }
    int resolution() const { return texels_.resolution(); }
    /// At most: pages of black texels may take none.
    size_t memory_bytes() const { return texels_.memory_bytes() + choice_.memory_bytes(); }
    /// Row by row of the octahedral square; the row is the second coordinate.
    std::vector<Rgb> pixels() const { return texels_.values(); }

private:
    EnvironmentMap() = default;
    size_t texel(Vec2 p) const;
    float density(const Rgb& radiance) const;

    OctahedralTexels texels_;
    Distribution2D choice_;  ///< empty: uniform sampling
    double total_power_ = 0, power_ratio_ = 1;
};

}  // namespace viscache
