#pragma once
// Choosing a cell of a large grid with given probabilities.
#include "viscache/sampling/distribution.h"

namespace viscache {

/// A distribution that is piecewise constant over the cells of a grid. It keeps the running sum of a row
/// before every block of kBlock cells; within a block, samples add up the weights again. The weights are
/// far larger than the CPU caches, so `sample` takes many random numbers at once and prefetches what they
/// read.
class Distribution2D {
public:
    static constexpr size_t kBatch = 32;
    static constexpr size_t kBlock = 4;
    struct Cell {
        size_t row, column;
        float u_row, u_column;  ///< the random numbers, rescaled to [0, 1) for reuse
    };

    Distribution2D() = default;
    /// `weight(row, column)` gives the weights of rows × columns cells. Throws std::invalid_argument unless
    /// they are finite and >= 0 with a positive sum.
    template <class Weight>
    Distribution2D(size_t rows, size_t columns, Weight weight)
        : stride_((columns + kBlock - 1) / kBlock + 1), sums_(rows * stride_), guide_(rows * stride_) {
        std::vector<double> totals(rows);
        for (size_t y = 0; y < rows; ++y) {
            double* const sums = &sums_[y * stride_];
            double sum = 0;
            for (size_t x = 0; x < columns; ++x) {
                if (x % kBlock == 0) sums[x / kBlock] = sum;
                const double w = weight(y, x);
                if (!(w >= 0))
                    throw std::invalid_argument("weights must be finite and >= 0, got " + std::to_string(w));
                sum += w;
            }
            sums[stride_ - 1] = totals[y] = sum;
            fill_guide({sums, stride_}, {&guide_[y * stride_], stride_});
        }
        rows_ = Distribution1D(totals);
    }
    bool empty() const { return sums_.empty(); }
    size_t memory_bytes() const {
        return rows_.memory_bytes() + sums_.size() * (sizeof(double) + sizeof(uint32_t));
    }
    /// Samples cells from pairs (row, column) of random numbers in [0, 1), at most kBatch of them. Cells of
    /// weight zero are never returned. `block(row, column)` points to kBlock values side by side, whose
    /// weights are the constructor's, or zero behind the last column.
    template <class Numbers, class Block, class Weight>
    void sample(size_t n, Numbers numbers, Block block, Weight weight, Cell* cells) const {
        double second[kBatch];
        // Four passes over the batch, each of which reads what the one before has prefetched:
        //
        //     row of each cell     ->  guide of the row  ->  running sums  ->  weights of the block
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
            const SummedWeights blocks = line(cells[i].row);
            __builtin_prefetch(&blocks.sums[blocks.guide[blocks.guide_cell(second[i])]]);
        }
        for (size_t i = 0; i < n; ++i) {
            cells[i].column = line(cells[i].row).find(second[i]) * kBlock;
            const auto* values = block(cells[i].row, cells[i].column);
            __builtin_prefetch(values);
            __builtin_prefetch(values + kBlock - 1);
        }
        for (size_t i = 0; i < n; ++i) {
            Cell& c = cells[i];
            const SummedWeights blocks = line(c.row);
            const double total = blocks.total(), x = second[i] * total;
            // One of the block's sums is above x, or is the total if x was rounded up to it. Without
            // branches, which would be mispredicted
            const double most = x < total ? x : std::nextafter(total, 0.0);
            double sums[kBlock + 1] = {blocks.sums[c.column / kBlock]};
            // The block's weights are added again in the order of the constructor, so the sums are the same.
            const auto* values = block(c.row, c.column);
            size_t at = 0;
            for (size_t k = 0; k < kBlock; ++k) {
                sums[k + 1] = sums[k] + weight(values[k]);
                at += sums[k + 1] <= most;
            }
            c.column += at;
            c.u_column = SummedWeights::rescaled(x, sums[at], sums[at + 1] - sums[at]);
        }
    }

private:
    /// The blocks of a row.
    SummedWeights line(size_t row) const {
        return {{&sums_[row * stride_], stride_}, {&guide_[row * stride_], stride_}};
    }

    size_t stride_ = 0;
    Distribution1D rows_;
    std::vector<double> sums_;
    std::vector<uint32_t> guide_;
};

}  // namespace viscache
