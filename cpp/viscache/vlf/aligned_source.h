#pragma once
// Exact oracles of a frame whose shared directions may go through the aligned batch.
#include "viscache/visibility/oracle_source.h"
#include "viscache/vlf/aligned_oracle.h"

namespace viscache {

class AlignedSource final : public OracleSource {
public:
    /// With `choose`, each tile takes the engine that is cheaper for it.
    AlignedSource(const RayCaster& caster, const AlignedBatch& batch, bool choose,
                  std::optional<PacketOrder> order, std::optional<Coherence> flag)
        : batch_(batch), caster_(caster), order_(order), flag_(flag), choose_(choose) {}
    std::unique_ptr<VisibilityOracle> make() override {
        ExactOracle exact(caster_, order_, flag_);
        return std::make_unique<AlignedOracle>(batch_, std::move(exact), choose_);
    }
    void report(Counters& c, SourceReport& out) const override {
        const double share = c.predicted_rays ? 1 / double(c.predicted_rays) : 0;
        const char* name = c.batch_rays == c.direction_rays ? "batch"
                           : c.batch_rays                   ? "batch and embree"
                                                            : "embree";
        out.engine = {{"name", std::string(name)},
                      {"direction_rays", c.direction_rays},
                      {"batch_rays", c.batch_rays},
                      {"batch_ns", c.batch_ns * share},
                      {"embree_ns", c.embree_ns * share}};
    }

private:
    const AlignedBatch& batch_;
    const RayCaster& caster_;
    std::optional<PacketOrder> order_;
    std::optional<Coherence> flag_;
    bool choose_;
};

}  // namespace viscache
