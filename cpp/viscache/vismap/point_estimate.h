#pragma once
// The environment's light at one point: product or guided samples, with blended maps as control variate.
#include <optional>

#include "viscache/vismap/control_variate.h"
#include "viscache/vismap/guided_density.h"

namespace viscache {

/// How α is chosen.
enum class AlphaMode {
    kFixed,         ///< a number: 1 is the paper's, 0 plain importance sampling
    kLeaveOneOut,   ///< regression on the other samples of the pass; independent points only
    kPreviousPass,  ///< regression on all earlier passes; 1 in the first
};

struct AlphaChoice {
    AlphaMode mode = AlphaMode::kPreviousPass;
    double value = 1;  ///< of kFixed, and of the first pass of kPreviousPass
};

/// One direction with what it brings. Channels are in units of radiance, and not divided by N.
struct DirectionSample {
    Vec3 wi;
    uint32_t texel;
    Rgbd f;        ///< L·B/p: what it brings when it is visible
    Rgbd g;        ///< L·B̃·Ṽ/p
    double z, w;   ///< luminances of f and g over L_ns
    double d;      ///< D: density over that of product sampling
    bool matters;  ///< some channel of f is not zero
};

/// Light, reflection and maps of one point, brought together once and sampled in any number of passes.
class PointEstimate {
public:
    /// `eta` < 1 lets the maps shape the density; 1 is product sampling. The light must outlive the estimate.
    void begin(const EnvironmentPyramid& light, const Reflection& reflection, const BlendedMaps& maps,
               double eta);
    /// Draws from another density from now on; `eta` = 1: product sampling.
    void reshape(double eta);

    double l_ns() const { return tree_.total(); }
    bool dark() const { return !(tree_.total() > 0); }
    bool has_maps() const { return has_maps_; }
    bool guided() const { return guided_; }
    /// J of every channel: what `use="replace"` shows.
    const Rgbd& j() const { return integrals_.j_colour; }
    /// E[W] under the density: J/L_ns in luminance.
    double mean_w() const { return mean_w_; }
    /// Exact variance of W under the density; of luminances where light and reflection have one colour.
    double variance_w() const { return variance_w_; }
    const ProductTree& tree() const { return tree_; }
    const CellTables& cells() const { return cells_; }
    const MapIntegrals& integrals() const { return integrals_; }
    /// D at a texel.
    double density(uint32_t texel) const { return guided_ ? guide_.d[cell(texel)] : 1; }
    double visible(uint32_t texel) const { return has_maps_ ? cells_.visible[cell(texel)] : 0; }

    /// The direction of a point of the square, without what needs B: `complete` adds it. Not when `dark`.
    ProductTree::Sample draw(Point2 u) const { return tree_.sample(u); }
    /// `b` = f_r·cos at the sample's direction.
    DirectionSample complete(const ProductTree::Sample& s, Rgb b) const;

    /// α of a pass, before it is traced; empty for leave-one-out.
    std::optional<double> alpha(const AlphaChoice& choice, const AlphaSums& earlier) const;

private:
    uint32_t cell(uint32_t texel) const { return texel >> (2 * (light_->levels() - tree_.map_level())); }
    void measure(double w2);

    const EnvironmentPyramid* light_ = nullptr;
    ProductTree tree_;
    CellTables cells_;
    MapIntegrals integrals_;
    GuidedDensity guide_;
    bool has_maps_ = false, guided_ = false;
    double mean_w_ = 0, variance_w_ = 0;
};

/// One pass over a point: the estimate from its samples and their visibility. `earlier` holds the sums of the
/// passes before and takes in this one.
Rgbd finish_pass(const PointEstimate& point, std::span<const DirectionSample> samples,
                 std::span<const uint8_t> visible, const AlphaChoice& choice, AlphaSums& earlier);

}  // namespace viscache
