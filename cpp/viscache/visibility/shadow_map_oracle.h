#pragma once
// Shadow maps as an oracle: depth tests for the lights that have maps, exact rays for all others.
#include "viscache/visibility/exact.h"
#include "viscache/visibility/shadow_map.h"

namespace viscache {

/// Answers for groups without maps are exact and count as bypassed: area, environment and ambient samples,
/// and virtual point lights by default.
class ShadowMapOracle final : public VisibilityOracle {
public:
    /// `maps` must outlive the oracle and may be shared by several.
    ShadowMapOracle(const ShadowMaps& maps, const RayCaster& caster, float extent)
        : maps_(maps), exact_(caster, extent) {}

    void watch(const Control& control) override;
    void begin_tile(const EyeBlock&) override {}
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;

private:
    const ShadowMaps& maps_;
    ExactOracle exact_;
};

}  // namespace viscache
