#pragma once
// Choosing a cell of a large grid with given probabilities.
#include "viscache/sampling/distribution.h"

namespace viscache {

/// A distribution that is piecewise constant over the cells of a grid. Its tables are far larger than the
/// CPU caches, so `sample` takes many random numbers at once and prefetches the entries they read.
class Distribution2D {
public:
    struct Cell {
        size_t row, column;
        float u_row, u_column;  ///< the random numbers, rescaled to [0, 1) for reuse
    };

    Distribution2D() = default;
    /// `weight(row, column)` gives the weights of rows × columns cells. Throws std::invalid_argument unless
    /// they are finite and >= 0 with a positive sum.
    template <class Weight>
    Distribution2D(size_t rows, size_t columns, Weight weight)
        : stride_(columns + 1), sums_(rows * stride_), guide_(rows * stride_) {
        std::vector<double> line(columns), totals(rows);
        for (size_t y = 0; y < rows; ++y) {
            for (size_t x = 0; x < columns; ++x) line[x] = weight(y, x);
            sum_weights(line, {&sums_[y * stride_], stride_}, {&guide_[y * stride_], stride_});
            totals[y] = sums_[y * stride_ + columns];
        }
        rows_ = Distribution1D(totals);
    }
    bool empty() const { return sums_.empty(); }
    size_t memory_bytes() const {
        return rows_.memory_bytes() + sums_.size() * (sizeof(double) + sizeof(uint32_t));
    }
    /// Samples cells from pairs (row, column) of random numbers in [0, 1), at most kBatch of them. Cells of
    /// weight zero are never returned.
    template <class Numbers>
    void sample(size_t n, Numbers numbers, Cell* cells) const {
        double second[kBatch];
        for (size_t i = 0; i < n; ++i) {
            const auto [first, u] = numbers(i);
            const Pick row = rows_.sample(first);
            cells[i].row = row.index;
            cells[i].u_row = row.u;
            second[i] = u;
            __builtin_prefetch(&guide_[row.index * stride_ + line(row.index).guide_cell(u)]);
            __builtin_prefetch(&sums_[(row.index + 1) * stride_ - 1]);
        }
        for (size_t i = 0; i < n; ++i) {
            const SummedWeights weights = line(cells[i].row);
            __builtin_prefetch(&weights.sums[weights.guide[weights.guide_cell(second[i])]]);
        }
        for (size_t i = 0; i < n; ++i) {
            const Pick column = line(cells[i].row).sample(second[i]);
            cells[i].column = column.index;
            cells[i].u_column = column.u;
        }
    }
    static constexpr size_t kBatch = 32;

private:
    SummedWeights line(size_t row) const {
        return {{&sums_[row * stride_], stride_}, {&guide_[row * stride_], stride_}};
    }

    size_t stride_ = 0;
    Distribution1D rows_;
    std::vector<double> sums_;
    std::vector<uint32_t> guide_;
};

}  // namespace viscache
