#pragma once
// An oracle for which all far ends are visible: light without shadows, and no rays.
#include <algorithm>

#include "viscache/oracles/exact.h"
#include "viscache/visibility/local_samples.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

class UnoccludedOracle final : public VisibilityOracle {
public:
    Answer block(const BlockAsk& ask, Counters& counters) override {
        BitMatrix& visible = new_bits(ask.wanted.rows(), ask.wanted.columns());
        for (size_t i = 0; i < visible.rows(); ++i) std::ranges::copy(ask.wanted.row_span(i), visible.row(i));
        counters.group(ask.lights.group).queries += count_bits(visible);
        return {.bits = &visible};
    }
    Answer pairs(const PairsAsk& ask, Counters& counters) override {
        BitMatrix& visible = new_bits(1, ask.size());
        for (size_t i = 0; i < ask.size(); ++i) visible.set(0, i);
        if (ask.samples) counters.group(ask.samples->group).queries += ask.size();
        for (const ShadowQuery& q : ask.queries) ++counters.group(q.group).queries;
        return {.bits = &visible};
    }
};

class UnoccludedSource final : public OracleSource {
public:
    std::unique_ptr<VisibilityOracle> make() override { return std::make_unique<UnoccludedOracle>(); }
};

}  // namespace viscache
