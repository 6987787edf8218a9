#pragma once
// The texels of an octahedral map.
#include <algorithm>
#include <vector>

#include "viscache/math/vec.h"
#include "viscache/math/zeroed_array.h"

namespace viscache {

/// N × N texels of the octahedral square, black at first. They lie in tiles of 16 × 16: the tiles of a black
/// half of the sky are whole pages, which take no memory.
class OctahedralTexels {
public:
    OctahedralTexels() = default;
    explicit OctahedralTexels(int resolution)
        : resolution_(resolution),
          tiles_((size_t(resolution) + kTile - 1) / kTile),
          texels_(tiles_ * tiles_ * kTile * kTile) {}

    int resolution() const { return resolution_; }
    /// At most.
    size_t memory_bytes() const { return texels_.size() * sizeof(Rgb); }
    size_t index(size_t column, size_t row) const {
        const size_t tile = row / kTile * tiles_ + column / kTile;
        return (tile * kTile + row % kTile) * kTile + column % kTile;
    }
    Rgb& operator[](size_t index) { return texels_[index]; }
    const Rgb& operator[](size_t index) const { return texels_[index]; }
    /// Calls visit(index) for all texels, row by row.
    template <class Visit>
    void each(Visit visit) const {
        const auto n = size_t(resolution_);
        for (size_t row = 0; row < n; ++row)
            for (size_t column = 0; column < n; column += kTile)
                for (size_t i = index(column, row), end = i + std::min(kTile, n); i < end; ++i) visit(i);
    }
    /// Row by row.
    std::vector<Rgb> values() const {
        std::vector<Rgb> out;
        out.reserve(size_t(resolution_) * size_t(resolution_));
        each([&](size_t i) { out.push_back(texels_[i]); });
        return out;
    }
    /// Integral of luminance over the sphere, summed row by row.
    double power() const {
        double sum = 0;
        each([&](size_t i) { sum += luminance_in_double(texels_[i]); });
        return sum * 4 * M_PI / (double(resolution_) * double(resolution_));
    }

    static constexpr size_t kTile = 16;

private:
    int resolution_ = 0;
    size_t tiles_ = 0;
    ZeroedArray<Rgb> texels_;
};

}  // namespace viscache
