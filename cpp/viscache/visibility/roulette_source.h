#pragma once
// Source of Next Event Estimation++: a small frame learns the map of visibilities, then the frame uses
// Russian roulette.
#include <optional>

#include "viscache/scene/scene.h"
#include "viscache/visibility/oracle_source.h"
#include "viscache/visibility/roulette_oracle.h"

namespace viscache {

class RouletteSource final : public OracleSource {
public:
    /// Without `weighted`, visible connections have weight 1. This is biased on purpose, for tests that must
    /// detect it.
    RouletteSource(const Scene& scene, const RayCaster& caster, const NeePlusPlusSettings& settings,
                   uint64_t seed, bool weighted = true);
    void prepare(FrameStart& frame, Control& control) override;
    std::unique_ptr<VisibilityOracle> make() override;
    void report(Counters& counters, SourceReport& out) const override;

private:
    const RayCaster& caster_;
    float extent_;
    NeePlusPlusSettings settings_;
    uint64_t seed_;
    bool weighted_;
    VoxelVisibility map_;
    uint64_t learning_rays_ = 0;
    double learning_s_ = 0;
};

}  // namespace viscache
