#pragma once
// Bins of normals. Surfaces in one bin share a grid, whose axes depend only on the bin (AQVC Sec. 3.3).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "viscache/aqvc/parameters.h"
#include "viscache/math/octahedral.h"

namespace viscache {

/// floor for |v| < 2^62 without a library call; larger values become ±2^62.
inline int64_t floor_to_int(double v) {
    // Out of range and NaN first: their conversion is undefined.
    if (!(v > -0x1p62)) return -(int64_t{1} << 62);
    if (v > 0x1p62) return int64_t{1} << 62;
    const int64_t i = int64_t(v);
    // Conversion truncates towards 0, which is one too high for negative fractions.
    return i - (double(i) > v);
}

struct GridAxes {
    std::array<double, 3> x, y, z;
};

class NormalBins {
public:
    NormalBins(NormalMode mode, int c_n) : mode_(mode), steps_(c_n) {
        if (mode == NormalMode::kOctahedral) steps_ = octahedral_steps(c_n);
        if (mode == NormalMode::kSingle) steps_ = 0;
        make_axes();
    }
    /// Bin of a finite, nonzero normal of any length.
    int32_t of(Vec3 n) const;
    const GridAxes& axes(int32_t bin) const { return axes_[size_t(bin)]; }
    /// The bin as slots of a key.
    std::array<int32_t, 3> slots(int32_t bin) const {
        const int32_t side = steps_ + 1;
        return {bin / (side * side), bin / side % side, bin % side};
    }
    /// Steps along an edge of the octahedral square for about as many bins as rounding uses, 6π(C_N/2)².
    /// Even, so that all coordinate axes are bins.
    static int octahedral_steps(int c_n) { return 2 * int(std::floor(1.085 * c_n + 0.5)); }

private:
    void make_axes();
    static GridAxes axes_around(double x, double y, double z);
    NormalMode mode_;
    int32_t steps_;  ///< along an axis, or along an edge of the octahedral square
    std::vector<GridAxes> axes_;
};

/// [AQVC Eq. 4] ω_q = ⌊(N + 1)/2·C_N⌋: the bin of the normal. The axis of the bin is d_z = 2 ω_q/C_N − 1.
// Differs (A5): the default rounds. Floor gives the corner of the bin, up to 25° off the normal (C_N = 8),
// and noise in the normals splits axis-aligned walls. Octahedral: nearest point of a square lattice on the
// octahedral map; lattice points on its edges occur twice and are merged. Single: one bin with the grid of
// the world axes.
inline int32_t NormalBins::of(Vec3 n) const {
    if (mode_ == NormalMode::kSingle) return 0;
    if (mode_ == NormalMode::kOctahedral) {
        const auto [u, v] = octahedral_square<double>(n);
        int32_t i = int32_t(floor_to_int(u * steps_ + 0.5)), j = int32_t(floor_to_int(v * steps_ + 0.5));
        // Edges of the octahedral square: the lower pole is at all four corners, and both halves of an edge
        // are the same directions, folded at the edge's middle. The smaller index stands for both:
        //
        //     (0, 0) ... (0, j) ... middle ... (0, n − j) ... (0, n)
        //                  ^------- same -------^
        if (i == 0 || i == steps_) j = std::min(j, steps_ - j);
        if (j == 0 || j == steps_) i = std::min(i, steps_ - i);
        return i * (steps_ + 1) + j;
    }
    const double shift = mode_ == NormalMode::kRound ? 0.5 : 0;
    const auto step = [&](float v) {
        const int64_t at = floor_to_int((double(v) + 1) / 2 * steps_ + shift);
        // N = +1 would be a bin of its own beyond the last one (floor), or rounding may exceed the range.
        return int32_t(std::clamp<int64_t>(at, 0, steps_));
    };
    return (step(n.x) * (steps_ + 1) + step(n.y)) * (steps_ + 1) + step(n.z);
}

inline GridAxes NormalBins::axes_around(double x, double y, double z) {
    // The corner of a bin may be the zero vector if C_N is even and N is floored (A5); any axes will do.
    const double l = std::sqrt(x * x + y * y + z * z);
    if (l > 0) {
        x /= l;
        y /= l;
        z /= l;
    } else {
        x = 0;
        y = 0;
        z = 1;
    }
    // Orthonormal basis without branches [Duff et al. 2017]. From the bin, never from N: all normals of a bin
    // must have the same grid.
    const double s = std::copysign(1.0, z), a = -1 / (s + z), b = x * y * a;
    return {{1 + s * x * x * a, s * b, -s * x}, {b, s + y * y * a, -y}, {x, y, z}};
}

/// Computes the grid axes of every bin from the integers of the bin.
inline void NormalBins::make_axes() {
    const int n = steps_;
    if (mode_ == NormalMode::kSingle) {
        axes_ = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
        return;
    }
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) {
            double x = 2.0 * i / n - 1, y = 2.0 * j / n - 1;
            if (mode_ == NormalMode::kOctahedral) {
                const double z = 1 - std::fabs(x) - std::fabs(y);
                // The lower half is folded outwards.
                if (z < 0) {
                    const double fold = (1 - std::fabs(y)) * sign_not_zero(x);
                    y = (1 - std::fabs(x)) * sign_not_zero(y);
                    x = fold;
                }
                axes_.push_back(axes_around(x, y, z));
                continue;
            }
            for (int k = 0; k <= n; ++k) axes_.push_back(axes_around(x, y, 2.0 * k / n - 1));
        }
}

}  // namespace viscache
