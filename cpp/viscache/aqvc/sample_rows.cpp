#include "viscache/aqvc/sample_rows.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

namespace viscache {

void SampleRows::begin(const TileAnchors& tile, const std::vector<double>& levels, uint32_t batch,
                       uint64_t row_bytes, Counters& counters, ClampCounts& clamps) {
    tile_ = &tile;
    cells_.make(tile, levels, clamps);
    counters.cells += cells_.size();
    make_order(tile, batch);
    // Three matrices, with one row more than cells: the row of neighbours without eye points, always nil.
    const size_t slab_bytes = (cells_.size() + 1) * kSlabWords * sizeof(Word) * 3;
    // At least one slab, and not more columns than numbers allow
    const size_t most = std::clamp<size_t>(row_bytes / slab_bytes, 1, size_t{1} << 20);
    light_cells_.clear(uint32_t(most * kSlabColumns));
    slabs_used_ = 0;
}

void SampleRows::make_order(const TileAnchors& tile, uint32_t batch) {
    const uint32_t n = uint32_t(tile.size());
    // Rounds in the order of distance: whatever its columns, an eye point near the centre is a good
    // representative.
    // Sort eye points by cell and then by distance to the centre of the cell
    const auto cell = [&](uint32_t i) { return tile.usable[i] ? cells_.of(i)[0].cell : kNoCell; };
    const auto distance2 = [&](uint32_t i) { return tile.usable[i] ? cells_.of(i)[0].distance2 : 0.f; };
    std::vector<uint32_t> by_cell(n), round(n);
    std::iota(by_cell.begin(), by_cell.end(), 0u);
    std::sort(by_cell.begin(), by_cell.end(), [&](uint32_t a, uint32_t b) {
        if (cell(a) != cell(b)) return cell(a) < cell(b);
        return distance2(a) != distance2(b) ? distance2(a) < distance2(b) : a < b;
    });
    for (uint32_t k = 0, rank = 0; k < n; ++k) {
        rank = k > 0 && cell(by_cell[k]) == cell(by_cell[k - 1]) ? rank + 1 : 0;
        // Ranks 0, 1, 2–3, 4–7, ...: each round has as many eye points of a cell as all before it.
        round[by_cell[k]] = uint32_t(std::bit_width(rank));
    }
    order_.clear();
    run_end_.clear();
    run_of_eye_.resize(n);
    for (uint32_t r = 0; order_.size() < n; ++r) {
        const size_t first = order_.size();
        // Inside a round in the order of the tile, so that successive eye points are neighbours
        for (uint32_t i = 0; i < n; ++i)
            if (round[i] == r) order_.push_back(i);
        for (size_t end = first; end < order_.size(); run_end_.push_back(uint32_t(end)))
            end = std::min(order_.size(), end + std::max(1u, batch));
    }
    for (uint32_t run = 0, k = 0; run < run_end_.size(); ++run)
        for (; k < run_end_[run]; ++k) run_of_eye_[order_[k]] = run;
}

void SampleRows::grow(size_t slabs) {
    // Slabs are reset when columns first need them; most tiles use few.
    if (slabs_.size() < slabs) slabs_.resize(slabs);
    for (; slabs_used_ < slabs; ++slabs_used_)
        for (BitMatrix Slab::* m : {&Slab::known, &Slab::value, &Slab::pending})
            (slabs_[slabs_used_].*m).reset(cells_.size() + 1, kSlabColumns);
}

uint64_t SampleRows::run(const LocalSamples& samples, const AqvcParameters& p, std::span<Word> visible,
                         std::vector<uint32_t>& left, Counters& counters, ClampCounts& clamps) {
    light_cells_.number(samples, *tile_->grid, p, column_, clamps);
    // New light cells may need another slab.
    grow((light_cells_.count() + kSlabColumns - 1) / kSlabColumns);
    const size_t rows = samples.eye.size(), columns = slabs_used_ * kSlabColumns;
    active_.reset(rows, columns);
    seen_.reset(rows, columns);
    fresh_.reset(1, columns);
    waiting_.clear();
    rays_.clear();
    left.clear();
    for (size_t row = 0; row < rows; ++row) {
        if (control_ && row % 256 == 0) control_->check();
        look_up(samples, row, left, counters);
    }
    trace(samples, visible);
    // All rays are back: the missing bits are known now, and those who waited take them.
    for (const Waiting& w : waiting_) {
        const Slab& slab = slabs_[w.slab];
        Word* known = slabs_[w.slab].known.row(w.cell);
        Word* seen = seen_.row(w.row) + w.slab * kSlabWords;
        for (size_t k = 0; k < kSlabWords; ++k) {
            known[k] |= w.miss[k];
            seen[k] |= w.miss[k] & slab.value.row(w.cell)[k];
        }
    }
    for (size_t row = 0; row < rows; ++row) answer(samples, row, visible);
    return rays_.size();
}

/// Gathers the columns of an eye point and walks down its levels with them. A sample without a key is traced
/// on its own; one that is not finite stays invisible.
void SampleRows::look_up(const LocalSamples& samples, size_t row, std::vector<uint32_t>& left,
                         Counters& counters) {
    const uint32_t eye = samples.eye[row];
    Word* active = active_.row(row);
    const bool usable = tile_->usable[eye];
    for (size_t i = samples.begin_of(row); i < samples.end[row]; ++i) {
        const bool traceable = is_traceable(samples.target(i)) && is_traceable(tile_->eyes->origin[eye]);
        // Numbers below kFull are columns.
        if (usable && traceable && column_[i] < LightCells::kFull) {
            set_bit(active, column_[i]);
        } else if (usable && traceable && column_[i] == LightCells::kFull) {
            // No column left for this light cell: the caller uses the table.
            left.push_back(uint32_t(i));
        } else {
            ++counters.bypassed;
            // Marked, so that `answer` and `queue_rays` leave the sample out.
            column_[i] = LightCells::kNoKey;
            if (traceable) rays_.push_back({uint32_t(i), eye, kNoCell, LightCells::kNoKey});
        }
    }
    if (usable) walk(samples, row, counters);
}

/// Walks one eye point through its levels. Hits whose neighbours agree are resolved; misses wait for rays.
void SampleRows::walk(const LocalSamples& samples, size_t row, Counters& counters) {
    const uint32_t eye = samples.eye[row];
    RowCounts counts;
    const std::span<const CellSteps::Step> steps = cells_.of(eye);
    for (size_t s = 0; s < steps.size(); ++s) {
        const bool last = s + 1 == steps.size();
        bool missing = false;
        going_ = false;
        for (size_t slab = 0; slab < slabs_used_; ++slab)
            missing |= step_slab(steps[s], last, slab, row, counts);
        if (missing) {
            const size_t before = rays_.size();
            queue_rays(samples, row, steps[s]);
            counters.rays_per_level[steps[s].level] += rays_.size() - before;
        }
        if (!going_) break;
        // Bits whose neighbours disagree at the last level before the finest
        if (s + 2 == steps.size()) counts.boundary += kernels_.count(active_.row(row), active_.row_words());
    }
    counters.lookups += counts.lookups;
    counters.hits += counts.hits;
    counters.boundary_queries += counts.boundary;
}

/// One step of Alg. 2 for 512 columns. Returns true if `fresh_` holds bits that are unknown and for which no
/// eye point of the run waits yet.
bool SampleRows::step_slab(const CellSteps::Step& step, bool last, size_t slab, size_t row,
                           RowCounts& counts) {
    Slab& table = slabs_[slab];
    RowPair neighbours[4] = {};
    if (!last)
        for (size_t q = 0; q < 4; ++q)
            neighbours[q] = {table.known.row(step.neighbours[q]), table.value.row(step.neighbours[q])};
    const RowPair own{table.known.row(step.cell), table.value.row(step.cell)};
    alignas(64) Word miss[kSlabWords];
    const size_t at = slab * kSlabWords;
    const int left = kernels_.step(active_.row(row) + at, own, neighbours, last, miss, seen_.row(row) + at,
                                   kSlabWords, counts);
    going_ |= (left & 2) != 0;
    Word* fresh = fresh_.row(0) + at;
    // What an earlier row has left there must not be queued again.
    if (!(left & 1)) {
        std::memset(fresh, 0, kSlabWords * sizeof(Word));
        return false;
    }
    waiting_.push_back({uint32_t(slab), step.cell, uint32_t(row), {}});
    std::copy_n(miss, kSlabWords, waiting_.back().miss.begin());
    // `pending` has the bits for which a ray of this run is on its way; only the others need a new one.
    return kernels_.take_misses(miss, miss, table.pending.row(step.cell), fresh, kSlabWords);
}

/// Adds a ray for every bit of `fresh_`: the one of the first sample of the eye point in that column.
void SampleRows::queue_rays(const LocalSamples& samples, size_t row, const CellSteps::Step& step) {
    Word* fresh = fresh_.row(0);
    for (size_t i = samples.begin_of(row); i < samples.end[row]; ++i) {
        const uint32_t k = column_[i];
        if (k >= LightCells::kFull || !get_bit(fresh, k)) continue;
        // Cleared, so that further samples of the eye point in this light cell share the ray.
        clear_bit(fresh, k);
        rays_.push_back({uint32_t(i), samples.eye[row], step.cell, k});
    }
}

/// Traces the rays 16 at a time; rays to one light cell are adjacent.
void SampleRows::trace(const LocalSamples& samples, std::span<Word> visible) {
    const size_t columns = light_cells_.count();
    // Rays without a column come last.
    const auto bin = [&](const PendingRay& r) { return std::min<size_t>(r.column, columns); };
    begin_.assign(columns + 2, 0);
    // Counting sort: stable, so equal columns keep the order of eye points.
    for (const PendingRay& r : rays_) ++begin_[bin(r) + 1];
    for (size_t k = 0; k <= columns; ++k) begin_[k + 1] += begin_[k];
    by_column_.resize(rays_.size());
    for (uint32_t r = 0; r < rays_.size(); ++r) by_column_[begin_[bin(rays_[r])]++] = r;
    constexpr size_t kPiece = 1024;
    for (size_t first = 0; first < rays_.size(); first += kPiece) {
        if (control_) control_->check();
        const std::span<const uint32_t> piece(by_column_.data() + first,
                                              std::min(kPiece, rays_.size() - first));
        for (size_t i = 0; i < piece.size(); i += 16)
            trace16(samples, piece.subspan(i, std::min<size_t>(16, piece.size() - i)), visible);
    }
}

/// Traces the rays with these indices. Their answers are stored in the rows of the cells, or directly for the
/// sample.
void SampleRows::trace16(const LocalSamples& samples, std::span<const uint32_t> numbers,
                         std::span<Word> visible) {
    const int n = int(numbers.size());
    RayPacket16 packet;
    for (int i = 0; i < n; ++i) {
        const PendingRay& r = rays_[numbers[size_t(i)]];
        packet.set(size_t(i), samples.ray(*tile_->eyes, r.eye, r.sample));
    }
    pad_lanes(packet, n);
    // Samples of the sky have a direction of their own each; those of a light end near each other.
    const Coherence flag = samples.is_direction() ? Coherence::kIncoherent : flag_between(caster_, packet);
    const uint32_t mask = (1u << n) - 1;
    for (uint32_t seen = mask & ~uint32_t(caster_.occluded16(uint16_t(mask), packet, flag)); seen;
         seen &= seen - 1) {
        const PendingRay& r = rays_[numbers[size_t(std::countr_zero(seen))]];
        if (r.cell == kNoCell)
            set_bit(visible.data(), r.sample);
        else
            slabs_[r.column / kSlabColumns].value.set(r.cell, r.column % kSlabColumns);
    }
}

/// Copies the answers of columns to the samples.
void SampleRows::answer(const LocalSamples& samples, size_t row, std::span<Word> visible) const {
    const Word* seen = seen_.row(row);
    // Most rows see something, but dark ones need no look at their samples.
    Word any = 0;
    for (size_t w = 0; w < seen_.row_words(); ++w) any |= seen[w];
    if (!any) return;
    for (size_t i = samples.begin_of(row); i < samples.end[row]; ++i)
        if (column_[i] < LightCells::kFull && get_bit(seen, column_[i])) set_bit(visible.data(), i);
}

}  // namespace viscache
