#pragma once
// A density guided by visibility, beyond the paper: p = (L·B̃/L_ns)·D with D = η + (1 − η) Σ_k a_k Ṽ^k/μ_k.
// Ṽ^k is the blend of the maps dilated k times, and μ_k = (1/L_ns) ∫ L·B̃·Ṽ^k. Under product sampling D has
// mean one, so p is normalised and the same warp samples it.
#include "viscache/vismap/triple_product.h"

namespace viscache {

/// The a_k; their sum is one. The least dilated maps weigh most.
constexpr std::array<double, 3> density_shares(int m) {
    return m >= 6 ? std::array<double, 3>{0.5, 0.3, 0.2} : std::array<double, 3>{0.67, 0.33, 0};
}
/// If the records see less than this fraction of L_ns, the density stays that of product sampling.
constexpr double kLeastSeen = 1e-9;

struct GuidedDensity {
    std::vector<double> d;  ///< D of the cells, >= η
    double w2 = 0;          ///< Σ P Ṽ²/D: second moment of W/D under p, times L_ns
};

/// Fills `out`, for 0 < eta < 1. Returns false if D ≡ 1 must be used. `integrals` and `cells` come from
/// `integrate_maps` with dilated maps.
bool shape_density(const ProductTree& tree, const MapIntegrals& integrals, const CellTables& cells,
                   double eta, GuidedDensity& out);

}  // namespace viscache
