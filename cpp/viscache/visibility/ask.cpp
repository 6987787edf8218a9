#include "viscache/visibility/ask.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

#include "viscache/math/morton.h"
#include "viscache/visibility/given_contributions.h"

namespace viscache {

namespace {

constexpr uint32_t kNowhere = 0xffffffffu;

/// Appends point i of `from`.
void append_point(EyeBlock& to, const EyeBlock& from, size_t i) {
    to.position.push_back(from.position[i]);
    to.normal.push_back(from.normal[i]);
    to.origin.push_back(from.origin[i]);
    to.density.push_back(from.density[i]);
}

/// Stores the log of a tile until its clusters are numbered.
class TileLog final : public QueryLog {
public:
    TileLog(std::span<const uint32_t> row, const BlockQuestion& question) : row_(row), question_(question) {}
    void answered(uint32_t eye, uint32_t column, const QueryRecord& r) override {
        if (column < question_.log_begin || column >= question_.log_end) return;
        kept.push_back({row_[eye], column, r.cluster, row_[r.representative], r.level, r.traced});
    }
    std::vector<AskedQuery> kept;

private:
    std::span<const uint32_t> row_;
    const BlockQuestion& question_;
};

/// Oracle and buffers of one thread.
struct ThreadState {
    std::unique_ptr<VisibilityOracle> oracle;
    BitMatrix wanted;
    std::vector<float> corrected;
};

/// Frame of a call with arrays, as its source sees it.
class ArraysStart final : public FrameStart {
public:
    ArraysStart(const EyeTiles& tiles, const BlockQuestion* block, const PairQuestion* pairs, int threads,
                Counters& spent)
        : tiles_(tiles), block_(block), pairs_(pairs), threads_(threads), spent_(spent) {
        if (block_) lights_.push_back(block_->lights);
    }
    std::span<const FarEnds* const> lights() const override { return lights_; }
    int threads() const override { return threads_; }
    uint64_t eye_points() const override { return tiles_.size; }
    Counters ask_small(size_t pixels, OracleSource& source, Control& control) override {
        const size_t step = std::max<size_t>(1, tiles_.size / std::max<size_t>(1, pixels));
        const Counters counters =
            block_ ? every_block(step, source, control) : every_pair(step, source, control);
        for (int g = 0; g < kLightGroups; ++g) spent_.group(g).rays += counters.groups[size_t(g)].rays;
        control.done = 0;
        return counters;
    }

private:
    /// Every step-th eye point of each tile, all far ends.
    Counters every_block(size_t step, OracleSource& source, Control& control) const {
        EyeTiles some;
        some.size = tiles_.size;
        for (size_t t = 0; t < tiles_.eyes.size(); ++t) {
            some.eyes.emplace_back();
            some.row.emplace_back();
            for (size_t i = 0; i < tiles_.eyes[t].size(); i += step) {
                append_point(some.eyes.back(), tiles_.eyes[t], i);
                some.row.back().push_back(tiles_.row[t][i]);
            }
        }
        return ask_block(source, some, {.lights = block_->lights, .wanted = block_->wanted}, threads_,
                         control)
            .counters;
    }
    /// The queries of every step-th eye point.
    Counters every_pair(size_t step, OracleSource& source, Control& control) const {
        PairQuestion some;
        for (const ShadowQuery& q : pairs_->queries)
            if (q.eye % step == 0) some.queries.push_back(q);
        return ask_pairs(source, tiles_, some, threads_, control).counters;
    }

    const EyeTiles& tiles_;
    const BlockQuestion* block_;
    const PairQuestion* pairs_;
    int threads_;
    Counters& spent_;
    std::vector<const FarEnds*> lights_;
};

/// Runs `work(tile, state, counters)` over all tiles as one round of the source.
template <class Work>
void over_tiles(OracleSource& source, const EyeTiles& tiles, int threads, Control& control,
                Counters& counters, Work work) {
    const size_t n = tiles.eyes.size();
    threads = std::min<int>(resolve_threads(threads), int(std::max<size_t>(1, n)));
    std::vector<ThreadState> states(static_cast<size_t>(threads));
    std::vector<Counters> counted(n);
    control.total = n;
    source.begin_round(n);
    parallel_for(n, threads, [&](size_t t, int worker) {
        control.check();
        ThreadState& mine = states[size_t(worker)];
        if (!mine.oracle) {
            mine.oracle = source.make();
            mine.oracle->watch(control);
        }
        mine.oracle->begin_tile(tiles.eyes[t]);
        work(t, mine, counted[t]);
        source.end_item(*mine.oracle, t);
        control.done.fetch_add(1);
    });
    for (const Counters& c : counted) counters.merge(c);
    source.end_round(counters);
}

/// Collects the wanted bits of a tile; all bits if none are given.
void gather_wanted(const BlockQuestion& q, size_t words, std::span<const uint32_t> row, BitMatrix& wanted) {
    wanted.reset(row.size(), q.lights->count);
    for (size_t i = 0; i < row.size(); ++i) {
        Word* to = wanted.row(i);
        if (q.wanted)
            std::copy_n(q.wanted + size_t(row[i]) * words, words, to);
        else
            std::fill_n(to, words, ~Word{0});
        if (const size_t used = q.lights->count % kWordBits) to[words - 1] &= (Word{1} << used) - 1;
    }
}

/// Numbers the clusters of one tile in the order of first appearance, starting at `next`.
void number_clusters(std::vector<AskedQuery>& log, uint64_t& next) {
    std::sort(log.begin(), log.end(), [](const AskedQuery& a, const AskedQuery& b) {
        return std::pair(a.row, a.column) < std::pair(b.row, b.column);
    });
    std::unordered_map<uint64_t, uint64_t> numbers;
    for (AskedQuery& q : log) q.cluster = numbers.try_emplace(q.cluster, next + numbers.size()).first->second;
    next += numbers.size();
}

}  // namespace

EyeTiles EyeTiles::along_curve(const EyeBlock& points, size_t most) {
    EyeTiles tiles;
    tiles.size = points.size();
    const std::vector<uint32_t> order = morton_order(points.position);
    const uint32_t side = std::bit_ceil(uint32_t(std::ceil(std::sqrt(double(most)))));
    for (size_t first = 0; first < order.size(); first += most) {
        EyeBlock& eyes = tiles.eyes.emplace_back();
        std::vector<uint32_t>& row = tiles.row.emplace_back();
        eyes.tile_width = eyes.tile_height = side;
        for (size_t i = first; i < std::min(order.size(), first + most); ++i) {
            append_point(eyes, points, order[i]);
            row.push_back(order[i]);
            const uint32_t along = uint32_t(i - first);
            eyes.order_x.push_back(gather2(along));
            eyes.order_y.push_back(gather2(along >> 1));
        }
    }
    return tiles;
}

BlockAnswer ask_block(OracleSource& source, const EyeTiles& tiles, const BlockQuestion& question, int threads,
                      Control& control) {
    const FarEnds& lights = *question.lights;
    BlockAnswer out;
    out.words = words_for(lights.count);
    out.bits.assign(tiles.size * out.words, 0);
    ArraysStart start(tiles, &question, nullptr, threads, out.counters);
    source.prepare(start, control);
    const bool logs_some = question.log_end > question.log_begin;
    // For corrections: what a mean eye point has without shadows
    double light = 0;
    if (question.contributions && source.corrects())
        for (size_t i = 0; i < tiles.size * lights.count; ++i) light += question.contributions[i];
    const float mean_light = float(light / double(std::max<size_t>(tiles.size, 1)));
    std::vector<std::vector<AskedQuery>> logs(logs_some ? tiles.eyes.size() : 0);
    std::mutex weights_mutex;
    over_tiles(
        source, tiles, threads, control, out.counters, [&](size_t t, ThreadState& state, Counters& counters) {
            const EyeBlock& eyes = tiles.eyes[t];
            const std::span<const uint32_t> row = tiles.row[t];
            gather_wanted(question, out.words, row, state.wanted);
            std::optional<GivenContributions> given;
            if (question.contributions) given.emplace(question.contributions, lights.count, row, mean_light);
            TileLog log(row, question);
            const Answer answer = state.oracle->block(
                {eyes, lights, state.wanted, given ? &*given : nullptr, logs_some ? &log : nullptr},
                counters);
            if (logs_some && !answer.logged)
                throw std::invalid_argument("this oracle cannot tell who answered a query");
            for (size_t i = 0; i < row.size(); ++i) {
                const std::span<const float> weights = answer.corrected_weights(i, state.corrected);
                std::copy_n(answer.bits->row(i), out.words, out.bits.data() + size_t(row[i]) * out.words);
                if (weights.empty()) continue;
                {
                    const std::lock_guard lock(weights_mutex);
                    if (out.weights.empty()) out.weights.assign(tiles.size * lights.count, 1.f);
                }
                std::copy_n(weights.data(), lights.count, out.weights.data() + size_t(row[i]) * lights.count);
            }
            if (logs_some) logs[t] = std::move(log.kept);
        });
    uint64_t clusters = 0;
    for (auto& log : logs) {
        number_clusters(log, clusters);
        out.log.insert(out.log.end(), log.begin(), log.end());
    }
    source.report(out.counters, out.report);
    return out;
}

PairAnswer ask_pairs(OracleSource& source, const EyeTiles& tiles, const PairQuestion& question, int threads,
                     Control& control) {
    PairAnswer out;
    const size_t n = question.queries.size();
    out.visible.assign(n, 0);
    // The tile and place of each eye point, and its queries
    std::vector<uint32_t> tile_of(tiles.size, kNowhere), place_of(tiles.size, 0), begin(tiles.size + 1, 0);
    for (uint32_t t = 0; t < tiles.row.size(); ++t)
        for (uint32_t i = 0; i < tiles.row[t].size(); ++i) {
            tile_of[tiles.row[t][i]] = t;
            place_of[tiles.row[t][i]] = i;
        }
    for (const ShadowQuery& q : question.queries) ++begin[q.eye + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<uint32_t> sorted(n);
    {
        std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
        for (uint32_t k = 0; k < n; ++k) sorted[next[question.queries[k].eye]++] = k;
    }
    ArraysStart start(tiles, nullptr, &question, threads, out.counters);
    source.prepare(start, control);
    std::mutex weights_mutex;
    over_tiles(
        source, tiles, threads, control, out.counters, [&](size_t t, ThreadState& state, Counters& counters) {
            const EyeBlock& eyes = tiles.eyes[t];
            const PairOrder order = state.oracle->order(eyes, {});
            std::vector<ShadowQuery> queries;
            std::vector<uint32_t> number;
            size_t run = 0;
            for (size_t first = 0; first < eyes.size();) {
                const size_t last =
                    run < order.run_end.size() ? order.run_end[run++] : std::min(first + 256, eyes.size());
                queries.clear();
                number.clear();
                for (size_t i = first; i < last; ++i) {
                    const uint32_t eye = order.eye.empty() ? uint32_t(i) : order.eye[i];
                    const uint32_t row = tiles.row[t][eye];
                    for (uint32_t k = begin[row]; k < begin[row + 1]; ++k) {
                        number.push_back(sorted[k]);
                        queries.push_back(question.queries[sorted[k]]);
                        queries.back().eye = eye;
                    }
                }
                first = last;
                if (queries.empty()) continue;
                const Answer answer = state.oracle->pairs({eyes, queries}, counters);
                const std::span<const float> weights = answer.weights;
                if (!weights.empty()) {
                    const std::lock_guard lock(weights_mutex);
                    if (out.weights.empty()) out.weights.assign(n, 1.f);
                }
                for (size_t i = 0; i < number.size(); ++i) {
                    out.visible[number[i]] = answer.bits->get(0, i);
                    if (!weights.empty()) out.weights[number[i]] = weights[i];
                }
            }
        });
    source.report(out.counters, out.report);
    return out;
}

}  // namespace viscache
