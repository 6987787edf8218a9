#pragma once
// Rows of bits of many points, block by block of neighbours in space.
#include <algorithm>
#include <atomic>
#include <cstring>
#include <span>

#include "viscache/math/bits.h"
#include "viscache/math/morton.h"
#include "viscache/math/parallel.h"
#include "viscache/math/vec.h"

namespace viscache {

/// Calls rows_of(points, thread) for blocks of `per_block` points along a Morton curve, and copies row i of
/// the matrix that it returns to the row of points[i]; rows have `words` words. `done` counts finished
/// points.
template <class RowsOf>
void in_row_blocks(std::span<const Vec3> position, size_t per_block, size_t words, std::span<Word> rows,
                   int threads, const Control& control, std::atomic<uint64_t>* done, RowsOf rows_of) {
    const size_t n = position.size();
    // Spatial neighbours share packets, regardless of the order of the rows
    const std::vector<uint32_t> along = morton_order(position);
    parallel_for((n + per_block - 1) / per_block, threads, [&](size_t block, int t) {
        control.check();
        const size_t first = block * per_block, count = std::min(per_block, n - first);
        const auto points = std::span(along).subspan(first, count);
        const BitMatrix& found = rows_of(points, t);
        for (size_t i = 0; i < count; ++i)
            std::memcpy(&rows[points[i] * words], found.row(i), words * sizeof(Word));
        if (done) *done += count;
    });
}

}  // namespace viscache
