#pragma once
// Source of shadow maps: traced before the first tile of a frame, then read by all threads.
#include <optional>

#include "viscache/oracles/shadow_map_oracle.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

class ShadowMapSource final : public OracleSource {
public:
    ShadowMapSource(const Scene& scene, const RayCaster& caster, const ShadowMapSettings& settings);
    void prepare(FrameStart& frame, Control& control) override;
    std::unique_ptr<VisibilityOracle> make() override;
    void report(Counters& counters, SourceReport& out) const override;

private:
    const RayCaster& caster_;
    ShadowMapExtent extent_;
    ShadowMapSettings settings_;
    std::optional<ShadowMaps> maps_;
    double maps_s_ = 0;
};

}  // namespace viscache
