#pragma once
// Contributions that are given as an array.
#include <algorithm>
#include <span>

#include "viscache/visibility/oracle.h"
#include "viscache/visibility/reference_light.h"

namespace viscache {

/// An array of rows × columns.
class GivenContributions final : public Contributions {
public:
    /// `row[i]` is the row of eye point i. `mean_light`: mean over the eye points of the sums of their rows;
    /// 0: not known.
    GivenContributions(const float* f, size_t columns, std::span<const uint32_t> row, float mean_light = 0)
        : f_(f), columns_(columns), row_(row), mean_light_(mean_light) {}
    void at_most(uint32_t eye, std::span<const float> shares, std::span<Word* const> rows) const override {
        const std::span<const float> f = row_of(eye);
        const float mean = mean_of(f);
        for (size_t i = 0; i < rows.size(); ++i)
            for (size_t k = 0; k < columns_; ++k) {
                const bool set = shares[i] == kInfinity || f[k] <= shares[i] * mean;
                set ? set_bit(rows[i], k) : clear_bit(rows[i], k);
            }
    }

    float reference(uint32_t eye, const Word* seen) const override {
        const std::span<const float> f = row_of(eye);
        const float mean = mean_of(f);
        if (!(mean > 0 && mean_light_ > 0)) return 0;
        float light = 0;
        for (size_t k = 0; k < columns_; ++k)
            if (get_bit(seen, k)) light += f[k];
        float all = 0;
        for (const float v : f) all += v;
        return reference_light(light, all, mean_light_) / mean;
    }

private:
    std::span<const float> row_of(uint32_t eye) const {
        return {f_ + size_t(row_[eye]) * columns_, columns_};
    }
    /// Of the positive ones.
    static float mean_of(std::span<const float> f) {
        float sum = 0, positive = 0;
        for (const float v : f) {
            sum += v;
            positive += v > 0;
        }
        return sum / std::max(positive, 1.f);
    }

    const float* f_;
    size_t columns_;
    std::span<const uint32_t> row_;
    float mean_light_;
};

}  // namespace viscache
