#pragma once
// An audit of single queries: exact rays answer all bright connections, and a share of the others.
#include <functional>

#include "viscache/render/audit.h"
#include "viscache/render/local_samples.h"

namespace viscache {

/// The audit of one tile after another, on one thread.
class QueryAudit {
public:
    QueryAudit(const FrameSettings& frame, const RayCaster& caster, const Control& control)
        : frame_(frame), exact_(caster) {
        exact_.watch(control);
    }
    void begin_tile(const EyeTile& eyes);
    /// A block of the tile and its answer. `light`: light of the columns of a row at the pixel of an eye
    /// point.
    using Light = std::function<Rgb(size_t eye, const Word* row)>;
    void block(const BlockAsk& ask, const Answer& answer, const TileContributions& contributions,
               const Light& light);
    /// Samples of single eye points and their answer.
    void samples(const WeightedSamples& samples, const Answer& answer);
    void end_tile(AuditRecords& out);

private:
    /// Sets each of the first n bits with the frame's share as probability.
    void draw(uint64_t stream, int group, size_t n, std::span<Word> bits) const;

    const FrameSettings& frame_;
    ExactOracle exact_;
    const EyeTile* eyes_ = nullptr;
    Counters counters_;
    std::array<AuditedQueries, kLightGroups> found_;
    BitMatrix asked_, bright_;
    std::vector<Word> row_;
};

}  // namespace viscache
