#pragma once
// Choosing an index with given probabilities.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace viscache {

/// An index chosen by a random number.
struct Pick {
    size_t index;
    double pmf;
    float u;  ///< the random number, stretched back over [0, 1) for reuse
};

/// Weights summed up, with a guide into the sums. A view: tables of many rows keep theirs side by side.
struct SummedWeights {
    std::span<const double> sums;     ///< n + 1 running sums from 0
    std::span<const uint32_t> guide;  ///< n + 1 entries: first index whose sum exceeds j/n of the total

    size_t size() const { return sums.size() - 1; }
    double total() const { return sums.back(); }
    /// Where `sample(u)` begins to read.
    size_t guide_cell(double u) const { return std::min(size_t(u * double(size())), size() - 1); }
    /// Index with probability pmf, for u in [0, 1); never one of weight zero.
    Pick sample(double u) const {
        const double x = u * total();
        // The guide narrows the search to a few entries: one jump instead of a walk through a large table
        const size_t cell = guide_cell(u);
        auto first = sums.begin() + 1 + guide[cell];
        while (first[-1] > x) --first;  // u·n rounded up into the next cell
        const auto last = sums.begin() + 1 + std::min<size_t>(guide[cell + 1] + 1, size());
        auto above = std::upper_bound(first, last, x);
        if (above == last) above = std::upper_bound(last, sums.end(), x);
        // u·total rounded up to the total: the last index with weight
        if (above == sums.end()) above = std::lower_bound(sums.begin() + 1, sums.end(), total());
        const size_t i = size_t(above - sums.begin()) - 1;
        const double width = sums[i + 1] - sums[i];
        return {i, width / total(), std::min(float((x - sums[i]) / width), 0x1.fffffep-1f)};
    }
};

/// Sums up weights into sums[1 … n], and fills the guide (both n + 1 long). Weights must be finite and >= 0;
/// else std::invalid_argument. A total of zero leaves the guide unfilled.
inline void sum_weights(std::span<const double> weights, std::span<double> sums, std::span<uint32_t> guide) {
    const size_t n = weights.size();
    sums[0] = 0;
    for (size_t i = 0; i < n; ++i) {
        if (!(weights[i] >= 0) || !std::isfinite(weights[i]))
            throw std::invalid_argument("weights must be finite and >= 0, got " + std::to_string(weights[i]));
        sums[i + 1] = sums[i] + weights[i];
    }
    if (!(sums[n] > 0)) return;
    for (size_t j = 0, i = 0; j <= n; ++j) {
        while (i + 1 < n && sums[i + 1] <= sums[n] * (double(j) / double(n))) ++i;
        guide[j] = uint32_t(i);
    }
}

/// Piecewise constant over indices.
class Distribution1D {
public:
    Distribution1D() = default;
    /// Weights must be finite and >= 0 with a positive sum; else std::invalid_argument.
    explicit Distribution1D(std::span<const double> weights)
        : sums_(weights.size() + 1), guide_(weights.size() + 1) {
        sum_weights(weights, sums_, guide_);
        if (!(total() > 0) || !std::isfinite(total()))
            throw std::invalid_argument("weights must have a positive, finite sum, got " +
                                        std::to_string(total()));
    }
    size_t size() const { return sums_.empty() ? 0 : sums_.size() - 1; }
    double total() const { return sums_.empty() ? 0 : sums_.back(); }
    double pmf(size_t i) const { return (sums_[i + 1] - sums_[i]) / total(); }
    /// Index with probability pmf, for u in [0, 1); never one of weight zero.
    Pick sample(double u) const { return SummedWeights{sums_, guide_}.sample(u); }

private:
    std::vector<double> sums_;
    std::vector<uint32_t> guide_;
};

}  // namespace viscache
