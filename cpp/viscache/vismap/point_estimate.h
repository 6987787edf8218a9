#pragma once
// Estimates the environment light reflected at one point from product or guided samples, with blended maps
// as control variate.
#include <optional>

#include "viscache/vismap/control_variate.h"
#include "viscache/vismap/guided_density.h"

namespace viscache {

/// How α is chosen.
enum class AlphaMode {
    kFixed,         ///< a constant: 1 as in the paper, 0 for plain importance sampling
    kLeaveOneOut,   ///< regression on the other samples of the pass; for independent samples only
    kPreviousPass,  ///< regression on all earlier passes; 1 in the first pass
};

struct AlphaChoice {
    AlphaMode mode = AlphaMode::kPreviousPass;
    double value = 1;  ///< for kFixed, and for the first pass of kPreviousPass
};

/// A sampled direction and its contribution. Channels are in units of radiance and not divided by N.
struct DirectionSample {
    Vec3 wi;
    uint32_t texel;
    Rgbd f;        ///< L·B/p: the contribution if the direction is visible
    Rgbd g;        ///< L·B̃·Ṽ/p
    double z, w;   ///< luminances of f and g divided by L_ns
    double d;      ///< D: the density divided by that of product sampling
    bool matters;  ///< some channel of f is not zero
};

/// Moments of a point that a pass needs.
struct PointMoments {
    double l_ns = 0;
    Rgbd j{};               ///< J of every channel: the result of `use="replace"`
    double mean_w = 0;      ///< E[W] under the density: J/L_ns in luminance
    double variance_w = 0;  ///< Var W under the density; exact if light and reflection each have one colour
};

/// α of a pass, known before it is traced; empty for leave-one-out. `earlier` holds the sums of the previous
/// passes.
std::optional<double> alpha_of_pass(const PointMoments& point, const AlphaChoice& choice,
                                    const AlphaSums& earlier);

/// Computes the estimate of one pass at a point from its samples and their visibility, and adds the pass to
/// `earlier`.
Rgbd finish_pass(const PointMoments& point, std::span<const DirectionSample> samples,
                 std::span<const uint8_t> visible, const AlphaChoice& choice, AlphaSums& earlier);

/// Light, reflection and maps of one point, combined once and sampled in any number of passes.
class PointEstimate {
public:
    /// Starts with light × reflection. Maps added later have 2^m × 2^m cells. The light must outlive the
    /// estimate.
    void begin(const EnvironmentPyramid& light, const Reflection& reflection, int m);
    /// Multiplies by maps with the given m. `with_dilated` is required if `guide` follows.
    void look(const BlendedMaps& maps, bool with_dilated);
    /// Uses the maps to guide the density from now on, 0 < eta < 1. With `apply` = false it only computes D,
    /// for a forecast. Returns false if D ≡ 1 must be used.
    bool guide(double eta, bool apply = true);

    bool dark() const { return !(tree_.total() > 0); }
    bool has_maps() const { return has_maps_; }
    bool guided() const { return tree_.guided(); }
    const PointMoments& moments() const { return moments_; }
    const ProductTree& tree() const { return tree_; }
    const CellTables& cells() const { return cells_; }
    const MapIntegrals& integrals() const { return integrals_; }
    /// D at a texel: 1 unless guided.
    double density(uint32_t texel) const { return guided() ? shaped_density(texel) : 1; }
    /// D of the last successful `guide`, whether applied or not.
    double shaped_density(uint32_t texel) const { return guide_.d[cell(texel)]; }
    /// Ṽ at a texel.
    double visible(uint32_t texel) const { return has_maps_ ? cells_.visible[cell(texel)] : 0; }

    /// The direction for a point of the square, without the terms that need B; `complete` adds them. Must
    /// not be called when `dark`.
    ProductTree::Sample draw(Point2 u) const { return tree_.sample(u); }
    /// `b` = f_r·cos at the sample's direction.
    DirectionSample complete(const ProductTree::Sample& s, Rgb b) const;

private:
    // By bits of the code, never by projecting the direction again: rounding could find the neighbouring
    // cell.
    uint32_t cell(uint32_t texel) const { return texel >> (2 * (light_->levels() - tree_.map_level())); }
    void measure(double w2);

    const EnvironmentPyramid* light_ = nullptr;
    ProductTree tree_;
    CellTables cells_;
    MapIntegrals integrals_;
    GuidedDensity guide_;
    PointMoments moments_;
    bool has_maps_ = false;
};

}  // namespace viscache
