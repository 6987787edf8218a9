#include "viscache/aqvc/pairs.h"

#include <stdexcept>

namespace viscache {

Pairs::Pairs(const AqvcParameters& p, FrameTable* frame_table)
    : frame_table_(frame_table), waiting_(p.queue), of_thread_(p.storage == Storage::kPaperTiles) {
    // A power of two: the hash chooses a slot by a mask.
    pending_slots_.assign(1024, 0);
    if (frame_table) return;
    switch (p.storage) {
        case Storage::kTable:
        case Storage::kPaperTiles:
            table_.emplace(largest_prime(p.table_bytes / 4), p.digest_bits, p.hash);
            break;
        case Storage::kExact: exact_.emplace(); break;
        case Storage::kShared:
            throw std::invalid_argument(
                "storage must be table or exact where tiles have their own, got shared");
    }
}

void Pairs::begin_tile() {
    // No eye point has this number: the cells of the previous tile are never taken for those of this one.
    for (EyeCells& e : eye_cells_) e.eye = 0xffffffffu;
    // "paper_tiles": the table lives as long as the thread.
    if (of_thread_) return;
    if (table_) table_->clear();
    if (exact_) exact_->clear();
    slots_counted_ = frame_table_ || kept_;
    kept_writes_.clear();
}

void Pairs::log(PairLog* log) {
    if (log && (frame_table_ || kept_ || of_thread_))
        throw std::invalid_argument("clusters are logged where each tile has a table of its own");
    log_ = log;
    if (log_) log_->begin_tile();
}

void Pairs::run(const PairContext& c, std::span<const ShadowQuery> queries, std::span<Word> visible,
                Counters& counters, ClampCounts& clamps) {
    // One code for every kind of table.
    const auto run = [&](auto& table) {
        if (c.parameters.queue)
            run_postponed(table, c, queries, visible, counters, clamps);
        else
            run_batches(table, c, queries, visible, counters, clamps);
    };
    if (frame_table_)
        frame_table_->with_table(writes_, run);
    else if (kept_) {
        LayeredTable layers(*table_, kept_->bits(), kept_writes_);
        run(layers);
    } else if (table_)
        run(*table_);
    else
        run(*exact_);
}

template <class Table>
void Pairs::run_batches(Table& table, const PairContext& c, std::span<const ShadowQuery> queries,
                        std::span<Word> visible, Counters& counters, ClampCounts& clamps) {
    // A batch is a run of eye points that lies within one segment of the order. With a table of the frame,
    // the whole call is one item and one batch. Without runs, each query is a batch (batch = 1).
    for (size_t first = 0, last; first < queries.size(); first = last) {
        last = first + 1;
        if (frame_table_)
            last = queries.size();
        else if (!c.run_of_eye.empty())
            while (last < queries.size() &&
                   c.run_of_eye[queries[last].eye] == c.run_of_eye[queries[first].eye])
                ++last;
        run_batch(table, c, queries, first, last, visible, counters, clamps);
    }
}

template <class Table>
void Pairs::run_batch(Table& table, const PairContext& c, std::span<const ShadowQuery> queries, size_t first,
                      size_t last, std::span<Word> visible, Counters& counters, ClampCounts& clamps) {
    waiting_.rays.clear();
    waiting_.dependants.clear();
    checks_.clear();
    // Filled again only if the previous batch left something
    if (pending_count_) std::fill(pending_slots_.begin(), pending_slots_.end(), 0u);
    pending_count_ = 0;
    // All look-ups come before the first write.
    for (size_t i = first; i < last; ++i) {
        check_cancelled(i);
        look_up(table, c, queries[i], uint32_t(i), visible, counters, clamps);
    }
    finish(table, c, queries, 0, waiting_.rays.size(), visible, counters);
    if (!checks_.empty()) trace_checks(table, c, queries, visible, counters);
}

/// Sec. 4.4 instead of batches: each warp looks up, then the queue decides which rays are due.
template <class Table>
void Pairs::run_postponed(Table& table, const PairContext& c, std::span<const ShadowQuery> queries,
                          std::span<Word> visible, Counters& counters, ClampCounts& clamps) {
    waiting_.rays.clear();
    waiting_.dependants.clear();
    checks_.clear();
    // Rays [first, last) of the queue are due.
    const auto finished = [&](size_t first, size_t last) {
        finish(table, c, queries, first, last, visible, counters);
    };
    for (size_t first = 0; first < queries.size(); first += waiting_.width()) {
        const size_t first_new = waiting_.rays.size();
        for (size_t i = first; i < std::min(queries.size(), first + waiting_.width()); ++i) {
            check_cancelled(i);
            look_up(table, c, queries[i], uint32_t(i), visible, counters, clamps);
        }
        waiting_.end_warp(first_new, c.parameters.c_w, finished);
    }
    waiting_.finish_all(finished);
    if (!checks_.empty()) trace_checks(table, c, queries, visible, counters);
}

template <class Table>
void Pairs::finish(Table& table, const PairContext& c, std::span<const ShadowQuery> queries, size_t first,
                   size_t last, std::span<Word> visible, Counters& counters) {
    trace(c, queries, first, last);
    TableCounts counts;
    // Rays first, then the queries that wait for them: a query may share the ray of an earlier one.
    std::vector<QueryRecord> clusters;  // of the rays, for the log
    for (size_t r = first; r < last; ++r) {
        const PendingRay& ray = waiting_.rays[r];
        ++counters.groups[queries[ray.query].group].rays;
        if (log_) clusters.push_back(log_->new_cluster(queries[ray.query].eye, std::max(0, ray.level)));
        // A bypassing query has no key, so its answer goes into no table.
        if (ray.level < 0) continue;
        ++counters.rays_per_level[size_t(ray.level)];
        table.put(ray.key, ray_visible_[r - first], counts);
        if constexpr (requires { table.entry(ray.key); })
            if (log_) log_->written(table.entry(ray.key), clusters.back());
    }
    for (const auto& [query, ray] : waiting_.dependants) {
        if (ray < first || ray >= last) continue;
        if (ray_visible_[ray - first]) set_bit(visible.data(), query);
        if (log_)
            log_->answered(query, clusters[ray - first], clusters[ray - first].level,
                           query == waiting_.rays[ray].query);
    }
    // Once per tile, at the first write: tiles that never write have no table in use.
    if (counts.writes && !slots_counted_) {
        counters.table_slots += table.slots();
        slots_counted_ = true;
    }
    counters.add_writes(counts.writes, counts.evictions, counts.duplicates, counts.expected_false_hits);
}

template <class Table>
void Pairs::look_up(const Table& table, const PairContext& c, const ShadowQuery& q, uint32_t index,
                    std::span<Word> visible, Counters& counters, ClampCounts& clamps) {
    // Rays to or from points that are not finite cannot be traced: such queries stay invisible.
    const bool traceable = is_traceable(c.tile.eyes->origin[q.eye]) &&
                           is_traceable(is_direction(q.semantic) ? q.far : q.ray_end);
    if (!traceable || !key_query(table, c, q, clamps)) {
        ++counters.bypassed;
        if (!traceable) {
            if (log_) log_->answered(index, log_->new_cluster(q.eye, 0), 0, true);
            return;
        }
        // A query without a key waits for a ray of its own.
        waiting_.dependants.push_back({index, uint32_t(waiting_.rays.size())});
        waiting_.rays.push_back({index, -1, {}});
        return;
    }
    const Walk walk = walk_levels(table, *c.tile.grid, *cells_, fars_, counters);
    if (walk.known) {
        if (walk.visible) set_bit(visible.data(), index);
        if (kept_) count_reuse(c, q, index, walk, counters);
        if constexpr (requires { table.entry(walk.key); })
            if (log_) log_->found(index, table.entry(key_at(walk.level)), walk.level);
        return;
    }
    // Misses with equal keys share a ray, as they would share its bit if they came one after the other.
    const uint32_t ray = c.parameters.queue ? waiting_.find(walk.key) : pending_with(walk.key);
    if (ray == waiting_.rays.size()) waiting_.rays.push_back({index, walk.level, walk.key});
    waiting_.dependants.push_back({index, ray});
}

template <class Table>
bool Pairs::key_query(const Table& table, const PairContext& c, const ShadowQuery& q, ClampCounts& clamps) {
    if (!c.tile.usable[q.eye]) return false;
    const CellGrid& grid = *c.tile.grid;
    const std::vector<double>& levels = c.levels[q.group];
    const Semantic s = key_semantic(q.semantic, q.group, c.parameters);
    if (s == Semantic::kSurface && frame_table_) {
        // Eq. 6: both ends use the resolution of the pair, so both keys change with the level.
        paired_cells_.levels.clear();
        fars_.clear();
        paired_cells_.anchor = c.tile.anchor[q.eye];
        paired_cells_.semantic = s;
        for (size_t d = 0; d < levels.size(); ++d) {
            const double r =
                resolution_pair(c.tile.eyes->density[q.eye], q.density, levels[d], grid.radius());
            const PlacedCell placed = grid.cell(paired_cells_.anchor, grid.ladder.rung(r, clamps));
            FarKey far;
            if (!grid.far_key(s, q.far, q.far_normal, r, far, clamps)) return false;
            if (paired_cells_.repeats(placed) && fars_.back() == far) continue;
            paired_cells_.add(table, grid, placed, int(d));
            fars_.push_back(far);
        }
        cells_ = &paired_cells_;
        return true;
    }
    fars_.resize(1);
    if (!grid.far_key(s, q.far, q.far_normal, far_resolution(s, q.density, grid.radius(), c.parameters),
                      fars_[0], clamps))
        return false;
    // Queries come eye point by eye point, so the cells of the latest one per group are nearly always those
    // needed.
    EyeCells& own = eye_cells_[q.group];
    cells_ = &own.cells;
    if (own.eye == q.eye && own.cells.semantic == s) return true;
    own.eye = q.eye;
    own.cells.levels.clear();
    own.cells.anchor = c.tile.anchor[q.eye];
    own.cells.semantic = s;
    for (size_t d = 0; d < levels.size(); ++d) {
        const PlacedCell placed = c.tile.cell(q.eye, levels[d], clamps);
        if (!own.cells.repeats(placed)) own.cells.add(table, grid, placed, int(d));
    }
    return true;
}

FullKey Pairs::key_at(int level) const {
    size_t d = 0;
    while (cells_->levels[d].level != level) ++d;
    // One far key serves all levels (Eq. 7), or each has its own (Eq. 6).
    return CellGrid::full_key(cells_->levels[d].own.slots, fars_[fars_.size() == 1 ? 0 : d]);
}

/// Index of the ray of the batch with this key. For a new key, reserves and returns the index of the next
/// ray.
uint32_t Pairs::pending_with(const FullKey& key) {
    const std::vector<PendingRay>& rays = waiting_.rays;
    // Half full: linear probing stays short. The table then doubles, and all keys of the batch enter anew.
    if (2 * (pending_count_ + 1) > pending_slots_.size()) {
        pending_slots_.assign(2 * pending_slots_.size(), 0);
        pending_count_ = 0;
        for (uint32_t r = 0, n = uint32_t(rays.size()); r < n; ++r) {
            // Bypassing rays have no key.
            if (rays[r].level < 0) continue;
            const KeyHash h = hash_key(rays[r].key, HashScheme::kScheme2);
            size_t i = h.kappa & (pending_slots_.size() - 1);
            while (pending_slots_[i]) i = (i + 1) & (pending_slots_.size() - 1);
            pending_slots_[i] = r + 1;
            ++pending_count_;
        }
    }
    size_t i = hash_key(key, HashScheme::kScheme2).kappa & (pending_slots_.size() - 1);
    for (; pending_slots_[i]; i = (i + 1) & (pending_slots_.size() - 1))
        // Full keys are compared: here, other than in the lossy table, two keys never share a ray by chance.
        if (rays[pending_slots_[i] - 1].key == key) return pending_slots_[i] - 1;
    pending_slots_[i] = uint32_t(rays.size()) + 1;
    ++pending_count_;
    return uint32_t(rays.size());
}

/// Counts a reused bit and decides whether to check it by a ray. The decision depends only on the frame
/// number and the query.
void Pairs::count_reuse(const PairContext& c, const ShadowQuery& q, uint32_t index, const Walk& walk,
                        Counters& counters) {
    ++(walk.kept ? counters.reused_kept : counters.reused_fresh);
    if (checking_.share <= 0 || (checking_.repair && !walk.kept)) return;
    const Vec3 x = c.tile.eyes->position[q.eye];
    // Frame number, eye point and far end make a random number that threads and batches do not change.
    uint64_t h = kept_->frames();
    for (float v : {x.x, x.y, x.z, q.far.x, q.far.y, q.far.z})
        h = murmur64(h + uint32_t(float_bits(v)) + 0x9e3779b97f4a7c15ull);
    // 53 bits of the hash as a number in [0, 1)
    if (double(h >> 11) * 0x1p-53 < checking_.share)
        checks_.push_back({index, walk.kept, walk.visible, walk.key});
}

template <class Table>
void Pairs::trace_checks(Table& table, const PairContext& c, std::span<const ShadowQuery> queries,
                         std::span<Word> visible, Counters& counters) {
    TableCounts counts;
    trace_numbered(
        c, queries, checks_.size(), [&](size_t i) { return checks_[i].query; },
        [&](size_t i, bool seen) {
            const Check& check = checks_[i];
            const bool wrong = seen != check.visible;
            ++(check.kept ? counters.checked_kept : counters.checked_fresh);
            (check.kept ? counters.wrong_kept : counters.wrong_fresh) += wrong;
            // Without repair, checks only measure: their rays are counted apart and change nothing.
            if (!checking_.repair) return;
            ++counters.groups[queries[check.query].group].rays;
            if (!wrong) return;
            table.put(check.key, seen, counts);
            Word& word = visible[check.query / 64];
            // The ray knows better: the bit is inverted.
            word ^= Word{1} << (check.query % 64);
        });
}

template <class Number, class Answer>
void Pairs::trace_numbered(const PairContext& c, std::span<const ShadowQuery> queries, size_t count,
                           Number number, Answer answer) const {
    for (size_t first = 0; first < count; first += 16) {
        check_cancelled(first);
        const int n = int(std::min<size_t>(16, count - first));
        RayPacket16 packet;
        for (int i = 0; i < n; ++i)
            packet.set(size_t(i), shadow_ray(*c.tile.eyes, queries[number(first + size_t(i))]));
        pad_lanes(packet, n);
        const uint32_t mask = (1u << n) - 1;
        // Misses of a table share neither origins nor ends.
        const uint32_t occluded = c.caster.occluded16(uint16_t(mask), packet, Coherence::kIncoherent);
        for (int i = 0; i < n; ++i) answer(first + size_t(i), !(occluded >> i & 1));
    }
}

void Pairs::trace(const PairContext& c, std::span<const ShadowQuery> queries, size_t first, size_t last) {
    ray_visible_.assign(last - first, 0);
    trace_numbered(
        c, queries, last - first, [&](size_t i) { return waiting_.rays[first + i].query; },
        [&](size_t i, bool seen) { ray_visible_[i] = seen; });
}

}  // namespace viscache
