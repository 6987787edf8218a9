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
    std::unique_ptr<VisibilityOracle> make() override {
        return std::make_unique<ShaftOracle>(shafts_, caster_, extent_, exact_.make(), options_, totals_);
    }
    void report(Counters& counters, SourceReport& out) const override {
        exact_.report(counters, out);
        const ShaftTotals::Sums sums = totals_.sums();
        const auto add = [&](const char* name, SourceReport::Value v) { out.engine.emplace_back(name, v); };
        add("shaft_queries", sums.queries);
        add("left_to_packets", sums.left_to_packets);
        add("shaft_nodes", sums.work.nodes);
        add("shaft_blocks", sums.work.blocks);
        add("shaft_lists", sums.work.lists);
        add("shaft_pairs", sums.work.pairs);
        add("shaft_doubted", sums.work.doubted);
        add("shaft_long_lists", sums.work.long_lists);
        if (!shafts_.refusal().empty()) add("no_shafts", shafts_.refusal());
    }

private:
    const RayCaster& caster_;
    float extent_;
    const ShaftScene& shafts_;
    OracleSource& exact_;
    ShaftOptions options_;
    ShaftTotals totals_;
};

}  // namespace viscache
