#pragma once
// An oracle for which all far ends are visible: light without shadows, and no rays.
#include <algorithm>

#include "viscache/visibility/exact.h"
#include "viscache/visibility/local_samples.h"
#include "viscache/visibility/oracle_source.h"

namespace viscache {

class UnoccludedOracle final : public VisibilityOracle {
public:
    void begin_tile(const EyeBlock&) override {}
    void block(const EyeBlock&, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override {
        for (size_t i = 0; i < wanted.rows(); ++i) std::ranges::copy(wanted.row_span(i), visible.row(i));
        counters.group(lights.group).queries += count_bits(wanted);
    }
    void pairs(const EyeBlock&, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override {
        for (size_t i = 0; i < queries.size(); ++i) {
            set_bit(visible.data(), i);
            ++counters.group(queries[i].group).queries;
        }
    }
    void samples(const EyeBlock&, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override {
        for (size_t i = 0; i < samples.size(); ++i) set_bit(visible.data(), i);
        counters.group(samples.group).queries += samples.size();
    }
};

class UnoccludedSource final : public OracleSource {
public:
    std::unique_ptr<VisibilityOracle> make() override { return std::make_unique<UnoccludedOracle>(); }
};

}  // namespace viscache
