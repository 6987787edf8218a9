#include "viscache/aqvc/rows.h"

#include <cstring>

#include "viscache/aqvc/nil_rule.h"

namespace viscache {

uint64_t Rows::run(const TileAnchors& tile, const TileOrder& order, uint32_t batch, const Columns& columns,
                   const std::vector<double>& levels, MissTracer& tracer, BitMatrix& visible,
                   Counters& counters, ClampCounts& clamps) {
    cells_.make(tile, levels, clamps);
    counters.cells += cells_.size();
    for (BitMatrix* m : {&known_, &value_, &pending_}) m->reset(cells_.size() + 1, columns.count());
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

/// One eye point down its levels: hits that agree are settled, misses become entries.
void Rows::walk(uint32_t eye, const CellGrid& grid, BitMatrix& visible, Counters& counters) {
    RowCounts counts;
    const std::span<const CellSteps::Step> steps = cells_.of(eye);
    for (size_t s = 0; s < steps.size(); ++s) {
        const CellSteps::Step& step = steps[s];
        const bool last = s + 1 == steps.size();
        RowPair neighbours[4] = {};
        if (!last)
            for (size_t q = 0; q < 4; ++q) neighbours[q] = row(step.neighbours[q]);
        if (!last && grid.doubts(cells_.cell(step.cell)))
            doubt_unknown(row(step.cell), neighbours, words_, doubt_);
        const int left = kernels_.step(active_.row(0), row(step.cell), neighbours, last,
                                       miss_.row(entries_.size()), visible.row(eye), words_, counts);
        if (left & 1) entries_.push_back({eye, step.cell, step.level});
        if (!(left & 2)) break;
        if (s + 2 == steps.size()) counts.boundary += kernels_.count(active_.row(0), words_);
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
