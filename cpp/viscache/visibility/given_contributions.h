#pragma once
// Contributions that are given as an array.
#include <algorithm>
#include <span>

#include "viscache/visibility/oracle.h"

namespace viscache {

/// An array of rows × columns.
class GivenContributions final : public Contributions {
public:
    /// `row[i]` is the row of eye point i.
    GivenContributions(const float* f, size_t columns, std::span<const uint32_t> row)
        : f_(f), columns_(columns), row_(row) {}
    void at_most(uint32_t eye, std::span<const float> shares, std::span<Word* const> rows) const override {
        const std::span<const float> f(f_ + size_t(row_[eye]) * columns_, columns_);
        float sum = 0, positive = 0;
        for (const float v : f) {
            sum += v;
            positive += v > 0;
        }
        const float mean = sum / std::max(positive, 1.f);
        for (size_t i = 0; i < rows.size(); ++i)
            for (size_t k = 0; k < columns_; ++k) {
                const bool set = shares[i] == kInfinity || f[k] <= shares[i] * mean;
                set ? set_bit(rows[i], k) : clear_bit(rows[i], k);
            }
    }

private:
    const float* f_;
    size_t columns_;
    std::span<const uint32_t> row_;
};

}  // namespace viscache
