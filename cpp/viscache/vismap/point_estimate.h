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

/// What a pass needs to know of its point.
struct PointMoments {
    double l_ns = 0;
    Rgbd j{};               ///< J of every channel: what `use="replace"` shows
    double mean_w = 0;      ///< E[W] under the density: J/L_ns in luminance
    double variance_w = 0;  ///< Var W under the density; exact where light and reflection have one colour
};

/// α of a pass, before it is traced; empty for leave-one-out. `earlier`: the sums of the passes before.
std::optional<double> alpha_of_pass(const PointMoments& point, const AlphaChoice& choice,
                                    const AlphaSums& earlier);

/// One pass over a point: the estimate from its samples and their visibility. `earlier` takes in this pass.
Rgbd finish_pass(const PointMoments& point, std::span<const DirectionSample> samples,
                 std::span<const uint8_t> visible, const AlphaChoice& choice, AlphaSums& earlier);

/// Light, reflection and maps of one point, brought together once and sampled in any number of passes.
class PointEstimate {
public:
    /// Light × reflection; the maps to come have 2^m × 2^m cells. The light must outlive the estimate.
    void begin(const EnvironmentPyramid& light, const Reflection& reflection, int m);
    /// × maps, of the m given; `with_dilated` where `guide` may follow.
    void look(const BlendedMaps& maps, bool with_dilated);
    /// Draws by a density that the maps shape from now on, 0 < eta < 1; `apply` = false only prepares D, for
    /// a forecast. False: D ≡ 1 has to do.
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
    /// D as the last successful `guide` made it, applied or not.
    double shaped_density(uint32_t texel) const { return guide_.d[cell(texel)]; }
    /// Ṽ at a texel.
    double visible(uint32_t texel) const { return has_maps_ ? cells_.visible[cell(texel)] : 0; }

    /// The direction of a point of the square, without what needs B: `complete` adds it. Not when `dark`.
    ProductTree::Sample draw(Point2 u) const { return tree_.sample(u); }
    /// `b` = f_r·cos at the sample's direction.
    DirectionSample complete(const ProductTree::Sample& s, Rgb b) const;

private:
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
