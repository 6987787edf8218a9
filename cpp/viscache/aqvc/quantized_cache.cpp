#include "viscache/aqvc/quantized_cache.h"

#include <bit>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "viscache/aqvc/row_kernels.h"

namespace viscache {
namespace {

// Numbers of clusters in a log must differ. Those of queries without a cluster are made from eye point and
// light, with a high bit that no count of clusters reaches.
// Set in the cluster number of a logged query without a cluster
constexpr uint64_t kBypassed = uint64_t{1} << 63;
// and of a bright one
constexpr uint64_t kBright = uint64_t{1} << 62;

double checked_radius(float radius) {
    detail::require(radius > 0 && std::isfinite(radius), "scene_radius must be > 0 and finite", radius);
    return radius;
}

void add_clamps(const ClampCounts& clamps, Counters& counters) {
    counters.clamped_low += clamps.low;
    counters.clamped_high += clamps.high;
    counters.clamped_nan += clamps.nan;
}

}  // namespace

QuantizedCache::QuantizedCache(const RayCaster& caster, ExactAnswers exact, const AqvcParameters& parameters,
                               Vec3 scene_center, float scene_radius, int spp, FrameTable* frame_table)
    : caster_(caster),
      parameters_(checked(parameters)),
      grid_(parameters_, scene_center, checked_radius(scene_radius)),
      spp_(spp),
      shares_(frame_table != nullptr),
      exact_(std::move(exact), parameters_, shares_),
      tracer_(caster),
      pairs_(parameters_, frame_table),
      sample_rows_(caster) {
    wrap(exact_.oracle());
    // By group: C_E and refinement may differ.
    for (int g = 0; g < kLightGroups; ++g) levels_[size_t(g)] = level_list(parameters_, g, spp);
}

void QuantizedCache::use_kept(const KeptTable& table, KeptChecks checks) {
    if (parameters_.form != Form::kPairs || parameters_.storage != Storage::kTable || shares_)
        throw std::invalid_argument("form must be pairs and storage table with a kept table");
    detail::require(checks.share >= 0 && checks.share <= 1, "check must be in [0, 1]", checks.share);
    pairs_.use_kept(table, checks);
}

void QuantizedCache::use_rows(AqvcRows& rows) {
    if (parameters_.form != Form::kWaves || shares_)
        throw std::invalid_argument("form must be waves with kept rows");
    rows_ = &rows;
}

void QuantizedCache::watch(const Control& control) {
    VisibilityOracle::watch(control);
    tracer_.watch(control);
    pairs_.watch(control);
    sample_rows_.watch(control);
}

void QuantizedCache::begin_tile(const EyeBlock& eyes) {
    exact_.oracle().begin_tile(eyes);
    // Anchors are made for the first query that the cache answers: a tile of exact groups needs none.
    tile_.eyes = nullptr;
    pairs_.begin_tile();
    has_order_ = false;
    sample_group_ = -1;
    cells_in_use_ = 0;
    tile_size_ = eyes.size();
}

/// Anchors of the tile's eye points, for the first query that the cache answers.
void QuantizedCache::make_anchors(const EyeBlock& eyes) {
    if (tile_.eyes) return;
    tile_.make(eyes, grid_);
    if (parameters_.form == Form::kWaves) placer_.begin(tile_);
}

/// Cells of the tile at these levels, computed once and shared by all groups with these levels.
const TileCells& QuantizedCache::cells_of(const std::vector<double>& levels) {
    // Few lists of levels exist, since most groups share C_E.
    for (size_t i = 0; i < cells_in_use_; ++i)
        if (cells_[i].levels == levels) return cells_[i].cells;
    // A deque: growing keeps references to earlier cells valid.
    if (cells_in_use_ == cells_.size()) cells_.emplace_back();
    LevelCells& fresh = cells_[cells_in_use_++];
    fresh.levels = levels;
    fresh.cells.make(tile_, placer_, levels);
    return fresh.cells;
}

void QuantizedCache::make_order(const EyeBlock& eyes) {
    if (has_order_) return;
    has_order_ = true;
    order_maker_.make(eyes, parameters_, order_);
    run_end_ = run_ends(order_, batch());
    run_of_eye_.clear();
    // One query at a time: without runs, every query is its own batch.
    if (parameters_.batch == 1) return;
    run_of_eye_.resize(eyes.size());
    uint32_t first = 0;
    for (uint32_t run = 0; run < run_end_.size(); ++run)
        for (; first < run_end_[run]; ++first) run_of_eye_[order_.eye[first]] = run;
}

PairOrder QuantizedCache::order(const EyeBlock& eyes, std::optional<int> group) {
    // Exact rays need no order.
    if (group && exact_.own().test(size_t(*group))) return {};
    if (group && has_sample_rows()) {
        sample_counters_ = {};
        // Counters of this preparation are handed over by the next call of `pairs`: `order` has none to add
        // to.
        begin_sample_rows(eyes, *group, sample_counters_);
        return {sample_rows_.order(), sample_rows_.run_end()};
    }
    // A table of the frame takes queries in any order.
    if (shares_) return {};
    make_order(eyes);
    return {order_.eye, run_end_};
}

Answer QuantizedCache::block(const BlockAsk& ask, Counters& counters) {
    const FarEnds& lights = ask.lights;
    const BitMatrix& wanted = ask.wanted;
    // An empty block need not have the tile's shape.
    const bool is_empty = wanted.rows() == 0 || lights.count == 0;
    if (!is_empty && (wanted.rows() != tile_size_ || wanted.columns() != lights.count))
        throw std::logic_error("a block must have a row per eye point of the tile and a column per light");
    if (exact_.answers(lights)) {
        Answer answer = exact_.oracle().block(ask, counters);
        // Says so in the answer: corrections and audits skip these bits.
        answer.exact.set(size_t(lights.group));
        return answer;
    }
    Answer answer{.bits = &new_bits(wanted.rows(), wanted.columns()), .logged = ask.log != nullptr};
    if (is_empty) return answer;
    make_anchors(ask.eyes);
    BitMatrix& visible = *answer.bits;
    if (parameters_.form == Form::kPairs)
        block_by_pairs(ask, visible, counters);
    else
        answer.doubts = block_by_waves(ask, visible, counters);
    GroupCounters& group = counters.groups[size_t(lights.group)];
    const RowKernels& kernels = row_kernels(active_isa());
    // Counted from the bits in the end, whichever way they were found.
    for (size_t i = 0; i < wanted.rows(); ++i) {
        const uint64_t queries = kernels.count(wanted.row(i), wanted.row_words());
        group.queries += queries;
        group.occluded += queries - kernels.count(visible.row(i), visible.row_words());
    }
    return answer;
}

/// Returns the answers that are doubtful.
const BitMatrix* QuantizedCache::block_by_waves(const BlockAsk& ask, BitMatrix& visible, Counters& counters) {
    const FarEnds& lights = ask.lights;
    ClampCounts clamps;
    columns_.prepare(lights, ask.wanted, grid_, parameters_, tile_.usable, clamps);
    // Waves work with columns. If lights share columns, their answers are spread to the lights afterwards.
    BitMatrix* answer = &visible;
    if (columns_.merged()) {
        by_column_.reset(ask.eyes.size(), columns_.count());
        answer = &by_column_;
    }
    const BitMatrix* doubtful = nullptr;
    uint64_t& rays = counters.groups[size_t(lights.group)].rays;
    if (columns_.count() > 0) {
        const bool by_contribution =
            ask.contributions && parameters_.by_contribution && refines(parameters_, lights.group, spp_);
        // With C_E by contribution, the coarsest level is lifted: dim connections share larger cells.
        const std::vector<double> levels =
            level_list(parameters_, lights.group, spp_, by_contribution ? ContributionLevels::kLift : 1);
        contribution_levels_.begin(by_contribution ? ask.contributions : nullptr, columns_, levels,
                                   parameters_.group_c_e(lights.group), parameters_.level_step);
        const TileCells& cells = cells_of(levels);
        add_clamps(cells.clamps, counters);
        KeptRows* kept = rows_ ? &rows_->rows(ask.eyes.tile, lights.group) : nullptr;
        if (kept) kept->begin(columns_, levels);
        rays += waves_.run(tile_, cells, columns_, contribution_levels_, tracer_, kept, *answer, counters,
                           ask.log);
        if (kept) kept->store(cells, waves_.known(), waves_.value());
        if (columns_.merged()) columns_.spread(by_column_, visible);
        doubtful = doubts(lights);
        // After the cache, so that bright connections overwrite what their cell said.
        if (parameters_.bright > 0 && ask.contributions) rays += trace_bright(ask, visible);
    }
    rays += trace_bypassing(ask, visible, counters);
    add_clamps(clamps, counters);
    return doubtful;
}

/// What only the finest cells answered, by light.
const BitMatrix* QuantizedCache::doubts(const FarEnds& lights) {
    if (waves_.finest().rows() == 0) return nullptr;
    if (!columns_.merged()) return &waves_.finest();
    doubts_by_light_.reset(waves_.finest().rows(), lights.count);
    columns_.spread(waves_.finest(), doubts_by_light_);
    return &doubts_by_light_;
}

/// Traces rays for connections above `bright` means of their eye point. Their answers take precedence.
// Differs (A50): goes beyond the paper. Few connections carry most of the squared contributions, and a wrong
// bit of one of them costs as much as many others.
uint64_t QuantizedCache::trace_bright(const BlockAsk& ask, BitMatrix& visible) {
    const EyeBlock& eyes = ask.eyes;
    const FarEnds& lights = ask.lights;
    const BitMatrix& wanted = ask.wanted;
    bright_.reset(1, lights.count);
    const float share = float(parameters_.bright);
    uint64_t rays = 0;
    for (uint32_t i = 0; i < eyes.size(); ++i) {
        if (!tile_.usable[i]) continue;
        Word* row = bright_.row(0);
        ask.contributions->at_most(i, {&share, 1}, {&row, 1});
        // Wanted and not among those of at most `bright` means
        for (size_t w = 0; w < wanted.row_words(); ++w) row[w] = wanted.row(i)[w] & ~row[w];
        for_each_bit(std::span<const Word>(row, wanted.row_words()), [&](size_t k) {
            // They get their ray in `trace_bypassing`.
            if (columns_.bypasses(k)) return;
            clear_bit(visible.row(i), k);
            if (ask.log)
                ask.log->answered(i, uint32_t(k), {kBright + i * uint64_t(lights.count) + k, i, 0, true});
            tracer_.add({i, i, uint32_t(k), uint32_t(k)});
        });
        // Misses of many eye points together fill packets by light.
        if (tracer_.full()) rays += tracer_.flush(eyes, lights, visible);
    }
    return rays + tracer_.flush(eyes, lights, visible);
}

/// Traces exact rays for queries without a key: eye points or lights without a normal. Points that are not
/// finite stay invisible.
uint64_t QuantizedCache::trace_bypassing(const BlockAsk& ask, BitMatrix& visible, Counters& counters) {
    const EyeBlock& eyes = ask.eyes;
    const FarEnds& lights = ask.lights;
    const BitMatrix& wanted = ask.wanted;
    std::vector<uint32_t> keyless;
    for (uint32_t k = 0; k < lights.count; ++k)
        if (columns_.bypasses(k)) keyless.push_back(k);
    const auto trace = [&](uint32_t eye, uint32_t k) {
        ++counters.bypassed;
        if (ask.log) ask.log->answered(eye, k, {kBypassed + eye * uint64_t(lights.count) + k, eye, 0, true});
        if (is_traceable(eyes.origin[eye]) && is_traceable(Vec3{lights.tx[k], lights.ty[k], lights.tz[k]}))
            tracer_.add({eye, eye, k, k});
    };
    for (uint32_t i = 0; i < eyes.size(); ++i) {
        if (!tile_.usable[i])
            for_each_bit(wanted.row_span(i), [&](size_t k) { trace(i, uint32_t(k)); });
        else
            for (uint32_t k : keyless)
                if (wanted.get(i, k)) trace(i, k);
    }
    return tracer_.flush(eyes, lights, visible);
}

void QuantizedCache::block_by_pairs(const BlockAsk& ask, BitMatrix& visible, Counters& counters) {
    const FarEnds& lights = ask.lights;
    // Runs of the order, one after the other: the queries of a run are looked up before any is traced.
    make_order(ask.eyes);
    PairLog records;
    pairs_.log(ask.log ? &records : nullptr);
    std::vector<ShadowQuery> queries;
    std::vector<uint32_t> light;
    std::vector<Word> answer;
    uint32_t first = 0;
    for (uint32_t end : run_end_) {
        queries.clear();
        light.clear();
        for (; first < end; ++first)
            for_each_bit(ask.wanted.row_span(order_.eye[first]), [&](size_t k) {
                light.push_back(uint32_t(k));
                queries.push_back({.eye = order_.eye[first],
                                   .semantic = lights.semantic,
                                   .group = uint8_t(lights.group),
                                   .far = {lights.x[k], lights.y[k], lights.z[k]},
                                   .far_normal = {lights.nx[k], lights.ny[k], lights.nz[k]},
                                   .ray_end = {lights.tx[k], lights.ty[k], lights.tz[k]},
                                   .density = lights.density[k]});
            });
        answer.assign(words_for(queries.size()), 0);
        records.begin_run(ask.log ? queries.size() : 0);
        run_pairs(ask.eyes, queries, answer, run_of_eye_, counters);
        for (size_t i = 0; i < queries.size(); ++i) {
            if (get_bit(answer.data(), i)) visible.set(queries[i].eye, light[i]);
            if (ask.log) ask.log->answered(queries[i].eye, light[i], records.records()[i]);
        }
    }
    pairs_.log(nullptr);
}

void QuantizedCache::run_pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                               std::span<Word> visible, const std::vector<uint32_t>& run_of_eye,
                               Counters& counters) {
    // Frames with one table bring their own order.
    if (!shares_) make_order(eyes);
    make_anchors(eyes);
    ClampCounts clamps;
    const PairContext context{tile_, parameters_, levels_, run_of_eye, caster_};
    pairs_.run(context, queries, visible, counters, clamps);
    add_clamps(clamps, counters);
}

Answer QuantizedCache::pairs(const PairsAsk& ask, Counters& counters) {
    if (ask.samples && exact_.own().test(size_t(ask.samples->group))) {
        Answer answer = exact_.oracle().pairs(ask, counters);
        answer.exact = exact_.own();
        return answer;
    }
    const Answer answer{.bits = &new_bits(1, ask.size()), .exact = exact_.own()};
    if (ask.samples)
        cached_samples(ask.eyes, *ask.samples, answer.row(0), counters);
    else
        exact_.pairs(ask.eyes, ask.queries, answer.row(0), counters,
                     [&](std::span<const ShadowQuery> cached, std::span<Word> seen) {
                         cached_pairs(ask.eyes, cached, seen, counters);
                     });
    return answer;
}

void QuantizedCache::cached_pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries,
                                  std::span<Word> visible, Counters& counters) {
    run_pairs(eyes, queries, visible, run_of_eye_, counters);
    for (size_t i = 0; i < queries.size(); ++i) {
        ++counters.groups[queries[i].group].queries;
        counters.groups[queries[i].group].occluded += !get_bit(visible.data(), i);
    }
}

void QuantizedCache::begin_sample_rows(const EyeBlock& eyes, int group, Counters& counters) {
    // Rows of a group serve all calls for this group in the tile.
    if (sample_group_ == group) return;
    make_anchors(eyes);
    ClampCounts clamps;
    // Rows are emptier than a table, because most cells use few of the columns
    sample_rows_.begin(tile_, levels_[size_t(group)], batch(), 16 * parameters_.table_bytes, counters,
                       clamps);
    add_clamps(clamps, counters);
    sample_group_ = group;
}

void QuantizedCache::cached_samples(const EyeBlock& eyes, const LocalSamples& samples,
                                    std::span<Word> visible, Counters& counters) {
    GroupCounters& group = counters.groups[size_t(samples.group)];
    if (has_sample_rows()) {
        begin_sample_rows(eyes, samples.group, counters);
        // Hands over what `order` has counted.
        counters.merge(std::exchange(sample_counters_, {}));
        ClampCounts clamps;
        group.rays += sample_rows_.run(samples, parameters_, visible, left_, counters, clamps);
        add_clamps(clamps, counters);
        // Samples for which rows have no room go through the table.
        samples_by_pairs(eyes, samples, left_, sample_rows_.run_of_eye(), visible, counters);
    } else {
        left_.resize(samples.size());
        std::iota(left_.begin(), left_.end(), 0u);
        if (!shares_) make_order(eyes);
        samples_by_pairs(eyes, samples, left_, run_of_eye_, visible, counters);
    }
    group.queries += samples.size();
    // Occluded ones are samples minus visible ones.
    for (Word w : visible) group.occluded -= uint64_t(std::popcount(w));
    group.occluded += samples.size();
}

/// Answers the samples with these indices from the table.
void QuantizedCache::samples_by_pairs(const EyeBlock& eyes, const LocalSamples& samples,
                                      std::span<const uint32_t> numbers,
                                      const std::vector<uint32_t>& run_of_eye, std::span<Word> visible,
                                      Counters& counters) {
    if (numbers.empty()) return;
    const bool light = parameters_.cell_density == CellDensity::kLight;
    std::vector<ShadowQuery> queries;
    size_t row = 0;
    for (uint32_t i : numbers) {
        // `end[row]` is the end of the samples of an eye point; numbers ascend.
        while (samples.end[row] <= i) ++row;
        queries.push_back(samples.query(samples.eye[row], i));
        // With "light", cells follow the density of light sampling only and are the same for all pixels.
        if (light) queries.back().density = samples.light_density[i];
    }
    std::vector<Word> answer(words_for(queries.size()));
    run_pairs(eyes, queries, answer, run_of_eye, counters);
    for_each_bit(answer, [&](size_t k) { set_bit(visible.data(), numbers[k]); });
}

}  // namespace viscache
