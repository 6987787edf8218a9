#include "viscache/aqvc/waves.h"

#include <cstring>

namespace viscache {

template <class Answer>
auto Waves::noted(uint32_t eye, uint32_t cell, size_t level, Answer answer) {
    if (!log_) return answer();
    // What the answer takes out of `active_` has been answered by this cell.
    before_.assign(active_.row(eye), active_.row(eye) + words_);
    const auto result = answer();
    for (size_t w = 0; w < words_; ++w) before_[w] &= ~active_.row(eye)[w];
    note(eye, cell, level, before_);
    return result;
}

/// Notes that a cell answered these bits of an eye point. Later notes replace earlier ones.
void Waves::note(uint32_t eye, uint32_t cell, size_t level, std::span<const Word> bits) {
    for_each_bit(bits, [&](size_t k) { answered_[eye * columns_->count() + k] = {cell, uint8_t(level)}; });
}

void Waves::write_log(const Columns& columns) const {
    for (uint32_t eye = 0; eye < eyes_; ++eye)
        for (uint32_t k = 0; k < columns.count(); ++k) {
            const Answered a = answered_[eye * columns.count() + k];
            if (a.cell == kNoCell) continue;
            // A cell and a column are a cluster.
            const uint64_t cluster = uint64_t(a.cell) * columns.count() + k;
            const uint32_t representative = traced_by_[cluster];
            columns.for_each_light(eye, k, [&](uint32_t light) {
                // The light whose ray was traced, at the eye point that traced it, has its own answer.
                const bool own = representative == eye && columns.light(eye, k) == light;
                log_->answered(eye, light, {cluster, representative, a.level, own});
            });
        }
}

uint64_t Waves::run(const TileAnchors& tile, const TileCells& tile_cells, const Columns& columns,
                    ContributionLevels& contribution_levels, MissTracer& tracer, KeptRows* kept,
                    BitMatrix& visible, Counters& counters, QueryLog* log) {
    columns_ = &columns;
    log_ = log;
    if (log_) {
        // Arrays of eye points × columns: only for a log.
        traced_by_.assign(tile_cells.size() * columns.count(), 0);
        answered_.assign(tile.size() * columns.count(), {});
    }
    contribution_levels_ = &contribution_levels;
    cells_ = &tile_cells;
    eyes_ = tile.size();
    levels_ = tile_cells.levels();
    const size_t cells = tile_cells.size();
    counters.cells += cells;
    counters.nil_neighbours += tile_cells.nil_neighbours;
    counters.neighbour_probes += 4 * tile_cells.begin(levels_ - 1);
    // Row `cells` stays zero: it stands for neighbours without eye points, which know nothing.
    for (BitMatrix* m : {&known_, &value_, &need_}) m->reset(cells + 1, columns.count());
    if (kept) kept->load(tile_cells, known_, value_);
    miss_.reset(cells, columns.count());
    disagree_.reset(cells_->begin(levels_ - 1), columns.count());
    if (contribution_levels.active()) {
        resolved_.reset(cells, columns.count());
        due_.reset(1, columns.count());
    }
    active_.reset(eyes_, columns.count());
    finest_.reset(levels_ > 1 ? eyes_ : 0, columns.count());
    words_ = active_.row_words();
    for (size_t i = 0; i < eyes_; ++i)
        // Unusable eye points have no active bits; their queries bypass the cache.
        if (tile.usable[i]) std::memcpy(active_.row(i), columns.queries().row(i), words_ * sizeof(Word));

    uint64_t rays = 0;
    for (size_t d = 0; d < levels_; ++d) {
        const uint64_t traced = trace_level(d, *tile.eyes, columns, tracer);
        counters.rays_per_level[d] += traced;
        rays += traced;
        adopt_own(d, visible, counters);
        if (d + 1 == levels_) break;
        store_below(d);
        resolve_level(d, visible, counters);
        // What is still active now is answered only by the finest cells.
        if (d + 2 == levels_) std::memcpy(finest_.row(0), active_.row(0), eyes_ * words_ * sizeof(Word));
    }
    rays += finish(*tile.eyes, columns, tracer, visible, counters);
    if (log_) write_log(columns);
    return rays;
}

/// Traces the bits of the cells of a level that are needed, wanted by the representatives and unknown. At
/// level 0 all bits are needed.
uint64_t Waves::trace_level(size_t level, const EyeBlock& eyes, const Columns& columns, MissTracer& tracer) {
    uint64_t rays = 0;
    for (uint32_t c = cells_->begin(level); c < cells_->begin(level + 1); ++c) {
        const uint32_t eye = cells_->representative(c);
        const Word* active = columns.queries().row(eye);
        // Nothing is known before level 0, so everything wanted there is needed.
        const Word* need = level == 0 ? active : need_.row(c);
        if (contribution_levels_->active()) {
            // Dim connections are due at coarse levels, bright ones only where cells are small.
            contribution_levels_->rows(eye, level, due_.row(0), resolved_.row(c));
            kernels_.keep(due_.row(0), active, words_);
            active = due_.row(0);
        }
        // `take_misses` marks the bits as known; `flush` writes their values before anybody reads them.
        if (!kernels_.take_misses(need, active, known_.row(c), miss_.row(c), words_)) continue;
        for_each_bit(std::span<const Word>(miss_.row(c), words_), [&](size_t k) {
            tracer.add({eye, c, uint32_t(k), columns.light(eye, uint32_t(k))});
            if (log_) traced_by_[size_t(c) * columns.count() + k] = eye;
        });
        if (tracer.full()) rays += tracer.flush(eyes, columns.lights(), value_);
    }
    return rays + tracer.flush(eyes, columns.lights(), value_);
}

/// An eye point whose ray was traced for a cell takes that answer.
// Differs (A51): in Alg. 2 an eye point that agreed with its neighbours at a coarser level keeps the coarser
// cell's value, though its own ray may be traced later for others and tell better.
void Waves::adopt_own(size_t level, BitMatrix& visible, Counters& counters) {
    RowCounts counts;
    for (uint32_t c = cells_->begin(level); c < cells_->begin(level + 1); ++c) {
        const uint32_t eye = cells_->representative(c);
        kernels_.adopt(active_.row(eye), miss_.row(c), value_.row(c), visible.row(eye), words_, counts);
        if (log_) note(eye, c, level, {miss_.row(c), words_});
    }
    counters.lookups += counts.lookups;
    counters.hits += counts.hits;
}

void Waves::store_below(size_t level) {
    for (uint32_t c = cells_->begin(level); c < cells_->begin(level + 1); ++c)
        for (size_t below = level + 1; below < levels_; ++below) {
            // Exact at every level, since the ray is the eye point's own.
            const uint32_t finer = cells_->of(below, cells_->representative(c));
            // The same cell: the ladder did not move.
            if (finer == c) continue;
            if (log_)
                for_each_bit(std::span<const Word>(miss_.row(c), words_), [&](size_t k) {
                    if (!known_.get(finer, k))
                        traced_by_[size_t(finer) * columns_->count() + k] = cells_->representative(c);
                });
            kernels_.store_below(miss_.row(c), value_.row(c), known_.row(finer), value_.row(finer), words_);
        }
}

void Waves::resolve_level(size_t level, BitMatrix& visible, Counters& counters) {
    for (uint32_t c = cells_->begin(level); c < cells_->begin(level + 1); ++c) {
        RowPair neighbours[4];
        for (size_t q = 0; q < 4; ++q) neighbours[q] = row(cells_->neighbours(c)[q]);
        kernels_.disagreement(row(c), neighbours, disagree_.row(c), words_);
        // Dim enough for cells of this size: neighbours may disagree.
        if (contribution_levels_->active())
            kernels_.drop(disagree_.row(c), known_.row(c), resolved_.row(c), words_);
    }
    RowCounts counts, repeated;
    for (size_t i = 0; i < eyes_; ++i) {
        const uint32_t c = cells_->of(level, i);
        if (c == kNoCell) continue;
        // A cell of the level before is already resolved; only the remaining bits are passed on.
        const bool again = c < cells_->begin(level), last_above = level + 2 == levels_;
        // Bits that stay open are needed by the next cell of the eye point.
        const uint32_t next = cells_->of(level + 1, i);
        // Same cell and seen before: nothing has changed.
        if (next == c && again) continue;
        noted(uint32_t(i), c, level, [&] {
            kernels_.resolve(active_.row(i), row(c), disagree_.row(c), visible.row(i), need_.row(next),
                             words_, last_above, again ? repeated : counts);
            return true;
        });
    }
    counters.lookups += counts.lookups;
    counters.hits += counts.hits;
    counters.boundary_queries += counts.boundary;
}

/// For each cell, the first eye point that wants a bit traces its ray; the others share the answer.
uint64_t Waves::finish(const EyeBlock& eyes, const Columns& columns, MissTracer& tracer, BitMatrix& visible,
                       Counters& counters) {
    RowCounts counts;
    uint64_t rays = 0;
    // Eye points with bits that nobody has traced
    std::vector<uint32_t> left;
    for (uint32_t i = 0; i < eyes_; ++i) {
        const uint32_t c = cells_->of(levels_ - 1, i);
        const auto finish_row = [&] {
            return kernels_.finish(active_.row(i), row(c), visible.row(i), words_, counts);
        };
        if (c == kNoCell || !noted(i, c, levels_ - 1, finish_row)) continue;
        left.push_back(i);
        for_each_bit(active_.row_span(i), [&](size_t k) {
            // An earlier eye point traces it.
            if (miss_.get(c, k)) return;
            miss_.set(c, k);
            if (log_) traced_by_[size_t(c) * columns.count() + k] = i;
            tracer.add({i, c, uint32_t(k), columns.light(i, uint32_t(k))});
        });
        if (tracer.full()) rays += tracer.flush(eyes, columns.lights(), value_);
    }
    rays += tracer.flush(eyes, columns.lights(), value_);
    RowCounts again;
    // The second look finds what the rays have brought.
    for (const uint32_t i : left) {
        const uint32_t c = cells_->of(levels_ - 1, i);
        for (size_t w = 0; w < words_; ++w) known_.row(c)[w] |= miss_.row(c)[w];
        noted(i, c, levels_ - 1,
              [&] { return kernels_.finish(active_.row(i), row(c), visible.row(i), words_, again); });
    }
    counters.leftover_rays += rays;
    counters.lookups += counts.lookups;
    counters.hits += counts.hits;
    return rays;
}

}  // namespace viscache
