#include "viscache/aqvc/waves.h"

#include <cstring>

#include "viscache/aqvc/nil_rule.h"

namespace viscache {

uint64_t Waves::run(const TileAnchors& tile, const Columns& columns, const std::vector<double>& levels,
                    MissTracer& tracer, BitMatrix& visible, Counters& counters, ClampCounts& clamps) {
    eyes_ = tile.size(), levels_ = levels.size();
    number_cells(tile, levels, clamps);
    find_neighbours(tile, counters);
    const size_t cells = numbers_.size();
    counters.cells += cells;
    for (BitMatrix* m : {&known_, &value_, &need_}) m->reset(cells + 1, columns.count());
    miss_.reset(cells, columns.count());
    disagree_.reset(level_begin_[levels_ - 1], columns.count());
    active_.reset(eyes_, columns.count());
    words_ = active_.row_words();
    for (size_t i = 0; i < eyes_; ++i)
        if (tile.usable[i]) std::memcpy(active_.row(i), columns.asked().row(i), words_ * sizeof(Word));

    uint64_t rays = 0;
    for (size_t d = 0; d < levels_; ++d) {
        const uint64_t traced = trace_level(d, *tile.eyes, columns, tracer);
        counters.rays_per_level[d] += traced, rays += traced;
        if (d + 1 == levels_) break;
        write_down(d);
        settle_level(d, *tile.grid, visible, counters);
    }
    return rays + finish(*tile.eyes, columns, tracer, visible, counters);
}

/// Cells get numbers level by level, in order of first touch along the eye points. An eye point whose ladder
/// resolution did not change keeps the cell of the level before.
void Waves::number_cells(const TileAnchors& tile, const std::vector<double>& levels, ClampCounts& clamps) {
    numbers_.clear();
    representative_.clear();
    level_begin_.assign(1, 0);
    cell_.assign(levels_ * eyes_, kNoCell);
    for (size_t d = 0; d < levels_; ++d) {
        Cell last_cell;
        uint32_t last = kNoCell;
        for (uint32_t i = 0; i < eyes_; ++i) {
            if (!tile.usable[i]) continue;
            uint32_t& number = cell_[d * eyes_ + i];
            const PlacedCell placed = tile.cell(i, levels[d], clamps);
            if (d > 0 && numbers_[cell_of(d - 1, i)] == placed.cell) {
                number = cell_of(d - 1, i);
                continue;
            }
            // Neighbours along the Morton order mostly share their cell.
            if (last == kNoCell || !(placed.cell == last_cell))
                last = numbers_.number(placed.cell, uint32_t(d));
            last_cell = placed.cell;
            number = last;
            offer_representative(number, i, d, placed);
        }
        level_begin_.push_back(uint32_t(numbers_.size()));
    }
}

/// Keeps the eye point nearest the centre; one that stands for a coarser cell already comes before all that
/// do not.
void Waves::offer_representative(uint32_t cell, uint32_t eye, size_t level, const PlacedCell& placed) {
    bool coarser = false;
    for (size_t d = 0; d < level && !coarser; ++d) coarser = representative_[cell_of(d, eye)].eye == eye;
    const Representative candidate{eye, coarser, distance2_to_center(placed), placed};
    if (cell == representative_.size()) {
        representative_.push_back(candidate);
        return;
    }
    Representative& r = representative_[cell];
    if (coarser != r.coarser ? coarser : candidate.distance2 < r.distance2) r = candidate;
}

void Waves::find_neighbours(const TileAnchors& tile, Counters& counters) {
    neighbours_.resize(level_begin_[levels_ - 1]);
    const uint32_t absent = uint32_t(numbers_.size());
    for (size_t d = 0; d + 1 < levels_; ++d)
        for (uint32_t c = level_begin_[d]; c < level_begin_[d + 1]; ++c) {
            const Representative& r = representative_[c];
            const Anchor& anchor = tile.anchor[r.eye];
            for (size_t q = 0; q < 4; ++q) {
                const auto [dx, dy] = kNeighbourOffsets[q];
                uint32_t n = numbers_.find(tile.grid->neighbour(anchor, r.placed, dx, dy), uint32_t(d));
                if (n == kNoCell)
                    n = numbers_.find(tile.grid->neighbour(anchor, r.placed, dx, dy, true), uint32_t(d));
                neighbours_[c][q] = n == kNoCell ? absent : n;
                counters.nil_neighbours += n == kNoCell;
            }
            counters.neighbour_probes += 4;
        }
}

/// Traces what is wanted of a level's cells, wanted by their representatives and unknown. Level 0 wants
/// everything.
uint64_t Waves::trace_level(size_t level, const EyeBlock& eyes, const Columns& columns, MissTracer& tracer) {
    uint64_t rays = 0;
    for (uint32_t c = level_begin_[level]; c < level_begin_[level + 1]; ++c) {
        const uint32_t eye = representative_[c].eye;
        const Word* active = columns.asked().row(eye);
        const Word* need = level == 0 ? active : need_.row(c);
        if (!kernels_.take_misses(need, active, known_.row(c), miss_.row(c), words_)) continue;
        for_each_bit(std::span<const Word>(miss_.row(c), words_),
                     [&](size_t k) { tracer.add({eye, c, uint32_t(k), columns.light(eye, uint32_t(k))}); });
        if (tracer.full()) rays += tracer.flush(eyes, columns.lights(), value_);
    }
    return rays + tracer.flush(eyes, columns.lights(), value_);
}

void Waves::write_down(size_t level) {
    for (uint32_t c = level_begin_[level]; c < level_begin_[level + 1]; ++c)
        for (size_t below = level + 1; below < levels_; ++below) {
            const uint32_t finer = cell_of(below, representative_[c].eye);
            if (finer != c)
                kernels_.write_down(miss_.row(c), value_.row(c), known_.row(finer), value_.row(finer),
                                    words_);
        }
}

void Waves::settle_level(size_t level, const CellGrid& grid, BitMatrix& visible, Counters& counters) {
    for (uint32_t c = level_begin_[level]; c < level_begin_[level + 1]; ++c) {
        RowPair neighbours[4];
        for (size_t q = 0; q < 4; ++q) neighbours[q] = row(neighbours_[c][q]);
        if (grid.doubts(numbers_[c])) doubt_unknown(row(c), neighbours, words_, doubt_);
        kernels_.disagreement(row(c), neighbours, disagree_.row(c), words_);
    }
    RowCounts counts, repeated;
    for (size_t i = 0; i < eyes_; ++i) {
        const uint32_t c = cell_of(level, i);
        if (c == kNoCell) continue;
        // A cell kept from the level before has settled all it can; only the wish is handed on.
        const bool again = c < level_begin_[level], last_above = level + 2 == levels_;
        const uint32_t next = cell_of(level + 1, i);
        if (next == c && again) continue;
        kernels_.settle(active_.row(i), row(c), disagree_.row(c), visible.row(i), need_.row(next), words_,
                        last_above, again ? repeated : counts);
    }
    counters.lookups += counts.lookups, counters.hits += counts.hits,
        counters.boundary_queries += counts.boundary;
}

uint64_t Waves::finish(const EyeBlock& eyes, const Columns& columns, MissTracer& tracer, BitMatrix& visible,
                       Counters& counters) {
    RowCounts counts;
    uint64_t rays = 0;
    for (uint32_t i = 0; i < eyes_; ++i) {
        const uint32_t c = cell_of(levels_ - 1, i);
        if (c == kNoCell || !kernels_.finish(active_.row(i), row(c), visible.row(i), words_, counts))
            continue;
        for_each_bit(active_.row_span(i),
                     [&](size_t k) { tracer.add({i, i, uint32_t(k), columns.light(i, uint32_t(k))}); });
        if (tracer.full()) rays += tracer.flush(eyes, columns.lights(), visible);
    }
    rays += tracer.flush(eyes, columns.lights(), visible);
    counters.leftover_rays += rays;
    counters.lookups += counts.lookups, counters.hits += counts.hits;
    return rays;
}

}  // namespace viscache
