#include "viscache/render/frame.h"

#include <algorithm>
#include <cmath>

#include "viscache/math/wall_clock.h"
#include "viscache/render/audit_pixels.h"
#include "viscache/render/frame_start.h"
#include "viscache/render/glossy_sums.h"
#include "viscache/render/local_samples.h"
#include "viscache/render/stage_clock.h"
#include "viscache/render/tile_contributions.h"
#include "viscache/render/weighted_lights.h"
#include "viscache/scene/check.h"
#include "viscache/visibility/exact_source.h"

namespace viscache {

namespace {

constexpr size_t kManyDirections = 16;      // that all eye points share, for tiles of directions
constexpr size_t kEyesPerBatch = 256;       // largest number of eye points per batch of local samples
constexpr size_t kPairsPerBatch = 1 << 16;  // bounds the queries of a batch
constexpr size_t kRowsPerCheck = 256;       // eye points between checks for an interrupt

/// Data of a frame that all tiles share.
struct FrameContext {
    const Scene& scene;
    const RayCaster& caster;
    const IntegratorSettings& integrator;
    const FrameSettings& frame;
    EyePathTracer tracer;
    std::vector<SharedLights> shared;
    const ProductContext* product = nullptr;  ///< product sampling of the environment; nullptr: not used
    const AmbientShares* shares = nullptr;    ///< for shared directions
};

/// Renders tiles on one thread. Its buffers are reused.
class TileWorker {
public:
    TileWorker(const FrameContext& context, OracleSource& source, const Control& control)
        : c_(context), oracle_(source.make()), picks_(size_t(context.integrator.pick), context.frame.seed) {
        oracle_->watch(control);
        if (c_.frame.audit_share > 0) audit_.emplace(c_.frame, c_.caster, c_.scene.offset_extent(), control);
        if (c_.product) product_.emplace(*c_.product);
    }

    void render(size_t number, const Tile& tile, FrameResult& out, Counters& counters, StageSeconds& stages,
                ProductSeconds& product, AuditRecords* audit, const Control& control) {
        StageClock clock;
        c_.tracer.trace(tile, eyes_, counters, control);
        clock.lap(stages.eye_paths);
        for (int g = 0; g < kLightGroups; ++g)
            sums_[g].assign(out.groups[g].empty() ? 0 : size_t(eyes_.width) * eyes_.height, {});
        variance_.clear();
        unoccluded_.assign(out.unoccluded.empty() ? 0 : size_t(eyes_.width) * eyes_.height, 0);
        eyes_.block.tile = number;
        oracle_->begin_tile(eyes_.block);
        clock.lap(stages.visibility);
        if (audit_) audit_->begin_tile(eyes_);
        clock.lap(stages.audit);
        for (const SharedLights& lights : c_.shared) {
            add_shared(lights, counters, stages, clock, control);
        }
        add_local(counters, stages, clock, control);
        if (c_.shares) add_shares(c_.shares->first[number]);
        if (product_) add_product(tile, counters, stages, product, control);
        if (audit_ && audit) audit_->end_tile(*audit);
        clock.skip();
        write(tile, out);
        clock.lap(stages.shading);
    }

    VisibilityOracle& oracle() { return *oracle_; }
    /// True if exact rays answered all queries of this thread.
    bool all_exact() const { return inexact_.none(); }
    const RecordTally* tally() const { return product_ ? &product_->tally() : nullptr; }

private:
    void add_shared(const SharedLights& lights, Counters& counters, StageSeconds& stages, StageClock& clock,
                    const Control& control) {
        wanted_.reset(eyes_.size(), lights.ends.count);
        picks_.begin(lights);
        for (size_t i = 0; i < eyes_.size(); ++i) {
            if (i % kRowsPerCheck == 0) control.check();
            const ColumnRange asked = lights.ends.columns_of(eyes_.block, i);
            if (!is_black(eyes_.shading[i]))
                counters.non_finite += wanted_row(lights, shade(i), asked, wanted_.row(i));
            picks_.add(shade(i), eyes_, uint32_t(i), wanted_.row(i));
        }
        clock.lap(stages.contributions);
        const TileContributions contributions(lights, eyes_, picks_, wanted_);
        const BlockAsk ask{eyes_.block, lights.ends, wanted_, &contributions};
        const Answer answer = oracle_->block(ask, counters);
        WeightedLights weighted(lights);
        clock.lap(stages.visibility);
        if (audit_)
            audit_->block(ask, answer, contributions, [&](size_t i, const Word* row) {
                return eyes_.throughput[i] * reflected(weighted.with(picks_.of(i), {}), i, row);
            });
        if (!answer.is_exact(lights.ends.group)) {
            inexact_.set(size_t(lights.ends.group));
            if (!unoccluded_.empty()) contributions.add_to(unoccluded_);
        }
        clock.lap(stages.audit);
        std::vector<Rgb>& sum = sums_[size_t(lights.ends.group)];
        for (size_t i = 0; i < eyes_.size(); ++i) {
            if (i % kRowsPerCheck == 0) control.check();
            const SharedLights& counted = weighted.with(picks_.of(i), answer.weights_of(i));
            sum[eyes_.pixel[i]] += eyes_.throughput[i] * reflected(counted, i, answer.bits->row(i));
            const std::span<const Correction> corrections = answer.corrections_of(i);
            if (corrections.empty()) continue;
            const SharedLights& once = weighted.with(picks_.of(i), {});
            for (const Correction& c : corrections) {
                one_.assign(wanted_.row_words(), 0);
                set_bit(one_.data(), c.column);
                add_correction(eyes_.pixel[i], eyes_.throughput[i] * reflected(once, i, one_.data()), c, sum);
            }
        }
        clock.lap(stages.shading);
    }

    /// Adds a correction of light `value`, and the variance that it stands for: (w·c)²·(1 − q), whose
    /// expectation over the draw is the variance of the correction.
    void add_correction(uint32_t pixel, Rgb value, const Correction& c, std::vector<Rgb>& sum) {
        const Rgb change = value * c.weight;
        sum[pixel] += change;
        note_variance(pixel, change, c.share);
    }

    void note_variance(uint32_t pixel, Rgb change, float share) {
        if (variance_.empty()) variance_.resize(size_t(eyes_.width) * size_t(eyes_.height));
        variance_[pixel] += change * change * (1 - share);
    }

    void add_product(const Tile& tile, Counters& counters, StageSeconds& stages, ProductSeconds& product,
                     const Control& control) {
        last_pass_.assign(size_t(eyes_.width) * size_t(eyes_.height), {});
        ProductSeconds s;
        product_->add(tile, eyes_, *oracle_, sums_[size_t(LightGroup::kEnvironment)], last_pass_, counters, s,
                      control);
        stages.contributions += s.trees + s.maps + s.samples;
        stages.visibility += s.visibility;
        stages.shading += s.finish;
        product.merge(s);
    }

    void add_local(Counters& counters, StageSeconds& stages, StageClock& clock, const Control& control) {
        const IntegratorSettings& s = c_.integrator;
        const bool area = s.direct && !c_.scene.area_lights().empty() && s.n_area > 0;
        const bool environment = s.direct && c_.scene.environment() && s.n_environment + s.n_brdf > 0 &&
                                 s.environment == EnvironmentSampling::kMis;
        if (area)
            add_batches(Semantic::kSurface, LightGroup::kArea, most_area_samples(c_.scene, s), counters,
                        stages, clock, control, [&](uint32_t eye) {
                            if (!is_black(eyes_.shading[eye]))
                                add_area_samples(c_.scene, eyes_, eye, s, c_.frame.seed, local_, counters);
                        });
        if (environment)
            add_batches(Semantic::kSolidAngle, LightGroup::kEnvironment, s.n_environment + s.n_brdf, counters,
                        stages, clock, control, [&](uint32_t eye) {
                            if (!is_black(eyes_.shading[eye]))
                                add_environment_samples(c_.scene, eyes_, eye, s, c_.frame.seed, local_,
                                                        counters);
                        });
        if (sky_lobes())
            add_batches(Semantic::kSolidAngle, LightGroup::kEnvironment, most_lobe_samples(s), counters,
                        stages, clock, control, [&](uint32_t eye) {
                            if (has_lobe(eyes_.shading[eye]))
                                add_lobe_samples(c_.scene, eyes_, eye, s, c_.frame.seed, local_, counters);
                        });
        if (s.ambient && s.ambient_directions == AmbientDirections::kPerPoint)
            add_batches(Semantic::kSolidAngle, LightGroup::kAmbient, s.n_ambient, counters, stages, clock,
                        control,
                        [&](uint32_t eye) { add_ambient_samples(eyes_, eye, s, c_.frame.seed, local_); });
    }

    /// Whether samples of lobes go with shared directions of the sky.
    bool sky_lobes() const {
        return std::any_of(c_.shared.begin(), c_.shared.end(), [](const auto& s) { return s.has_lobes(); }) &&
               std::any_of(eyes_.shading.begin(), eyes_.shading.end(), has_lobe);
    }

    /// Goes through batches of eye points in the oracle's order: makes their samples (at most `samples` per
    /// eye point), queries visibility, adds the contributions.
    template <class MakeSamples>
    void add_batches(Semantic semantic, LightGroup group, int samples, Counters& counters,
                     StageSeconds& stages, StageClock& clock, const Control& control,
                     MakeSamples make_samples) {
        const PairOrder order = oracle_->order(eyes_.block, int(group));
        std::vector<Rgb>& sum = sums_[size_t(group)];
        const size_t eyes = std::clamp<size_t>(kPairsPerBatch / size_t(samples), 1, kEyesPerBatch);
        size_t run = 0;
        for (size_t first = 0; first < eyes_.size();) {
            control.check();
            const size_t last =
                run < order.run_end.size() ? order.run_end[run++] : std::min(first + eyes, eyes_.size());
            local_.begin(semantic, group);
            for (size_t i = first; i < last; ++i)
                make_samples(order.eye.empty() ? uint32_t(i) : order.eye[i]);
            clock.lap(stages.contributions);
            const Answer answer = oracle_->pairs(
                {.eyes = eyes_.block, .samples = &local_.at, .contributions = local_.contribution}, counters);
            clock.lap(stages.visibility);
            if (audit_) audit_->samples(local_, answer);
            if (!answer.is_exact(int(group))) {
                inexact_.set(size_t(group));
                if (!unoccluded_.empty()) local_.add_to(eyes_.pixel, unoccluded_);
            }
            clock.lap(stages.audit);
            add_seen(answer, sum);
            clock.lap(stages.shading);
            first = last;
        }
    }

    /// Adds the contributions of visible samples to their pixels.
    void add_seen(const Answer& answer, std::vector<Rgb>& sum) {
        size_t row = 0;
        for_each_bit(answer.row(0), [&](size_t i) {
            while (local_.at.end[row] <= i) ++row;
            const Rgb value = local_.contribution[i];
            sum[eyes_.pixel[local_.at.eye[row]]] +=
                answer.weights.empty() ? value : value * answer.weights[i];
        });
        row = 0;
        for (const Correction& c : answer.corrections) {
            while (local_.at.end[row] <= c.column) ++row;
            note_variance(eyes_.pixel[local_.at.eye[row]], local_.contribution[c.column] * c.weight, c.share);
        }
    }

    /// Ambient occlusion along shared directions. `first`: index of the first eye point of the tile.
    void add_shares(size_t first) {
        std::vector<Rgb>& sum = sums_[size_t(LightGroup::kAmbient)];
        for (size_t i = 0; i < eyes_.size(); ++i)
            sum[eyes_.pixel[i]] += eyes_.throughput[i] * c_.shares->share[first + i];
    }

    /// Light of the columns in `row` that eye point i reflects.
    Rgb reflected(const SharedLights& lights, size_t i, const Word* row) const {
        const ShadingPoint& sp = eyes_.shading[i];
        return sp.kind == MaterialKind::kGlossy ? sum_row_glossy(lights, shade(i), sp, row)
                                                : sum_row(lights, shade(i), row) * (sp.base * (1 / kPi));
    }

    EyeShade shade(size_t i) const {
        return {eyes_.block.position[i], eyes_.shading[i].ng, eyes_.shading[i].ns};
    }

    void write(const Tile& tile, FrameResult& out) const {
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x) {
                const size_t from = size_t(y - tile.y0) * size_t(eyes_.width) + size_t(x - tile.x0);
                const size_t to = size_t(y) * size_t(out.width) + size_t(x);
                Rgb color = eyes_.emitted[from];
                for (int g = 0; g < kLightGroups; ++g)
                    if (!sums_[g].empty()) color += out.groups[g][to] = sums_[g][from];
                if (!out.last_pass.empty()) out.last_pass[to] = last_pass_[from];
                if (!unoccluded_.empty()) out.unoccluded[to] = unoccluded_[from];
                if (!out.variance.empty() && !variance_.empty()) out.variance[to] = variance_[from];
                out.color[to] = color;
                out.emitted[to] = eyes_.emitted[from];
                write_first_hits(eyes_.first[from], to, out);
            }
    }

    /// Writes means over the samples that hit, and the share of such samples.
    void write_first_hits(const FirstHits& first, size_t to, FrameResult& out) const {
        const float hits = float(first.count), share = first.count ? 1 / hits : 0.f;
        out.coverage[to] = hits / float(c_.frame.spp);
        out.depth[to] = first.depth * share;
        out.normal[to] = first.normal * share;
        out.albedo[to] = first.albedo * share;
    }

    const FrameContext& c_;
    std::unique_ptr<VisibilityOracle> oracle_;
    std::optional<QueryAudit> audit_;
    TilePicks picks_;
    EyeTile eyes_;
    BitMatrix wanted_;
    LightGroupSet inexact_;  ///< groups with answers that may be wrong
    std::vector<Word> one_;  ///< a row with one bit
    WeightedSamples local_;
    std::array<std::vector<Rgb>, kLightGroups> sums_;
    std::optional<EnvironmentProduct> product_;
    std::vector<Rgb> last_pass_;
    std::vector<Rgb> variance_;      ///< of corrections, per pixel; empty if there are none
    std::vector<float> unoccluded_;  ///< per pixel; empty if no audit draws pixels by it
};

FrameResult empty_result(const FrameContext& c, bool corrects) {
    FrameResult out;
    out.width = c.frame.width;
    out.height = c.frame.height;
    out.spp = c.frame.spp;
    const size_t n = size_t(out.width) * size_t(out.height);
    out.color.resize(n);
    out.emitted.resize(n);
    out.depth.resize(n);
    out.normal.resize(n);
    out.albedo.resize(n);
    out.coverage.resize(n);
    if (corrects) out.variance.resize(n);
    if (c.product && c.integrator.passes > 1) out.last_pass.resize(n);
    auto has = [&](LightGroup g) { out.groups[size_t(g)].resize(n); };
    for (const SharedLights& s : c.shared) has(LightGroup(s.ends.group));
    if (c.integrator.direct && !c.scene.area_lights().empty()) has(LightGroup::kArea);
    if (c.integrator.direct && c.scene.environment()) has(LightGroup::kEnvironment);
    if (c.integrator.ambient) has(LightGroup::kAmbient);
    return out;
}

/// Renders some of the pixels again by exact rays.
void audit_pixels(const FrameContext& c, std::span<const Tile> tiles, const Control& control,
                  FrameResult& out) {
    const double start = thread_cpu_seconds();
    const auto pixels = along_curve(tiles);
    const size_t all = out.color.size(), n = (c.frame.audit_pixels * pixels.size() + all - 1) / all;
    for (size_t p = out.unoccluded.size(); p < all; ++p)
        out.unoccluded.push_back(luminance(out.color[p] - out.emitted[p]));
    const auto drawn =
        draw_audit_pixels(pixels, out.unoccluded, size_t(out.width), n, c.frame.seed, c.frame.first_sample);
    out.stages.audit += thread_cpu_seconds() - start;

    FrameResult exact = empty_result(c, false);
    std::vector<std::pair<uint32_t, uint32_t>> once;  // a pixel may be drawn twice
    for (const AuditPixel& pixel : drawn) once.emplace_back(pixel.x, pixel.y);
    std::sort(once.begin(), once.end());
    once.erase(std::unique(once.begin(), once.end()), once.end());
    ExactSource source(c.scene, c.caster);
    std::vector<std::unique_ptr<TileWorker>> workers(size_t(out.threads));
    constexpr size_t kRun = 64;
    const size_t runs = (once.size() + kRun - 1) / kRun;
    std::vector<Counters> counted(runs);
    std::vector<double> seconds(runs);
    parallel_for(runs, out.threads, [&](size_t run, int worker) {
        control.check();
        const double begin = thread_cpu_seconds();
        auto& mine = workers[size_t(worker)];
        if (!mine) mine = std::make_unique<TileWorker>(c, source, control);
        StageSeconds stages;
        ProductSeconds product;
        for (size_t i = run * kRun; i < std::min(once.size(), (run + 1) * kRun); ++i) {
            const int x = int(once[i].first), y = int(once[i].second);
            mine->render(0, {x, y, x + 1, y + 1}, exact, counted[run], stages, product, nullptr, control);
        }
        seconds[run] = thread_cpu_seconds() - begin;
    });
    for (size_t run = 0; run < runs; ++run) {
        out.audit_rays += counted[run].rays();
        out.stages.audit += seconds[run];
    }
    for (const AuditPixel& pixel : drawn) {
        AuditedPixel& found = out.audited_pixels.emplace_back();
        found.weight = pixel.weight;
        for (size_t g = 0; g < kLightGroups; ++g)
            if (!out.groups[g].empty()) {
                const size_t p = size_t(pixel.y) * size_t(out.width) + pixel.x;
                found.error[g] = out.groups[g][p] - exact.groups[g][p];
            }
    }
}

/// Runs the pilot if a setting depends on it, and stores its result in the context.
void make_forecast(ProductContext& product, const EyePathTracer& tracer, OracleSource& source,
                   Counters& counters, const Control& control, FrameResult& out) {
    VisMapSettings& s = product.settings;
    const bool for_alpha = s.alpha.mode == AlphaMode::kPreviousPass && s.first_alpha == FirstAlpha::kPilot;
    if (s.replace || !(for_alpha || s.density() == DensityChoice::kAuto)) return;
    const double start = wall_seconds();
    out.forecast = forecast(product, tracer, source, tracer.frame.threads, counters, control);
    product.guided = out.forecast->guided;
    if (for_alpha) s.alpha.value = out.forecast->alpha;
    out.pilot_s = wall_seconds() - start;
}

}  // namespace

FrameResult render_frame(const Scene& scene, const RayCaster& caster, const Camera& camera,
                         const IntegratorSettings& integrator, const FrameSettings& frame,
                         OracleSource& source, Control& control, const EnvironmentMaps* maps,
                         const AlignedEngines* aligned, KeptLights* lights) {
    check_camera(camera);
    const FilmCamera film(camera, frame.width, frame.height);
    Counters counters;
    const double start = wall_seconds();
    FrameContext context{scene, caster, integrator, frame, {scene, caster, film, integrator, frame}, {}};
    const bool kept = lights && lights->groups;
    context.shared = kept ? *lights->groups
                          : make_shared_lights(scene, caster, film, integrator, frame, control, counters);
    if (source.corrects() && !kept) set_mean_light(context.shared, context.tracer, counters, control);
    if (lights) lights->groups = context.shared;
    std::optional<EnvironmentPyramid> light;
    std::optional<ProductContext> product;
    if (integrator.direct && scene.environment() && integrator.environment == EnvironmentSampling::kProduct &&
        integrator.n_environment > 0) {
        light.emplace(*scene.environment());
        product.emplace(*light, integrator, frame.seed, frame.width, maps ? &maps->source : nullptr,
                        maps ? maps->settings : VisMapSettings{});
        context.product = &*product;
    }
    FrameResult out = empty_result(context, source.corrects());
    if (frame.audit_pixels >= kLeastByUnoccluded) out.unoccluded.resize(out.color.size());
    out.lights_s = wall_seconds() - start;
    std::vector<const FarEnds*> groups;
    for (const SharedLights& s : context.shared) groups.push_back(&s.ends);
    const auto render = [&](const FrameSettings& small, OracleSource& asked, Control& c) {
        return render_frame(scene, caster, camera, integrator, small, asked, c);
    };
    RenderedStart begin(frame, std::move(groups), out, render, integrator.pick);
    const double preparing = wall_seconds();
    source.prepare(begin, control);
    out.prepare_s = wall_seconds() - preparing;
    if (product && maps) make_forecast(*product, context.tracer, source, counters, control, out);

    bool directions = false;
    for (const SharedLights& s : context.shared) {
        directions |= s.ends.semantic == Semantic::kDirection && s.ends.count >= kManyDirections;
        if (s.ends.group == int(LightGroup::kVpl)) out.n_vpls = s.ends.count;
    }
    // The tiles do not depend on the oracles, so that any oracle can answer the recorded queries of a frame
    const TileRule& rule = directions ? kTilesOfDirections : kTiles;
    const int dealt = source.dealt_tile_edge();
    out.tile_edge_px = dealt ? dealt : tile_edge(rule, frame.width, frame.height, frame.spp);
    const auto tiles =
        tiles_of_part(cut_tiles(frame.width, frame.height, out.tile_edge_px), frame.part, frame.parts);
    if (frame.part > 0) counters = out.counters = {};  // the first part counts the work that all parts repeat
    out.threads = std::min<int>(resolve_threads(frame.threads), int(std::max<size_t>(1, tiles.size())));
    std::optional<AmbientShares> shares;
    if (integrator.ambient && integrator.ambient_directions == AmbientDirections::kShared) {
        control.total = size_t(integrator.n_ambient);
        shares.emplace(aligned_ambient(context.tracer, tiles, *aligned, frame.threads, control));
        context.shares = &*shares;
        out.aligned = shares->choice;
        out.aligned_s = shares->trace_s;
        counters.merge(shares->counters);
        control.done = 0;
    }
    control.total = tiles.size();

    // Tiles write disjoint pixels. Counters are merged in the order of the tiles
    std::vector<std::unique_ptr<TileWorker>> workers(size_t(out.threads));
    std::vector<Counters> counted(tiles.size());
    std::vector<StageSeconds> stages(tiles.size());
    std::vector<ProductSeconds> product_stages(tiles.size());
    if (frame.audit_share > 0) out.audited_queries.resize(tiles.size());
    const auto render_tile = [&](size_t i, int worker) {
        control.check();
        auto& mine = workers[size_t(worker)];
        if (!mine) mine = std::make_unique<TileWorker>(context, source, control);
        mine->render(i, tiles[i], out, counted[i], stages[i], product_stages[i],
                     out.audited_queries.empty() ? nullptr : &out.audited_queries[i], control);
        source.end_item(mine->oracle(), i);
        control.done.fetch_add(1);
    };
    source.begin_round(tiles.size());
    if (dealt)
        parallel_for(size_t(out.threads), out.threads, [&](size_t share, int) {
            for (size_t i = share; i < tiles.size(); i += size_t(out.threads)) render_tile(i, int(share));
        });
    else
        parallel_for(tiles.size(), out.threads, render_tile);
    if (frame.parts > 1)
        for (size_t i = 0; i < tiles.size(); ++i)
            out.tile_sums.push_back({counted[i].lost_throughput, counted[i].expected_false_hits});
    for (size_t i = 0; i < tiles.size(); ++i) {
        counters.merge(counted[i]);
        out.stages.merge(stages[i]);
        out.product.merge(product_stages[i]);
    }
    const auto is_exact = [](const auto& worker) { return !worker || worker->all_exact(); };
    if (frame.audit_pixels > 0 && !std::all_of(workers.begin(), workers.end(), is_exact))
        audit_pixels(context, tiles, control, out);
    if (maps && maps->source.records > 0 && product) {
        out.tally.emplace(maps->source.records);
        for (const auto& worker : workers)
            if (worker) out.tally->merge(*worker->tally());
    }
    source.end_round(counters);
    out.counters.merge(counters);
    source.report(out.counters, out.source);
    out.tiles_s = wall_seconds() - start - out.lights_s - out.prepare_s - out.pilot_s;
    return out;
}

}  // namespace viscache
