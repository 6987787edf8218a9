#pragma once
// Source of Next Event Estimation++: a small frame learns the map of visibilities, then the frame uses
// Russian roulette, or the map as a control variate.
#include <optional>

#include "viscache/oracles/kept_voxels.h"
#include "viscache/oracles/mean_oracle.h"
#include "viscache/oracles/roulette_oracle.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

struct RouletteOptions {
    uint64_t seed = 0;
    /// Without `weighted`, visible connections have weight 1. This is biased on purpose, for tests that must
    /// detect it.
    bool weighted = true;
    std::optional<MeanSettings> correct;  ///< the map as a control variate, in place of roulette
    /// Frames that pass on the map, from `begin` to `commit` of each; must outlive the source.
    KeptVoxels* keep = nullptr;
};

class RouletteSource final : public OracleSource {
public:
    RouletteSource(const Scene& scene, const RayCaster& caster, const NeePlusPlusSettings& settings,
                   const RouletteOptions& options);
    void prepare(FrameStart& frame, Control& control) override;
    std::unique_ptr<VisibilityOracle> make() override;
    bool corrects() const override { return options_.correct.has_value(); }
    void report(Counters& counters, SourceReport& out) const override;

private:
    const RayCaster& caster_;
    NeePlusPlusSettings settings_;
    RouletteOptions options_;
    std::optional<VoxelVisibility> own_;  ///< without `keep`
    VoxelVisibility& map_;
    uint64_t learning_rays_ = 0;
    double learning_s_ = 0;
};

}  // namespace viscache
