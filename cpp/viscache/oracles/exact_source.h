#pragma once
// Source of exact oracles.
#include "viscache/oracles/exact.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

class ExactSource final : public OracleSource {
public:
    /// Without an order or a flag, each packet gets those that suit it.
    explicit ExactSource(const RayCaster& caster, std::optional<PacketOrder> order = std::nullopt,
                         std::optional<Coherence> flag = std::nullopt)
        : caster_(caster), order_(order), flag_(flag) {}
    std::unique_ptr<VisibilityOracle> make() override {
        return std::make_unique<ExactOracle>(caster_, order_, flag_);
    }

private:
    const RayCaster& caster_;
    std::optional<PacketOrder> order_;
    std::optional<Coherence> flag_;
};

}  // namespace viscache
