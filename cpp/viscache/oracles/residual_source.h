#pragma once
// use="correct": source of oracles that correct those of another source.
#include <memory>

#include "viscache/oracles/residual_oracle.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

class ResidualSource final : public OracleSource {
public:
    /// `inner` must outlive the source and belong to it alone.
    ResidualSource(const RayCaster& caster, OracleSource& inner, const ResidualSettings& settings)
        : caster_(caster), inner_(inner), settings_(settings) {
        if (settings.share && !(*settings.share > 0 && *settings.share <= 1))
            throw std::invalid_argument("share must be in (0, 1], got " + std::to_string(*settings.share));
        if (!(settings.certain > 0))
            throw std::invalid_argument("certain must be > 0, got " + std::to_string(settings.certain));
        for (const auto& group : settings.octaves)
            for (const unsigned octaves : group)
                if (octaves > kMostOctaves)
                    throw std::invalid_argument("octaves must be in [0, 4], got " + std::to_string(octaves));
        inner_.expect_corrections();
    }
    void prepare(FrameStart& frame, Control& control) override { inner_.prepare(frame, control); }
    std::unique_ptr<VisibilityOracle> make() override {
        return std::make_unique<ResidualOracle>(inner_.make(), caster_, settings_);
    }
    bool corrects() const override { return true; }
    int dealt_tile_edge() const override { return inner_.dealt_tile_edge(); }
    void begin_round(size_t items) override { inner_.begin_round(items); }
    void end_item(VisibilityOracle& oracle, size_t item) override {
        inner_.end_item(dynamic_cast<ResidualOracle&>(oracle).inner(), item);
    }
    void end_round(Counters& counters) override { inner_.end_round(counters); }
    void report(Counters& counters, SourceReport& out) const override {
        inner_.report(counters, out);
        out.counters.emplace_back("corrections", counters.corrections);
        out.counters.emplace_back("wrong", counters.wrong);
        out.counters.emplace_back("exact_queries", counters.exact_queries);
    }

private:
    const RayCaster& caster_;
    OracleSource& inner_;
    ResidualSettings settings_;
};

}  // namespace viscache
