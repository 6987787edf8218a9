#pragma once
// Shadow maps as an oracle: depth tests for the lights that have maps, exact rays for all others.
#include "viscache/oracles/exact.h"
#include "viscache/oracles/shadow_map.h"

namespace viscache {

/// Groups without maps are answered by rays and count as bypassed: area, environment and ambient samples, and
/// virtual point lights by default. Their answers do not say that they are exact, so use="correct" checks
/// them like all others.
class ShadowMapOracle final : public VisibilityOracle {
public:
    /// `maps` must outlive the oracle and may be shared by several.
    ShadowMapOracle(const ShadowMaps& maps, const RayCaster& caster) : maps_(maps), exact_(caster) {
        wrap(exact_);
    }

    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

private:
    const ShadowMaps& maps_;
    ExactOracle exact_;
};

}  // namespace viscache
