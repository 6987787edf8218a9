#pragma once
// Discrete distributions: choosing an index with given probabilities.
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
    float u;  ///< the random number, rescaled to [0, 1) for reuse
};

/// Running sums of weights, with a guide table into them. This is a view: tables of many rows store their
/// rows side by side.
struct SummedWeights {
    std::span<const double> sums;  ///< n + 1 running sums from 0
    std::span<const uint32_t>
        guide;  ///< n + 1 entries; entry j is the first index whose sum exceeds j/n of the total

    size_t size() const { return sums.size() - 1; }
    double total() const { return sums.back(); }
    /// First guide entry that `sample(u)` reads.
    size_t guide_cell(double u) const { return std::min(size_t(u * double(size())), size() - 1); }
    /// The index that u in [0, 1) chooses. Indices of weight zero are never returned.
    ///
    ///     sums   0 .... s1 . s2 ......... s3 .. total       u·total lies between two sums: the index
    ///     guide  |    0    |    1    |    2    |             n equal parts of [0, total): where to begin
    size_t find(double u) const {
        const double x = u * total();
        // The guide narrows the search to a few entries: one lookup replaces a walk through a large table
        const size_t cell = guide_cell(u);
        auto first = sums.begin() + 1 + guide[cell];
        while (first[-1] > x) --first;  // for u·n that was rounded up into the next cell
        const auto last = sums.begin() + 1 + std::min<size_t>(guide[cell + 1] + 1, size());
        auto above = std::upper_bound(first, last, x);
        if (above == last) above = std::upper_bound(last, sums.end(), x);
        // u·total was rounded up to the total: take the last index with positive weight
        if (above == sums.end()) above = std::lower_bound(sums.begin() + 1, sums.end(), total());
        return size_t(above - sums.begin()) - 1;
    }
    /// Samples an index with probability pmf.
    Pick sample(double u) const {
        const size_t i = find(u);
        const double width = sums[i + 1] - sums[i];
        return {i, width / total(), rescaled(u * total(), sums[i], width)};
    }
    /// Where x lies in the interval of a width from `below`, in [0, 1).
    static float rescaled(double x, double below, double width) {
        return std::min(float((x - below) / width), 0x1.fffffep-1f);
    }
};

/// Fills the guide of running sums. It stays unfilled when their total is zero.
inline void fill_guide(std::span<const double> sums, std::span<uint32_t> guide) {
    const size_t n = sums.size() - 1;
    if (!(sums[n] > 0)) return;
    // Both indices only rise: one pass over both.
    for (size_t j = 0, i = 0; j <= n; ++j) {
        while (i + 1 < n && sums[i + 1] <= sums[n] * (double(j) / double(n))) ++i;
        guide[j] = uint32_t(i);
    }
}

/// A distribution that is piecewise constant over indices.
class Distribution1D {
public:
    Distribution1D() = default;
    /// Throws std::invalid_argument unless the weights are finite and >= 0 with a positive sum.
    explicit Distribution1D(std::span<const double> weights)
        : sums_(weights.size() + 1), guide_(weights.size() + 1) {
        for (size_t i = 0; i < weights.size(); ++i) {
            if (!(weights[i] >= 0) || !std::isfinite(weights[i]))
                throw std::invalid_argument("weights must be finite and >= 0, got " +
                                            std::to_string(weights[i]));
            sums_[i + 1] = sums_[i] + weights[i];
        }
        fill_guide(sums_, guide_);
        if (!(total() > 0) || !std::isfinite(total()))
            throw std::invalid_argument("weights must have a positive, finite sum, got " +
                                        std::to_string(total()));
    }
    size_t size() const { return sums_.empty() ? 0 : sums_.size() - 1; }
    double total() const { return sums_.empty() ? 0 : sums_.back(); }
    size_t memory_bytes() const { return sums_.size() * (sizeof(double) + sizeof(uint32_t)); }
    double pmf(size_t i) const { return (sums_[i + 1] - sums_[i]) / total(); }
    /// Samples an index with probability pmf, for u in [0, 1). Indices of weight zero are never returned.
    Pick sample(double u) const { return SummedWeights{sums_, guide_}.sample(u); }

private:
    std::vector<double> sums_;
    std::vector<uint32_t> guide_;
};

}  // namespace viscache
