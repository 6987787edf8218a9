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

/// Piecewise constant over indices.
class Distribution1D {
public:
    struct Pick {
        size_t index;
        double pmf;
        float u;  ///< the random number, stretched back over [0, 1) for reuse
    };

    Distribution1D() = default;
    /// Weights must be finite and >= 0 with a positive sum; else std::invalid_argument.
    explicit Distribution1D(std::span<const double> weights) {
        cumulative_.reserve(weights.size() + 1);
        cumulative_.push_back(0);
        for (double w : weights) {
            if (!(w >= 0) || !std::isfinite(w))
                throw std::invalid_argument("weights must be finite and >= 0, got " + std::to_string(w));
            cumulative_.push_back(cumulative_.back() + w);
        }
        if (!(total() > 0) || !std::isfinite(total()))
            throw std::invalid_argument("weights must have a positive, finite sum, got " +
                                        std::to_string(total()));
        // guide_[j] = first index whose cumulative weight exceeds j/n of the total
        const size_t n = size();
        guide_.resize(n + 1);
        for (size_t j = 0, i = 0; j <= n; ++j) {
            while (i + 1 < n && cumulative_[i + 1] <= total() * (double(j) / double(n))) ++i;
            guide_[j] = uint32_t(i);
        }
    }
    size_t size() const { return cumulative_.empty() ? 0 : cumulative_.size() - 1; }
    double total() const { return cumulative_.empty() ? 0 : cumulative_.back(); }
    double pmf(size_t i) const { return (cumulative_[i + 1] - cumulative_[i]) / total(); }
    /// Index with probability pmf, for u in [0, 1); never one of weight zero.
    Pick sample(double u) const {
        const double x = u * total();
        // The guide narrows the search to a few entries: one jump instead of a walk through a large table
        const size_t cell = std::min(size_t(u * double(guide_.size() - 1)), guide_.size() - 2);
        auto first = cumulative_.begin() + 1 + guide_[cell];
        while (first[-1] > x) --first;  // u·n rounded up into the next cell
        const auto last = cumulative_.begin() + 1 + std::min<size_t>(guide_[cell + 1] + 1, size());
        auto above = std::upper_bound(first, last, x);
        if (above == last) above = std::upper_bound(last, cumulative_.end(), x);
        // u·total rounded up to the total: the last index with weight
        if (above == cumulative_.end())
            above = std::lower_bound(cumulative_.begin() + 1, cumulative_.end(), total());
        const size_t i = size_t(above - cumulative_.begin()) - 1;
        const double width = cumulative_[i + 1] - cumulative_[i];
        return {i, width / total(), std::min(float((x - cumulative_[i]) / width), 0x1.fffffep-1f)};
    }

private:
    std::vector<double> cumulative_;
    std::vector<uint32_t> guide_;
};

}  // namespace viscache
