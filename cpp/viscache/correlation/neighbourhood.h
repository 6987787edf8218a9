#pragma once
// Pairs of points near each other, all of them: random pairs hardly ever are.
#include "viscache/correlation/pair_statistics.h"

namespace viscache {

/// Sums over all pairs i < j within the edges; the last edge of distance must be finite.
PairTable near_pairs(const PairRows& rows, const BinEdges& distances, const BinEdges& angles, double d_near,
                     const PairWork& work, Control& control);

/// Mean ρ of every point with the points nearer than d_max whose normals differ by less than theta_max_deg;
/// NaN where no such point has a ρ with it.
std::vector<float> spatial_map(const PairRows& rows, double d_max, double theta_max_deg, const PairWork& work,
                               Control& control);

}  // namespace viscache
