#pragma once
// Exact oracles of a frame whose shared points go through shafts.
#include "viscache/visibility/oracle_source.h"
#include "viscache/visibility/shaft_oracle.h"

namespace viscache {

class ShaftSource final : public OracleSource {
public:
    /// `exact` makes the oracles for all that shafts do not answer. It and `shafts` must outlive the source.
    ShaftSource(const Scene& scene, const RayCaster& caster, const ShaftScene& shafts, OracleSource& exact,
                const ShaftOptions& options = {})
        : caster_(caster),
          extent_(scene.offset_extent()),
          shafts_(shafts),
          exact_(exact),
          options_(options) {}
    /// Builds the tree, if it is not built and the frame has shared points.
    void prepare(FrameStart& frame, Control& control) override;
    std::unique_ptr<VisibilityOracle> make() override {
        return std::make_unique<ShaftOracle>(shafts_, caster_, extent_, exact_.make(), options_, totals_);
    }
    void report(Counters& counters, SourceReport& out) const override;

private:
    const RayCaster& caster_;
    float extent_;
    const ShaftScene& shafts_;
    OracleSource& exact_;
    ShaftOptions options_;
    ShaftTotals totals_;
    double tree_s_ = 0;
};

}  // namespace viscache
