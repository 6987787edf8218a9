#pragma once
// The visibility map of Next Event Estimation++ (Guo, Eisemann, Eisemann 2020): visibility between pairs of
// voxels.
//
// The bounding box of the scene is divided into n³ voxels. Every pair of voxels has two counts: shadow rays
// traced, and shadow rays not blocked. Light from infinity uses cells of directions beside the voxels. Counts
// are sums of integers, so they are the same for any order and any number of threads.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>

#include "viscache/math/bounds.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/parameter_row.h"

namespace viscache {

/// What each is, and its range: kNeePlusPlusRows.
struct NeePlusPlusSettings {
    int n_voxels = 16;
    int n_directions = 16;
    int learn_pixels = 4096;
    int relearn_pixels = 256;
    double min_probability = 0.05;
    double exponent = 1;
    double certain = 1.0 / 256;
    bool symmetric = true;
    uint64_t max_bytes = 1ull << 30;
    /// Throws std::invalid_argument with a message that says what must hold.
    void validate() const;
};

// clang-format off
inline constexpr std::tuple kNeePlusPlusRows{
    row("n_voxels", &NeePlusPlusSettings::n_voxels, {.low = 1, .high = 64},
        "Voxels along an edge of the scene's bounding box."),
    row("n_directions", &NeePlusPlusSettings::n_directions, {.low = 1, .high = 256},
        "Cells along an edge of the octahedral square: far ends of light from infinity."),
    row("learn_pixels", &NeePlusPlusSettings::learn_pixels, {.low = 1, .high = 1 << 30},
        "The map is learnt from a frame of so many pixels, at most those of the frame itself, with one "
        "sample per pixel."),
    row("relearn_pixels", &NeePlusPlusSettings::relearn_pixels, {.low = 0, .high = 1 << 30},
        "The same of each later frame, if frames pass on what they have learnt."),
    row("min_probability", &NeePlusPlusSettings::min_probability, {.low = 1e-3, .high = 1},
        "Every connection is traced at least that often. 1: the exact frame. Not with `use=\"correct\"`."),
    row("exponent", &NeePlusPlusSettings::exponent, {.low = 0, .high = 4},
        "1: in proportion to the visibility, as the paper does. 0: the exact frame. Not with "
        "`use=\"correct\"`."),
    row("certain", &NeePlusPlusSettings::certain, {.low = 0, .above = true},
        "For `use=\"correct\"`. Half as much draws up to twice as many rays."),
    row("symmetric", &NeePlusPlusSettings::symmetric,
        "V(a, b) and V(b, a) are learnt together."),
    row("max_bytes", &NeePlusPlusSettings::max_bytes, {.low = 1},
        "Refuse a map that would take more: 8 bytes for each pair of voxels, and for each voxel with a cell "
        "of directions."),
};
// clang-format on

inline void NeePlusPlusSettings::validate() const { check_rows(kNeePlusPlusRows, *this); }

class VoxelVisibility {
public:
    /// Throws std::invalid_argument if the counts need more than settings.max_bytes.
    VoxelVisibility(const Bounds& bounds, const NeePlusPlusSettings& settings);

    uint32_t voxels() const { return voxels_; }
    uint64_t bytes() const { return size_ * sizeof(Counts); }

    /// Voxel of a point; the nearest one for points outside the box.
    uint32_t voxel(Vec3 p) const {
        auto cell = [&](float x, float low, float scale) {
            float t = (x - low) * scale;
            t = t > 0 ? t : 0;  // also if t is NaN
            return uint32_t(std::min(t, float(n_ - 1)));
        };
        return (cell(p.z, low_.z, scale_.z) * n_ + cell(p.y, low_.y, scale_.y)) * n_ +
               cell(p.x, low_.x, scale_.x);
    }
    /// Cell of a far end: a voxel, or a cell of directions, numbered after the voxels.
    uint32_t far_cell(Semantic semantic, Vec3 far) const;

    /// Index of a pair of cells: pairs of voxels first, then voxels with directions.
    size_t place(uint32_t voxel, uint32_t far) const {
        if (far >= voxels_) return voxel_pairs_ + size_t(voxel) * directions_ + (far - voxels_);
        if (!symmetric_) return size_t(voxel) * voxels_ + far;
        const size_t low = std::min(voxel, far), high = std::max(voxel, far);
        return high * (high + 1) / 2 + low;
    }
    size_t size() const { return size_; }

    /// Adds a shadow ray from a voxel to the cell of a far end. Safe to call from several threads.
    void add(uint32_t voxel, uint32_t far, bool seen) { add_at(place(voxel, far), seen); }
    void add_at(size_t place, bool seen);
    /// Takes back one call of `add_at`. Not safe while others read or write.
    void remove_at(size_t place, bool seen);
    struct Counts {
        uint32_t tested = 0, seen = 0;
    };
    const Counts& at(size_t place) const { return counts_[place]; }
    /// Sets the counts of a pair that has none.
    void restore(size_t place, Counts counts);
    /// Estimated visibility in (0, 1]; 1 without tests. One unblocked ray is added to the counts, so that a
    /// few blocked rays do not give 0.
    double visibility(uint32_t voxel, uint32_t far) const {
        const Counts& c = counts_[place(voxel, far)];
        return (double(c.seen) + 1) / (double(c.tested) + 1);
    }
    /// Probability of tracing a connection: max(min_probability, visibility^exponent).
    double probability(uint32_t voxel, uint32_t far) const {
        const double p = visibility(voxel, far);
        return std::max(min_probability_, exponent_ == 1 ? p : std::pow(p, exponent_));
    }
    /// Mean visibility in (0, 1), with half an unblocked and half a blocked ray added to the counts: 1/2
    /// without tests.
    double mean(uint32_t voxel, uint32_t far) const {
        const Counts& c = counts_[place(voxel, far)];
        return (double(c.seen) + 0.5) / (double(c.tested) + 1);
    }
    /// Number of pairs of cells with at least one test.
    uint64_t pairs_tested() const { return pairs_tested_.load(); }

private:
    uint32_t n_, edge_, voxels_, directions_;
    Vec3 low_, scale_;  ///< lower corner of the box, and voxels per unit of length
    bool symmetric_;
    double min_probability_, exponent_;
    size_t voxel_pairs_, size_;
    /// Zeroed by calloc: most pairs are never used, so their pages are never touched.
    std::unique_ptr<Counts[], decltype(&std::free)> counts_{nullptr, &std::free};
    std::atomic<uint64_t> pairs_tested_{0};
};

}  // namespace viscache
