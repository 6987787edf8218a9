#pragma once
// How often points of one voxel see points of another: the map of Next Event Estimation++ (Guo, Eisemann,
// Eisemann 2020).
//
// The scene's bounding box is cut into n³ voxels. For every pair of voxels two counts are kept: shadow rays
// traced, and those that got through. Light from infinity has cells of directions beside the voxels. Counts
// are sums of whole numbers: the same for any order and any number of threads.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>

#include "viscache/math/bounds.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

struct NeePlusPlusSettings {
    int n_voxels = 16;              ///< along an edge of the scene's bounding box
    int n_directions = 16;          ///< cells along an edge of the octahedral square, for light from infinity
    int learn_pixels = 4096;        ///< of the small frame that the map is learnt from
    double min_probability = 0.05;  ///< of tracing: no weight exceeds its inverse
    double exponent = 1;            ///< traced with probability p^exponent: 1 the paper, 0 always
    bool symmetric = true;          ///< V(a, b) and V(b, a) share counts
    uint64_t max_bytes = 1ull << 30;
    /// Throws std::invalid_argument saying what must hold.
    void validate() const;
};

class VoxelVisibility {
public:
    /// Throws std::invalid_argument where the counts would take more than settings.max_bytes.
    VoxelVisibility(const Bounds& bounds, const NeePlusPlusSettings& settings);

    uint32_t voxels() const { return voxels_; }
    uint64_t bytes() const { return size_ * sizeof(Counts); }

    /// Voxel of a point; outside the box the nearest one.
    uint32_t voxel(Vec3 p) const {
        auto cell = [&](float x, float low, float scale) {
            float t = (x - low) * scale;
            t = t > 0 ? t : 0;  // also where t is not a number
            return uint32_t(std::min(t, float(n_ - 1)));
        };
        return (cell(p.z, low_.z, scale_.z) * n_ + cell(p.y, low_.y, scale_.y)) * n_ +
               cell(p.x, low_.x, scale_.x);
    }
    /// Cell of a far end: a voxel, or behind the voxels a cell of directions.
    uint32_t far_cell(Semantic semantic, Vec3 far) const;

    /// One shadow ray from a voxel to the cell of a far end. Any threads at once.
    void add(uint32_t voxel, uint32_t far, bool seen);
    /// Estimated visibility in (0, 1], 1 where nothing was tested.
    /// One imagined connection that got through is counted with the others: few tests that all failed do not
    /// give 0.
    double visibility(uint32_t voxel, uint32_t far) const {
        const Counts& c = counts_[place(voxel, far)];
        return (double(c.seen) + 1) / (double(c.tested) + 1);
    }
    /// Probability of tracing a connection: max(min_probability, visibility^exponent).
    double probability(uint32_t voxel, uint32_t far) const {
        const double p = visibility(voxel, far);
        return std::max(min_probability_, exponent_ == 1 ? p : std::pow(p, exponent_));
    }
    /// Pairs of cells that were tested at least once.
    uint64_t pairs_tested() const { return pairs_tested_.load(); }

private:
    struct Counts {
        uint32_t tested = 0, seen = 0;
    };
    /// Pairs of voxels first, then voxels with directions.
    size_t place(uint32_t voxel, uint32_t far) const {
        if (far >= voxels_) return voxel_pairs_ + size_t(voxel) * directions_ + (far - voxels_);
        if (!symmetric_) return size_t(voxel) * voxels_ + far;
        const size_t low = std::min(voxel, far), high = std::max(voxel, far);
        return high * (high + 1) / 2 + low;
    }

    uint32_t n_, edge_, voxels_, directions_;
    Vec3 low_, scale_;  ///< corner of the box, voxels per unit of length
    bool symmetric_;
    double min_probability_, exponent_;
    size_t voxel_pairs_, size_;
    /// Zeros of the system: most pairs are never touched.
    std::unique_ptr<Counts[], decltype(&std::free)> counts_{nullptr, &std::free};
    std::atomic<uint64_t> pairs_tested_{0};
};

}  // namespace viscache
