#pragma once
// Integer sums over pairs: they give the same bytes in any order of addition.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace viscache {

/// ρ is summed as round(2²⁰·ρ).
constexpr int kRhoBits = 20;
constexpr int64_t kRhoOne = int64_t{1} << kRhoBits;

/// Index of a pair of groups g <= h among all such pairs, row by row.
///
///       h  0  1  2        row g begins at g n − g (g − 1) / 2, and its first column is h = g:
///       0    0  1  2        hence g n − g (g + 1) / 2 + h
///       1       3  4
///       2          5
inline size_t group_pair(size_t g, size_t h, size_t n_groups) { return g * n_groups - g * (g + 1) / 2 + h; }
inline size_t group_pairs(size_t n_groups) { return n_groups * (n_groups + 1) / 2; }

/// The cells are indexed [pair of groups][distance][angle].
struct PairTable {
    PairTable() = default;
    PairTable(size_t n_groups, size_t n_distances, size_t n_angles)
        : n_pairs(group_pairs(n_groups)), n_distances(n_distances), n_angles(n_angles) {
        for (std::vector<int64_t>* v : {&n, &n_undefined, &sum_q, &sum_q2_high, &sum_q2_low})
            v->assign(n_pairs * n_distances * n_angles, 0);
    }
    size_t cell(size_t pair, size_t distance, size_t angle) const {
        return (pair * n_distances + distance) * n_angles + angle;
    }
    /// Adds `count` pairs with the sums Σq and Σq².
    void add(size_t cell, int64_t count, int64_t sum, uint64_t squares) {
        n[cell] += count;
        sum_q[cell] += sum;
        // 128 bits in two parts. The low one stays below 2³², so that both fit signed arrays of Python.
        const uint64_t low = uint64_t(sum_q2_low[cell]) + (squares & 0xffffffffu);
        sum_q2_low[cell] = int64_t(low & 0xffffffffu);
        sum_q2_high[cell] += int64_t((squares >> 32) + (low >> 32));
    }
    void add(const PairTable& other) {
        for (size_t c = 0; c < n.size(); ++c) {
            add(c, other.n[c], other.sum_q[c], uint64_t(other.sum_q2_low[c]));
            sum_q2_high[c] += other.sum_q2_high[c];
            n_undefined[c] += other.n_undefined[c];
        }
    }

    size_t n_pairs = 0, n_distances = 0, n_angles = 0;
    /// Number of pairs with ρ and without; Σq and Σq² = high·2³² + low, low < 2³², over those with ρ.
    std::vector<int64_t> n, n_undefined, sum_q, sum_q2_high, sum_q2_low;
};

}  // namespace viscache
