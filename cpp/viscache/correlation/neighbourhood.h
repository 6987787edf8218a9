#pragma once
// Statistics over all pairs of nearby points. Random pairs are rarely near each other.
#include "viscache/correlation/pair_statistics.h"

namespace viscache {

/// Sums over all pairs i < j that fall into the bins. The last distance edge must be finite.
PairTable near_pairs(const PairRows& rows, const BinEdges& distances, const BinEdges& angles, double d_near,
                     const PairWork& work, Control& control);

/// Mean ρ of every point with all points nearer than d_max whose normals differ by less than theta_max_deg.
/// NaN where ρ is undefined with all of them.
std::vector<float> spatial_map(const PairRows& rows, double d_max, double theta_max_deg, const PairWork& work,
                               Control& control);

}  // namespace viscache
