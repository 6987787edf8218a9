#pragma once
// Exact oracles of a frame whose shared points go through shafts.
#include "viscache/shafts/shaft_oracle.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

class ShaftSource final : public OracleSource {
public:
    /// `exact` makes the oracles for all that shafts do not answer. It and `shafts` must outlive the source.
    ShaftSource(const RayCaster& caster, const ShaftScene& shafts, OracleSource& exact,
                const ShaftOptions& options = {})
        : caster_(caster), shafts_(shafts), exact_(exact), options_(options) {}
    /// Builds the tree, if the frame is to use it.
    void prepare(FrameStart& frame, Control& control) override;
    std::unique_ptr<VisibilityOracle> make() override;
    void report(Counters& counters, SourceReport& out) const override;

private:
    std::string reason_against(const FrameStart& frame) const;

    const RayCaster& caster_;
    const ShaftScene& shafts_;
    OracleSource& exact_;
    ShaftOptions options_;
    ShaftTotals totals_;
    std::string no_shafts_;  ///< why packets answer everything
    double tree_s_ = 0;
};

}  // namespace viscache
