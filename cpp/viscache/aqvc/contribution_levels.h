#pragma once
// C_E by contribution: a connection that carries little shares its bit with more eye samples.
//
// Beyond the paper, which sets C_E by group of lights. Let f be what a connection would carry to an eye point
// if nothing stood between, in means over the eye point's connections. It gets C_E·f^(−1/p): at a level of
// C_E = C_d all connections with f <= (C_E / C_d)^p are due, brighter ones wait for a finer level, and none
// is refined more than one level past the first at which it was due. The coarsest level is kLift·C_E.
#include <cmath>
#include <vector>

#include "viscache/aqvc/columns.h"

namespace viscache {

class ContributionLevels {
public:
    static constexpr double kPower =
        2.5;                            ///< p: brighter connections get cells as much finer as errors count
    static constexpr double kLift = 2;  ///< C_E of the coarsest level over that of the group

    /// Without a source every column is due at every level and refined to the finest.
    void begin(const Contributions* source, const Columns& columns, const std::vector<double>& levels,
               double c_e, double level_step) {
        source_ = source, columns_ = &columns;
        if (!source) return;
        due_.clear(), settled_.clear();
        for (const double c : levels) {
            due_.push_back(float(std::pow(c_e / c, kPower)));
            settled_.push_back(float(std::pow(c_e / (c * level_step), kPower)));
        }
        due_.back() = kInfinity;
        by_light_.reset(2, columns.lights().count);
    }
    bool active() const { return source_ != nullptr; }
    /// Columns that a level asks at an eye point (`due`), and those it settles even against its neighbours.
    /// A column that several lights share counts as the one that answers for it.
    void rows(uint32_t eye, size_t level, Word* due, Word* settled) {
        const float shares[2] = {due_[level], settled_[level]};
        Word* rows[2] = {due, settled};
        if (!columns_->merged()) return source_->at_most(eye, shares, rows);
        Word* lights[2] = {by_light_.row(0), by_light_.row(1)};
        source_->at_most(eye, shares, lights);
        for (size_t i = 0; i < 2; ++i)
            for (uint32_t k = 0; k < columns_->count(); ++k) {
                const Word bit = Word{1} << (k % kWordBits);
                const bool set = get_bit(lights[i], columns_->light(eye, k));
                rows[i][k / kWordBits] = (rows[i][k / kWordBits] & ~bit) | (set ? bit : 0);
            }
    }

private:
    const Contributions* source_ = nullptr;
    const Columns* columns_ = nullptr;
    std::vector<float> due_, settled_;  ///< by level, in means
    BitMatrix by_light_;
};

}  // namespace viscache
