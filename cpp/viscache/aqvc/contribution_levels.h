#pragma once
// C_E by contribution: a connection with a small contribution shares its bit with more eye samples.
//
// This goes beyond the paper, which sets C_E per light group. Let f be the unoccluded contribution of a
// connection, relative to the mean over the connections of the eye point. The connection gets C_E·f^(−1/p).
// At a level with C_E = C_d, all connections with f <= (C_E / C_d)^p are due; brighter ones wait for a finer
// level. A connection ends at the first level where C_d·level_step <= its own C_E, even if neighbours
// disagree. The coarsest level has C_E times kLift.
#include <cmath>
#include <vector>

#include "viscache/aqvc/columns.h"

namespace viscache {

class ContributionLevels {
public:
    static constexpr double kPower = 2.5;  ///< p: how strongly cells shrink for bright connections
    static constexpr double kLift = 2;     ///< C_E of the coarsest level, divided by C_E of the group

    /// Without a source, every column is due at every level and refined to the finest.
    void begin(const Contributions* source, const Columns& columns, const std::vector<double>& levels,
               double c_e, double level_step) {
        source_ = source;
        columns_ = &columns;
        if (!source) return;
        due_.clear();
        resolved_.clear();
        for (const double c : levels) {
            // f <= (C_E / C_d)^p: the contributions that may share cells as large as those of this level
            due_.push_back(float(std::pow(c_e / c, kPower)));
            // The next level would be finer than these contributions need.
            resolved_.push_back(float(std::pow(c_e / (c * level_step), kPower)));
        }
        // The finest level takes all that is left.
        due_.back() = kInfinity;
        by_light_.reset(2, columns.lights().count);
    }
    bool active() const { return source_ != nullptr; }
    /// Columns that are due for an eye point at a level, and columns that are resolved there even if
    /// neighbours disagree. A column of several lights has the contribution of the light whose ray is traced
    /// for it.
    void rows(uint32_t eye, size_t level, Word* due, Word* resolved) {
        const float shares[2] = {due_[level], resolved_[level]};
        Word* rows[2] = {due, resolved};
        if (!columns_->merged()) return source_->at_most(eye, shares, rows);
        Word* lights[2] = {by_light_.row(0), by_light_.row(1)};
        source_->at_most(eye, shares, lights);
        for (size_t i = 0; i < 2; ++i)
            for (uint32_t k = 0; k < columns_->count(); ++k) {
                const Word bit = Word{1} << (k % kWordBits);
                const bool set = get_bit(lights[i], columns_->light(eye, k));
                // The bit of a column that is not wanted may be anything; only set bits of queries are read.
                rows[i][k / kWordBits] = (rows[i][k / kWordBits] & ~bit) | (set ? bit : 0);
            }
    }

private:
    const Contributions* source_ = nullptr;
    const Columns* columns_ = nullptr;
    std::vector<float> due_, resolved_;  ///< by level, relative to the mean contribution
    BitMatrix by_light_;
};

}  // namespace viscache
