#pragma once
// Quadtrees of sums of the environment light over the equal-area map, along the Morton curve.
#include <array>
#include <span>
#include <vector>

#include "viscache/scene/envmap.h"

namespace viscache {

/// Sums of λ = luminance × solid angle, in double, so that a sky stays accurate next to a sun of 10⁶. Level
/// l has 4^l nodes; level 0 is the root; the children of node z are nodes 4z … 4z + 3 of the next level. The
/// nodes of level `levels()` are texels. Maps of less than 128 × 128 texels are upsampled to that size by
/// repetition.
class EnvironmentPyramid {
public:
    static constexpr int kLeastLevels = 7;
    static constexpr int kColourLevel = 7;  ///< deepest level with sums per channel

    explicit EnvironmentPyramid(const EnvironmentMap& map);
    /// resolution × resolution pixels, row by row; the resolution is a power of two in [1, 4096].
    EnvironmentPyramid(std::span<const Rgb> pixels, int resolution);

    int levels() const { return levels_; }
    const double* sums(int level) const { return sums_[size_t(level)].data(); }
    /// Sums of one channel × solid angle, for levels up to kColourLevel.
    const double* colour_sums(int channel, int level) const {
        return colour_[size_t(channel)][size_t(level)].data();
    }
    /// Radiance of a texel, by its Morton code.
    Rgb radiance(uint32_t texel) const { return radiance_[texel]; }
    double total() const { return sums_[0][0]; }

private:
    int levels_;
    std::vector<Rgb> radiance_;
    std::vector<std::vector<double>> sums_;
    std::array<std::vector<std::vector<double>>, 3> colour_;
};

}  // namespace viscache
