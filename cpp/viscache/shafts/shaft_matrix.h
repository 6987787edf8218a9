#pragma once
// Visibility of all targets from all points, by shafts where they pay.
#include <span>
#include <string>

#include "viscache/shafts/shaft_oracle.h"

namespace viscache {

/// What shafts did in one call.
struct ShaftMatrixWork {
    std::string no_shafts;  ///< why packets answered everything; empty: shafts were used
    ShaftTotals::Sums sums;
    double tree_s = 0;  ///< seconds that the tree took, if this call built it
};

/// The bits of `visible_matrix`. Tiles of points go through shafts, one target after another; rays answer
/// what bounds of rounding leave open, and tiles that shafts do not suit. The caster must be Embree's with
/// robust rays. Besides `rows`, the call needs 4 bytes per point, and about 1 MB per thread.
ShaftMatrixWork shaft_matrix(const ShaftScene& scene, const RayCaster& caster, std::span<const Vec3> points,
                             std::span<const Vec3> targets, std::span<Word> rows, const ShaftOptions& options,
                             int threads, Control& control);

}  // namespace viscache
