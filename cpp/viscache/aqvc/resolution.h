#pragma once
// How fine the grids are (AQVC Sec. 3.2, 3.4, 3.5).
//
// Densities: D_e = N_S·P(p_e) eye samples per unit area, D_l = M·P(p_l) light samples per unit area (or per
// steradian) with M = N_P / N_S. Cell widths are then C_E/√D_e and 1/√D_l: the footprint of the samples.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "viscache/aqvc/parameters.h"

namespace viscache {

/// [AQVC Eq. 2] Expected number of paths that share two patches.
inline double expected_paths(double n_paths, double p_eye, double area_eye, double p_light,
                             double area_light) {
    return n_paths * p_eye * area_eye * p_light * area_light;
}

/// [AQVC Eq. 3] The product of the two patch areas that gives C_E² paths per cluster on average.
inline double patch_area_product(double p_eye, double p_light, double n_paths, double c_e) {
    return c_e / p_eye * (c_e / p_light) / n_paths;
}

/// [AQVC Eq. 5] Area of the patch of one cell when R cells span the bounding sphere of radius B_R.
inline double patch_area(double resolution, double radius) {
    const double width = 2 * radius / resolution;
    return width * width;
}

/// [AQVC Eq. 6] One resolution for both ends, smallest patches: R = 2 B_R (P_e P_l N_P / C_E²)^(1/4).
// Differs: the exponent is printed as −4. Eq. 3 and 5 give (2 B_R / R)⁴ = C_E² / (P_e P_l N_P), a fourth
// root. P_e P_l N_P = D_e·D_l; roots come before products, so that densities of 1e±30 stay in range.
inline double resolution_pair(double density_eye, double density_light, double c_e, double radius) {
    return 2 * radius * std::sqrt(std::sqrt(density_eye) * std::sqrt(density_light)) / std::sqrt(c_e);
}

/// [AQVC Eq. 7] Clusters of C_E × C_E eye samples on screen: R_e = 2 B_R √(P_e N_S) / C_E, R_l = 2 B_R √(P_l
/// M).
inline double resolution_eye(double density_eye, double c_e, double radius) {
    return 2 * radius * std::sqrt(density_eye) / c_e;
}
inline double resolution_light(double density_light, double radius) {
    return 2 * radius * std::sqrt(density_light);
}

/// [AQVC Eq. 9] Cells across the octahedral map of directions, one light sample per cell: R(ω) = √(4π P(ω)
/// M).
// Differs: printed as √(P(ω) M / 4π). A cell covers 4π/R² and must be 1/(P(ω) M) large, so 4π multiplies: for
// the uniform density 1/4π and M = 256 this gives 16 × 16 cells, the printed form one cell for the whole sky.
inline double resolution_environment(double density, EnvironmentRule rule) {
    constexpr double kFourPi = 12.566370614359172954;
    return rule == EnvironmentRule::kDerived ? std::sqrt(kFourPi * density) : std::sqrt(density / kFourPi);
}

/// How often a resolution had to be brought into range.
struct ClampCounts {
    uint64_t low = 0, high = 0, nan = 0;
};

/// A resolution on the ladder.
struct Rung {
    double resolution = 1;  ///< cells across, an integer; scale-free: cells per unit of length
    int32_t slot = 1;  ///< what stands in the key: R, or −k for the folded rungs beyond R_max; scale-free: k
    bool folded = false;  ///< R > R_max: coordinates do not fit 32 bits and are mixed down
};

/// [AQVC Eq. 8] R ← ⌊C_R^⌊log_{C_R} R + 0.5⌋⌋ as a table of thresholds C_R^(k − ½): no pow or log per query
/// and the same integers on every machine.
// Differs: R < 1 becomes 1 (the printed form gives 0 below C_R^(−½)); not-a-number and infinite R become the
// finest 32-bit rung, all of them counted. Scale-free: C_R^k itself, of any whole k, and k is the slot.
class Ladder {
public:
    Ladder(double c_r, double c_z, bool scale_free = false)
        : scale_free_(scale_free), r_max_(std::floor(0x1p30 / std::max(1.0, c_z))) {
        if (scale_free) {
            make_scale_free(c_r);
            return;
        }
        const double half = std::sqrt(c_r), end = 0x1p50 / std::max(1.0, c_z);
        for (double power = 1; power <= end; power *= c_r) {
            thresholds_.push_back(power / half);
            const double r = std::floor(power);
            const bool folded = r > r_max_;
            if (!folded) finest_ = rungs_.size();
            rungs_.push_back({r, folded ? -int32_t(rungs_.size()) : int32_t(r), folded});
        }
        // First rung of every power of two, so that the search starts close.
        for (int e = 0; e <= 64; ++e) first_.push_back(index_from(0, thresholds_.size(), std::ldexp(1.0, e)));
    }
    double r_max() const { return r_max_; }
    size_t size() const { return rungs_.size(); }
    bool scale_free() const { return scale_free_; }
    const Rung& operator[](size_t k) const { return rungs_[k]; }

    const Rung& rung(double r, ClampCounts& clamps) const {
        if (scale_free_) return scale_free_rung(r, clamps);
        if (!(r >= 1)) {
            if (r < 1) return ++clamps.low, rungs_.front();
            return ++clamps.nan, rungs_[finest_];
        }
        if (r > r_max_) {
            ++clamps.high;
            if (!std::isfinite(r)) return rungs_[finest_];
            if (r >= 0x1p63) return rungs_.back();
        }
        const size_t e = size_t(63 - __builtin_clzll(uint64_t(r)));
        return rungs_[index_from(first_[e], std::min(first_[e + 1] + 1, thresholds_.size()), r)];
    }

    /// The same, tried first at `hint`, which becomes the rung's index.
    const Rung& rung_near(double r, size_t& hint, ClampCounts& clamps) const {
        if (hint + 1 < thresholds_.size() && (scale_free_ || r >= 1) && r <= r_max_ &&
            thresholds_[hint] <= r && r < thresholds_[hint + 1])
            return rungs_[hint];
        const Rung& found = rung(r, clamps);
        hint = size_t(&found - rungs_.data());
        return found;
    }

private:
    static constexpr double kLargest = 0x1p60;  ///< of scale-free resolutions, and over 1 the smallest

    /// Last k in [lo, hi) with thresholds[k] <= r; thresholds[lo] <= r holds.
    size_t index_from(size_t lo, size_t hi, double r) const {
        return size_t(std::upper_bound(thresholds_.begin() + std::ptrdiff_t(lo),
                                       thresholds_.begin() + std::ptrdiff_t(hi), r) -
                      thresholds_.begin()) -
               1;
    }
    void make_scale_free(double c_r) {
        // From 1 by quotients down and by products up: no rung depends on where the table ends
        std::vector<double> below;
        for (double power = 1 / c_r; power >= 1 / kLargest; power /= c_r) below.push_back(power);
        for (size_t k = below.size(); k > 0; --k) rungs_.push_back({below[k - 1], -int32_t(k), false});
        int32_t k = 0;
        for (double power = 1; power <= kLargest; power *= c_r) rungs_.push_back({power, k++, false});
        for (const Rung& r : rungs_) thresholds_.push_back(r.resolution / std::sqrt(c_r));
        finest_ = rungs_.size() - 1, r_max_ = rungs_.back().resolution;
    }
    const Rung& scale_free_rung(double r, ClampCounts& clamps) const {
        if (r < thresholds_.front()) return ++clamps.low, rungs_.front();
        if (r > r_max_) return ++clamps.high, rungs_.back();
        if (!(r <= r_max_)) return ++clamps.nan, rungs_.back();
        return rungs_[index_from(0, thresholds_.size(), r)];
    }

    bool scale_free_;
    double r_max_;
    size_t finest_ = 0;
    std::vector<double> thresholds_;
    std::vector<Rung> rungs_;
    std::vector<size_t> first_;
};

}  // namespace viscache
