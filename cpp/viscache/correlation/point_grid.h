#pragma once
// A uniform grid over points, for neighbour searches.
#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

/// Points in cells at least `size` wide: all points nearer than `size` lie in the 27 cells around a point.
class PointGrid {
public:
    PointGrid(std::span<const Vec3> points, double size);

    size_t cells() const { return keys_.size(); }
    std::span<const uint32_t> members(size_t cell) const {
        return {order_.data() + first_[cell], first_[cell + 1] - first_[cell]};
    }
    /// Calls visit(members) for runs of cells that together hold all points in the 27 cells around a cell.
    template <class Visit>
    void around(size_t cell, Visit visit) const {
        for (uint64_t dz : {0, 1, 2})
            // Nine rows of three cells
            for (uint64_t dy : {0, 1, 2}) {
                // Three cells along x have consecutive keys. Coordinates start at 1, so no key wraps around
                const uint64_t middle = keys_[cell] + ((dz - 1) << (2 * kAxisBits)) + ((dy - 1) << kAxisBits);
                const auto lo = std::lower_bound(keys_.begin(), keys_.end(), middle - 1),
                           hi = std::upper_bound(lo, keys_.end(), middle + 1);
                const size_t a = first_[size_t(lo - keys_.begin())], b = first_[size_t(hi - keys_.begin())];
                if (a < b) visit(std::span<const uint32_t>(order_.data() + a, b - a));
            }
    }

private:
    static constexpr int kAxisBits = 21;

    std::vector<uint32_t> order_;  ///< indices of the points, cell by cell
    std::vector<uint64_t> keys_;   ///< keys of the non-empty cells, in increasing order
    std::vector<size_t> first_;    ///< first entry of every cell in order_, and the end
};

inline PointGrid::PointGrid(std::span<const Vec3> points, double size) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, extent = 0;
    for (const Vec3& p : points)
        for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], double(p[k]));
    for (const Vec3& p : points)
        for (int k = 0; k < 3; ++k) extent = std::max(extent, p[k] - low[k]);
    // Slightly wider, to allow for the rounding of coordinates; and at most as many cells as an axis has
    // numbers
    const double width = std::max(size * (1 + 1e-5), extent / double((1 << kAxisBits) - 4));
    auto key = [&](Vec3 p) {
        uint64_t k = 0;
        // x is lowest, so that three cells along x are one range of keys.
        for (int axis : {2, 1, 0}) {
            const double at = width > 0 ? (p[axis] - low[axis]) / width : 0;
            k = k << kAxisBits | (uint64_t(at) + 1);
        }
        return k;
    };
    std::vector<uint64_t> point_keys(points.size());
    for (size_t i = 0; i < points.size(); ++i) point_keys[i] = key(points[i]);
    order_.resize(points.size());
    std::iota(order_.begin(), order_.end(), 0u);
    // By index inside a cell: the order is the same everywhere.
    std::sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) {
        return point_keys[a] != point_keys[b] ? point_keys[a] < point_keys[b] : a < b;
    });
    for (size_t k = 0; k < order_.size(); ++k)
        if (!k || point_keys[order_[k]] != point_keys[order_[k - 1]]) {
            keys_.push_back(point_keys[order_[k]]);
            first_.push_back(k);
        }
    first_.push_back(order_.size());
}

}  // namespace viscache
