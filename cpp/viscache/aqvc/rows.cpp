#include "viscache/aqvc/rows.h"

#include <cstring>

#include "viscache/aqvc/nil_rule.h"

namespace viscache {

uint64_t Rows::run(const TileAnchors& tile, const TileOrder& order, uint32_t batch, const Columns& columns,
                   const std::vector<double>& levels, MissTracer& tracer, BitMatrix& visible,
                   Counters& counters, ClampCounts& clamps) {
    number_cells(tile, levels, clamps);
    counters.cells += numbers_.size();
    for (BitMatrix* m : {&known_, &value_, &pending_}) m->reset(numbers_.size() + 1, columns.count());
    words_ = known_.row_words();
    active_.reset(1, columns.count());
    uint64_t rays = 0;
    uint32_t first = 0;
    for (uint32_t end : run_ends(order, batch)) {
        entries_.clear();
        miss_.reset((end - first) * levels.size(), columns.count());
        for (; first < end; ++first) {
            const uint32_t eye = order.eye[first];
            if (!tile.usable[eye]) continue;
            std::memcpy(active_.row(0), columns.asked().row(eye), words_ * sizeof(Word));
            walk(eye, *tile.grid, visible, counters);
        }
        rays += commit(*tile.eyes, columns, tracer, visible, counters);
    }
    return rays;
}

/// Rows for all cells of all levels; neighbours that no eye point of the tile made are nil for ever.
void Rows::number_cells(const TileAnchors& tile, const std::vector<double>& levels, ClampCounts& clamps) {
    numbers_.clear(), steps_.clear(), steps_begin_.clear();
    std::vector<PlacedCell> placed;
    for (size_t i = 0; i < tile.size(); ++i) {
        steps_begin_.push_back(uint32_t(steps_.size()));
        if (!tile.usable[i]) continue;
        for (size_t d = 0; d < levels.size(); ++d) {
            const PlacedCell p = tile.cell(i, levels[d], clamps);
            if (d > 0 && p.cell == placed.back().cell) continue;
            steps_.push_back({numbers_.number(p.cell, 0), uint32_t(d), {}});
            placed.push_back(p);
        }
    }
    steps_begin_.push_back(uint32_t(steps_.size()));
    const uint32_t absent = uint32_t(numbers_.size());
    for (size_t i = 0; i < tile.size(); ++i)
        for (size_t s = steps_begin_[i]; s + 1 < steps_begin_[i + 1]; ++s)
            for (size_t q = 0; q < 4; ++q) {
                const auto [dx, dy] = kNeighbourOffsets[q];
                const uint32_t n = numbers_.find(tile.grid->neighbour(tile.anchor[i], placed[s], dx, dy), 0);
                steps_[s].neighbours[q] = n == kNoCell ? absent : n;
            }
}

/// One eye point down its levels: hits that agree are settled, misses become entries.
void Rows::walk(uint32_t eye, const CellGrid& grid, BitMatrix& visible, Counters& counters) {
    RowCounts counts;
    for (size_t s = steps_begin_[eye]; s < steps_begin_[eye + 1]; ++s) {
        const Step& step = steps_[s];
        const bool last = s + 1 == steps_begin_[eye + 1];
        RowPair neighbours[4] = {};
        if (!last)
            for (size_t q = 0; q < 4; ++q) neighbours[q] = row(step.neighbours[q]);
        if (!last && grid.doubts(numbers_[step.row]))
            doubt_unknown(row(step.row), neighbours, words_, doubt_);
        const int left = kernels_.step(active_.row(0), row(step.row), neighbours, last,
                                       miss_.row(entries_.size()), visible.row(eye), words_, counts);
        if (left & 1) entries_.push_back({eye, step.row, step.level});
        if (!(left & 2)) break;
        if (s + 2 == steps_begin_[eye + 1]) counts.boundary += kernels_.count(active_.row(0), words_);
    }
    counters.lookups += counts.lookups, counters.hits += counts.hits,
        counters.boundary_queries += counts.boundary;
}

/// Traces each missing bit once, for the first eye point of the batch that asked; then answers all who asked.
uint64_t Rows::commit(const EyeBlock& eyes, const Columns& columns, MissTracer& tracer, BitMatrix& visible,
                      Counters& counters) {
    uint64_t rays = 0;
    active_.reset(1, columns.count());
    for (size_t e = 0; e < entries_.size(); ++e) {
        const Entry& entry = entries_[e];
        const Word* miss = miss_.row(e);
        if (!kernels_.take_misses(miss, miss, pending_.row(entry.row), active_.row(0), words_)) continue;
        for_each_bit(active_.row_span(0), [&](size_t k) {
            tracer.add({entry.eye, entry.row, uint32_t(k), columns.light(entry.eye, uint32_t(k))});
            ++counters.rays_per_level[entry.level];
        });
        if (tracer.full()) rays += tracer.flush(eyes, columns.lights(), value_);
    }
    rays += tracer.flush(eyes, columns.lights(), value_);
    for (size_t e = 0; e < entries_.size(); ++e) {
        const Entry& entry = entries_[e];
        for (size_t w = 0; w < words_; ++w) {
            known_.row(entry.row)[w] |= miss_.row(e)[w];
            visible.row(entry.eye)[w] |= miss_.row(e)[w] & value_.row(entry.row)[w];
        }
    }
    return rays;
}

}  // namespace viscache
