#pragma once
// Resolutions of the grids (AQVC Sec. 3.2, 3.4, 3.5).
//
// Densities: D_e = N_S·P(p_e) eye samples per unit area, D_l = M·P(p_l) light samples per unit area (or per
// steradian) with M = N_P / N_S. Cells are C_E/√D_e and 1/√D_l wide, which is the footprint of the samples.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "viscache/aqvc/parameters.h"

namespace viscache {

/// [AQVC Eq. 2] Expected number of paths between two patches.
inline double expected_paths(double n_paths, double p_eye, double area_eye, double p_light,
                             double area_light) {
    return n_paths * p_eye * area_eye * p_light * area_light;
}

/// [AQVC Eq. 3] Product of the two patch areas with C_E² paths per cluster on average.
// Divided before multiplied: products of extreme densities may leave the range.
inline double patch_area_product(double p_eye, double p_light, double n_paths, double c_e) {
    return c_e / p_eye * (c_e / p_light) / n_paths;
}

/// [AQVC Eq. 5] Area of the patch of one cell if R cells span the bounding sphere of radius B_R.
inline double patch_area(double resolution, double radius) {
    const double width = 2 * radius / resolution;
    return width * width;
}

/// [AQVC Eq. 6] One resolution for both ends: R = 2 B_R (P_e P_l N_P / C_E²)^(1/4). It gives the smallest
/// patches.
// Differs (A1): the exponent is printed as −4, but Eq. 3 and 5 give (2 B_R / R)⁴ = C_E² / (P_e P_l N_P), a
// fourth root. P_e P_l N_P = D_e·D_l. Roots are taken before products, so that extreme densities stay in
// range.
inline double resolution_pair(double density_eye, double density_light, double c_e, double radius) {
    // The fourth root as two square roots, which are rounded correctly on every machine.
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
// Differs (A3): printed as √(P(ω) M / 4π). A cell covers 4π/R² and must have size 1/(P(ω) M), so 4π is a
// factor. For uniform density 1/4π and M = 256 this gives 16 × 16 cells; the printed form gives one cell for
// the whole sky.
inline double resolution_environment(double density, EnvironmentRule rule) {
    constexpr double kFourPi = 12.566370614359172954;
    return rule == EnvironmentRule::kDerived ? std::sqrt(kFourPi * density) : std::sqrt(density / kFourPi);
}

/// Number of resolutions that were clamped.
struct ClampCounts {
    uint64_t low = 0, high = 0, nan = 0;
};

/// A resolution of the ladder.
struct Rung {
    double resolution = 1;  ///< cells across, an integer; if scale-free, cells per unit of length
    int32_t slot = 1;       ///< slot of the key: R, or −k for folded rungs beyond R_max; if scale-free, k
    bool folded = false;    ///< R > R_max: coordinates do not fit 32 bits and are hashed
};

/// [AQVC Eq. 8] R ← ⌊C_R^⌊log_{C_R} R + 0.5⌋⌋ by a table of thresholds C_R^(k − ½). A query needs no pow or
/// log, and the integers are the same on every machine.
// Differs (A4): R < 1 becomes 1 (the printed form gives 0 below C_R^(−½)). NaN and infinite R become the
// finest 32-bit rung. All these cases are counted. Scale-free: the resolution is C_R^k for any integer k, and
// k is the slot.
class Ladder {
public:
    // Coordinates up to 2^30 leave room for the offset and for neighbours in 32 bits.
    Ladder(double c_r, double c_z, bool scale_free = false)
        : scale_free_(scale_free), r_max_(std::floor(0x1p30 / std::max(1.0, c_z))) {
        if (scale_free) {
            make_scale_free(c_r);
            return;
        }
        // Beyond the 32-bit rungs, up to where 64-bit coordinates in double are exact.
        const double half = std::sqrt(c_r), end = 0x1p50 / std::max(1.0, c_z);
        for (double power = 1; power <= end; power *= c_r) {
            thresholds_.push_back(power / half);
            const double r = std::floor(power);
            const bool folded = r > r_max_;
            if (!folded) finest_ = rungs_.size();
            // Folded rungs have negative slots, so their keys never equal those of other rungs.
            rungs_.push_back({r, folded ? -int32_t(rungs_.size()) : int32_t(r), folded});
        }
        // First rung of every power of two, a close start for the search.
        for (int e = 0; e <= 64; ++e) first_.push_back(index_from(0, thresholds_.size(), std::ldexp(1.0, e)));
    }
    double r_max() const { return r_max_; }
    size_t size() const { return rungs_.size(); }
    bool scale_free() const { return scale_free_; }
    const Rung& operator[](size_t k) const { return rungs_[k]; }

    const Rung& rung(double r, ClampCounts& clamps) const {
        if (scale_free_) return scale_free_rung(r, clamps);
        // NaN fails too: the finest cells are the safe answer to an unknown density.
        if (!(r >= 1)) {
            ++(r < 1 ? clamps.low : clamps.nan);
            return r < 1 ? rungs_.front() : rungs_[finest_];
        }
        if (r > r_max_) {
            ++clamps.high;
            if (!std::isfinite(r)) return rungs_[finest_];
            // The conversion below is undefined from 2^64 on.
            if (r >= 0x1p63) return rungs_.back();
        }
        // 2^e <= R < 2^(e+1): only rungs of this power of two and the next one are searched.
        const size_t e = size_t(63 - __builtin_clzll(uint64_t(r)));
        return rungs_[index_from(first_[e], std::min(first_[e + 1] + 1, thresholds_.size()), r)];
    }

    /// The same as `rung`, but tests rung `hint` first and stores the index found in `hint`.
    // Exactly the test that `rung` would end with; clamped resolutions take the long way and are counted.
    const Rung& rung_near(double r, size_t& hint, ClampCounts& clamps) const {
        if (hint + 1 < thresholds_.size() && (scale_free_ || r >= 1) && r <= r_max_ &&
            thresholds_[hint] <= r && r < thresholds_[hint + 1])
            return rungs_[hint];
        const Rung& found = rung(r, clamps);
        hint = size_t(&found - rungs_.data());
        return found;
    }

private:
    /// The largest scale-free resolution. Its inverse is the smallest.
    static constexpr double kLargest = 0x1p60;

    /// Last k in [lo, hi) with thresholds[k] <= r; thresholds[lo] <= r holds.
    size_t index_from(size_t lo, size_t hi, double r) const {
        return size_t(std::upper_bound(thresholds_.begin() + std::ptrdiff_t(lo),
                                       thresholds_.begin() + std::ptrdiff_t(hi), r) -
                      thresholds_.begin()) -
               1;
    }
    void make_scale_free(double c_r) {
        // Powers are computed from 1 in both directions, so no rung depends on where the table ends
        std::vector<double> below;
        for (double power = 1 / c_r; power >= 1 / kLargest; power /= c_r) below.push_back(power);
        for (size_t k = below.size(); k > 0; --k) rungs_.push_back({below[k - 1], -int32_t(k), false});
        int32_t k = 0;
        for (double power = 1; power <= kLargest; power *= c_r) rungs_.push_back({power, k++, false});
        // As in Eq. 8: the rung k holds from C_R^(k − ½) on.
        for (const Rung& r : rungs_) thresholds_.push_back(r.resolution / std::sqrt(c_r));
        finest_ = rungs_.size() - 1;
        r_max_ = rungs_.back().resolution;
    }
    const Rung& scale_free_rung(double r, ClampCounts& clamps) const {
        if (r < thresholds_.front()) {
            ++clamps.low;
            return rungs_.front();
        }
        if (!(r <= r_max_)) {
            ++(r > r_max_ ? clamps.high : clamps.nan);
            return rungs_.back();
        }
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
