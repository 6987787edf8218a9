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
    const size_t slab_bytes = (cells_.size() + 1) * kSlabWords * sizeof(Word) * 3;
    const size_t most = std::clamp<size_t>(row_bytes / slab_bytes, 1, size_t{1} << 20);
    light_cells_.clear(uint32_t(most * kSlabColumns));
    slabs_used_ = 0;
}

void SampleRows::make_order(const TileAnchors& tile, uint32_t batch) {
    const uint32_t n = uint32_t(tile.size());
    // Eye points cell by cell, the nearest to the centre first
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
        round[by_cell[k]] = uint32_t(std::bit_width(rank));
    }
    order_.clear(), run_end_.clear();
    run_of_eye_.resize(n);
    for (uint32_t r = 0; order_.size() < n; ++r) {
        const size_t first = order_.size();
        for (uint32_t i = 0; i < n; ++i)
            if (round[i] == r) order_.push_back(i);
        for (size_t end = first; end < order_.size(); run_end_.push_back(uint32_t(end)))
            end = std::min(order_.size(), end + std::max(1u, batch));
    }
    for (uint32_t run = 0, k = 0; run < run_end_.size(); ++run)
        for (; k < run_end_[run]; ++k) run_of_eye_[order_[k]] = run;
}

void SampleRows::grow(size_t slabs) {
    if (slabs_.size() < slabs) slabs_.resize(slabs);
    for (; slabs_used_ < slabs; ++slabs_used_)
        for (BitMatrix Slab::* m : {&Slab::known, &Slab::value, &Slab::pending})
            (slabs_[slabs_used_].*m).reset(cells_.size() + 1, kSlabColumns);
}

uint64_t SampleRows::run(const LocalSamples& samples, const AqvcParameters& p, std::span<Word> visible,
                         std::vector<uint32_t>& left, Counters& counters, ClampCounts& clamps) {
    light_cells_.number(samples, *tile_->grid, p, column_, clamps);
    grow((light_cells_.count() + kSlabColumns - 1) / kSlabColumns);
    const size_t askers = samples.eye.size(), columns = slabs_used_ * kSlabColumns;
    asked_.reset(askers, columns), seen_.reset(askers, columns), fresh_.reset(1, columns);
    waiting_.clear(), rays_.clear(), left.clear();
    for (size_t asker = 0; asker < askers; ++asker) {
        if (control_ && asker % 256 == 0) control_->check();
        ask(samples, asker, left, counters);
    }
    trace(samples, visible);
    for (const Waiting& w : waiting_) {
        const Slab& slab = slabs_[w.slab];
        Word* known = slabs_[w.slab].known.row(w.cell);
        Word* seen = seen_.row(w.asker) + w.slab * kSlabWords;
        for (size_t k = 0; k < kSlabWords; ++k)
            known[k] |= w.miss[k], seen[k] |= w.miss[k] & slab.value.row(w.cell)[k];
    }
    for (size_t asker = 0; asker < askers; ++asker) answer(samples, asker, visible);
    return rays_.size();
}

/// Gathers the columns an eye point asks for and walks down its levels with them. What has no key is traced
/// for itself; what is not finite stays unseen.
void SampleRows::ask(const LocalSamples& samples, size_t asker, std::vector<uint32_t>& left,
                     Counters& counters) {
    const uint32_t eye = samples.eye[asker];
    Word* asked = asked_.row(asker);
    const bool usable = tile_->usable[eye];
    for (size_t i = samples.begin_of(asker); i < samples.end[asker]; ++i) {
        const bool traceable = is_traceable(samples.target(i)) && is_traceable(tile_->eyes->origin[eye]);
        if (usable && traceable && column_[i] < LightCells::kFull) {
            set_bit(asked, column_[i]);
        } else if (usable && traceable && column_[i] == LightCells::kFull) {
            left.push_back(uint32_t(i));
        } else {
            ++counters.bypassed;
            column_[i] = LightCells::kNoKey;
            if (traceable) rays_.push_back({uint32_t(i), eye, kNoCell, LightCells::kNoKey});
        }
    }
    if (usable) walk(samples, asker, counters);
}

/// One eye point down its levels: hits that agree are settled, misses wait for rays.
void SampleRows::walk(const LocalSamples& samples, size_t asker, Counters& counters) {
    const uint32_t eye = samples.eye[asker];
    RowCounts counts;
    const std::span<const CellSteps::Step> steps = cells_.of(eye);
    for (size_t s = 0; s < steps.size(); ++s) {
        const bool last = s + 1 == steps.size();
        bool missing = false;
        going_ = false;
        for (size_t slab = 0; slab < slabs_used_; ++slab)
            missing |= miss_at(steps[s], last, slab, asker, counts);
        if (missing) {
            const size_t before = rays_.size();
            queue_rays(samples, asker, steps[s]);
            counters.rays_per_level[steps[s].level] += rays_.size() - before;
        }
        if (!going_) break;
        if (s + 2 == steps.size()) counts.boundary += kernels_.count(asked_.row(asker), asked_.row_words());
    }
    counters.lookups += counts.lookups, counters.hits += counts.hits,
        counters.boundary_queries += counts.boundary;
}

/// One step of Alg. 2 for 512 columns. True if bits are missing that no eye point of the run waits for yet:
/// they are in `fresh_`.
bool SampleRows::miss_at(const CellSteps::Step& step, bool last, size_t slab, size_t asker,
                         RowCounts& counts) {
    Slab& table = slabs_[slab];
    RowPair neighbours[4] = {};
    if (!last)
        for (size_t q = 0; q < 4; ++q)
            neighbours[q] = {table.known.row(step.neighbours[q]), table.value.row(step.neighbours[q])};
    const RowPair own{table.known.row(step.cell), table.value.row(step.cell)};
    alignas(64) Word miss[kSlabWords];
    const size_t at = slab * kSlabWords;
    const int left = kernels_.step(asked_.row(asker) + at, own, neighbours, last, miss, seen_.row(asker) + at,
                                   kSlabWords, counts);
    going_ |= (left & 2) != 0;
    Word* fresh = fresh_.row(0) + at;
    if (!(left & 1)) {
        std::memset(fresh, 0, kSlabWords * sizeof(Word));
        return false;
    }
    waiting_.push_back({uint32_t(slab), step.cell, uint32_t(asker), {}});
    std::copy_n(miss, kSlabWords, waiting_.back().miss.begin());
    return kernels_.take_misses(miss, miss, table.pending.row(step.cell), fresh, kSlabWords);
}

/// A ray for every bit of `fresh_`: that of the eye point's first sample in the column.
void SampleRows::queue_rays(const LocalSamples& samples, size_t asker, const CellSteps::Step& step) {
    Word* fresh = fresh_.row(0);
    for (size_t i = samples.begin_of(asker); i < samples.end[asker]; ++i) {
        const uint32_t k = column_[i];
        if (k >= LightCells::kFull || !get_bit(fresh, k)) continue;
        clear_bit(fresh, k);
        rays_.push_back({uint32_t(i), samples.eye[asker], step.cell, k});
    }
}

/// Rays towards one light cell follow each other, sixteen at a time.
void SampleRows::trace(const LocalSamples& samples, std::span<Word> visible) {
    const size_t columns = light_cells_.count();
    const auto bin = [&](const PendingRay& r) { return std::min<size_t>(r.column, columns); };
    begin_.assign(columns + 2, 0);
    for (const PendingRay& r : rays_) ++begin_[bin(r) + 1];
    for (size_t k = 0; k <= columns; ++k) begin_[k + 1] += begin_[k];
    by_column_.resize(rays_.size());
    for (uint32_t r = 0; r < rays_.size(); ++r) by_column_[begin_[bin(rays_[r])]++] = r;
    constexpr size_t kPiece = 1024;
    for (size_t first = 0; first < rays_.size(); first += kPiece) {
        if (control_) control_->check();
        const std::span<const uint32_t> piece(by_column_.data() + first,
                                              std::min(kPiece, rays_.size() - first));
        flag_.piece([&](Coherence flag) {
            for (size_t i = 0; i < piece.size(); i += 16)
                trace16(samples, piece.subspan(i, std::min<size_t>(16, piece.size() - i)), visible, flag);
            return piece.size();
        });
    }
}

/// The rays of these numbers; their answers go to the cells' rows, or straight to the sample.
void SampleRows::trace16(const LocalSamples& samples, std::span<const uint32_t> numbers,
                         std::span<Word> visible, Coherence flag) {
    const int n = int(numbers.size());
    RayPacket16 packet;
    for (int i = 0; i < n; ++i) {
        const PendingRay& r = rays_[numbers[size_t(i)]];
        set_lane(packet, i, samples.ray(*tile_->eyes, r.eye, r.sample, extent_));
    }
    pad_lanes(packet, n);
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

/// From columns back to samples.
void SampleRows::answer(const LocalSamples& samples, size_t asker, std::span<Word> visible) const {
    const Word* seen = seen_.row(asker);
    Word any = 0;
    for (size_t w = 0; w < seen_.row_words(); ++w) any |= seen[w];
    if (!any) return;
    for (size_t i = samples.begin_of(asker); i < samples.end[asker]; ++i)
        if (column_[i] < LightCells::kFull && get_bit(seen, column_[i])) set_bit(visible.data(), i);
}

}  // namespace viscache
