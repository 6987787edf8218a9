#include "viscache/vismap/environment_pyramid.h"

#include <bit>
#include <stdexcept>
#include <string>

#include "viscache/math/morton.h"

namespace viscache {

namespace {

using Levels = std::vector<std::vector<double>>;

/// Computes the levels above the last one: every node is the sum of its four children.
void sum_up(Levels& levels) {
    for (size_t l = levels.size() - 1; l-- > 0;) {
        levels[l].resize(size_t{1} << (2 * l));
        const std::vector<double>& below = levels[l + 1];
        for (size_t z = 0; z < levels[l].size(); ++z)
            // In pairs: rounding errors of a sum grow with its depth, and 4^12 texels have only 12 levels.
            levels[l][z] = (below[4 * z] + below[4 * z + 1]) + (below[4 * z + 2] + below[4 * z + 3]);
    }
}

}  // namespace

EnvironmentPyramid::EnvironmentPyramid(const EnvironmentMap& map)
    : EnvironmentPyramid(map.pixels(), map.resolution()) {}

EnvironmentPyramid::EnvironmentPyramid(std::span<const Rgb> pixels, int resolution) {
    if (resolution < 1 || resolution > 4096 || !std::has_single_bit(unsigned(resolution)) ||
        pixels.size() != size_t(resolution) * size_t(resolution))
        throw std::invalid_argument(
            "an environment map must have N × N pixels with N a power of two in [1, 4096], got " +
            std::to_string(pixels.size()) + " pixels, N = " + std::to_string(resolution));
    // log2 of the resolution
    const int own = std::countr_zero(unsigned(resolution));
    levels_ = std::max(own, kLeastLevels);
    // Coordinates are shifted by this to repeat texels.
    const int repeat = levels_ - own;
    const size_t texels = size_t{1} << (2 * levels_), deepest = size_t{1} << (2 * kColourLevel);
    // The map is equal-area: all texels have the same solid angle.
    const double solid_angle = 4 * M_PI / double(texels);
    radiance_.resize(texels);
    sums_.resize(size_t(levels_) + 1);
    sums_.back().resize(texels);
    for (auto& channel : colour_) {
        channel.resize(kColourLevel + 1);
        channel.back().resize(deepest);
    }
    // Colours are summed from texels in groups, so that the deepest levels need no memory for three channels.
    const size_t per_node = texels / deepest;
    for (size_t node = 0; node < deepest; ++node) {
        double r = 0, g = 0, b = 0;
        for (size_t z = node * per_node; z < (node + 1) * per_node; ++z) {
            const size_t x = gather2(uint32_t(z)) >> repeat, y = gather2(uint32_t(z >> 1)) >> repeat;
            const Rgb c = radiance_[z] = pixels[y * size_t(resolution) + x];
            if (!is_finite(c) || c.x < 0 || c.y < 0 || c.z < 0)
                throw std::invalid_argument("environment radiance must be finite and >= 0, got (" +
                                            std::to_string(c.x) + ", " + std::to_string(c.y) + ", " +
                                            std::to_string(c.z) + ") in row " + std::to_string(y) +
                                            ", column " + std::to_string(x));
            sums_.back()[z] = luminance_in_double(c) * solid_angle;
            r += c.x;
            g += c.y;
            b += c.z;
        }
        colour_[0].back()[node] = r * solid_angle;
        colour_[1].back()[node] = g * solid_angle;
        colour_[2].back()[node] = b * solid_angle;
    }
    sum_up(sums_);
    for (auto& channel : colour_) sum_up(channel);
}

}  // namespace viscache
