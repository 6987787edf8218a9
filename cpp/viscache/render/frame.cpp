#include "viscache/render/frame.h"

#include <algorithm>

#include "viscache/math/wall_clock.h"
#include "viscache/oracles/exact_source.h"
#include "viscache/render/audit_pixels.h"
#include "viscache/render/estimators.h"
#include "viscache/render/frame_start.h"
#include "viscache/scene/check.h"

namespace viscache {

namespace {

constexpr size_t kManyDirections = 16;  // that all eye points share, for tiles of directions

/// Renders tiles on one thread: traces the eye points of a tile, lets the estimators add their light, and
/// writes the pixels. Its buffers are reused.
class TileWorker {
public:
    TileWorker(const FrameContext& context, OracleSource& source, const Control& control)
        : oracle_(source.make()),
          work_{.frame = context, .oracle = *oracle_, .control = control},
          estimators_(make_estimators(context)) {
        oracle_->watch(control);
        if (context.frame.audit_share > 0)
            work_.audit = &audit_.emplace(context.frame, context.caster, control);
    }

    void render(size_t number, const Tile& tile, FrameResult& out, TileRecord& record) {
        EyeTile& eyes = work_.eyes;
        // The first lap counts from here: what lies between two tiles belongs to no stage
        work_.clock.skip();
        work_.tile = tile;
        work_.number = number;
        work_.frame.trace(tile, eyes, record.counters, work_.control);
        work_.clock.lap(record.stages.eye_paths);
        work_.sums.begin(out, work_.pixels());
        // Records and replays of queries know tiles by their number in the frame
        eyes.block.tile = number;
        // Some oracles sort or index the points of the tile here, which is time of visibility
        oracle_->begin_tile(eyes.block);
        work_.clock.lap(record.stages.visibility);
        // The audit sees the same tile beside the oracle and never changes what the pixels get
        if (audit_) audit_->begin_tile(eyes);
        work_.clock.lap(record.stages.audit);
        // In a fixed order, because it decides the last bits of a pixel
        for (const auto& estimator : estimators_) estimator->add(work_, record);
        if (audit_) audit_->end_tile(record.audit);
        work_.clock.skip();
        write(out);
        work_.clock.lap(record.stages.shading);
    }

    VisibilityOracle& oracle() { return *oracle_; }
    /// True if exact rays answered all queries of this thread.
    bool all_exact() const { return work_.inexact.none(); }
    /// After all tiles.
    void end(FrameResult& out) const {
        for (const auto& estimator : estimators_) estimator->end(out);
    }

private:
    void write(FrameResult& out) const {
        const Tile& tile = work_.tile;
        const EyeTile& eyes = work_.eyes;
        const PixelSums& sums = work_.sums;
        for (int y = tile.y0; y < tile.y1; ++y)
            for (int x = tile.x0; x < tile.x1; ++x) {
                const size_t from = size_t(y - tile.y0) * size_t(eyes.width) + size_t(x - tile.x0);
                const size_t to = size_t(y) * size_t(out.width) + size_t(x);
                // Each pixel belongs to one tile, so threads write without a lock. Groups are added
                // in their order
                Rgb color = eyes.emitted[from];
                for (int g = 0; g < kLightGroups; ++g)
                    if (!sums.groups[g].empty()) color += out.groups[g][to] = sums.groups[g][from];
                if (!out.last_pass.empty()) out.last_pass[to] = sums.last_pass[from];
                if (!out.unoccluded.empty()) out.unoccluded[to] = sums.unoccluded[from];
                if (!out.variance.empty()) out.variance[to] = sums.variance[from];
                out.color[to] = color;
                out.emitted[to] = eyes.emitted[from];
                write_first_hits(eyes.first[from], to, out);
            }
    }

    /// Writes means over the samples that hit, and the share of such samples.
    void write_first_hits(const FirstHits& first, size_t to, FrameResult& out) const {
        const float hits = float(first.count), share = first.count ? 1 / hits : 0.f;
        out.coverage[to] = hits / float(work_.frame.frame.spp);
        out.depth[to] = first.depth * share;
        out.normal[to] = first.normal * share;
        out.albedo[to] = first.albedo * share;
    }

    std::unique_ptr<VisibilityOracle> oracle_;
    std::optional<QueryAudit> audit_;
    TileWork work_;
    std::vector<std::unique_ptr<Estimator>> estimators_;
};

FrameResult empty_result(const FrameContext& c, bool corrects) {
    FrameResult out = sized_result(c.frame);
    const size_t n = out.color.size();
    // Layers that nothing would fill stay empty, and frames then have no such layer
    if (corrects) out.variance.resize(n);
    if (c.product && c.integrator.passes > 1) out.last_pass.resize(n);
    auto has = [&](LightGroup g) { out.groups[size_t(g)].resize(n); };
    // The same groups for every part and every oracle of a frame, so that layers can be compared
    // and merged
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
    // A part draws its share of the pixels, rounded up
    const size_t all = out.color.size(), n = (c.frame.audit_pixels * pixels.size() + all - 1) / all;
    // Few audited pixels: the light that the frame has takes the place of light without shadows
    for (size_t p = out.unoccluded.size(); p < all; ++p)
        out.unoccluded.push_back(luminance(out.color[p] - out.emitted[p]));
    const auto drawn =
        draw_audit_pixels(pixels, out.unoccluded, size_t(out.width), n, c.frame.seed, c.frame.first_sample);
    out.stages.audit += thread_cpu_seconds() - start;

    // The same estimators write into a frame of their own, from which only audited pixels are read
    FrameResult exact = empty_result(c, false);
    std::vector<std::pair<uint32_t, uint32_t>> once;  // a pixel may be drawn twice
    for (const AuditPixel& pixel : drawn) once.emplace_back(pixel.x, pixel.y);
    std::sort(once.begin(), once.end());
    once.erase(std::unique(once.begin(), once.end()), once.end());
    ExactSource source(c.caster);
    std::vector<std::unique_ptr<TileWorker>> workers(size_t(out.threads));
    // Pixels along the curve in runs: tiles of one pixel are short work items
    constexpr size_t kRun = 64;
    const size_t runs = (once.size() + kRun - 1) / kRun;
    std::vector<TileRecord> records(runs);
    std::vector<double> seconds(runs);
    parallel_for(runs, out.threads, [&](size_t run, int worker) {
        control.check();
        const double begin = thread_cpu_seconds();
        auto& mine = workers[size_t(worker)];
        if (!mine) mine = std::make_unique<TileWorker>(c, source, control);
        for (size_t i = run * kRun; i < std::min(once.size(), (run + 1) * kRun); ++i) {
            const int x = int(once[i].first), y = int(once[i].second);
            // A tile of one pixel has the samples of that pixel in the frame, so both differ by
            // visibility alone
            mine->render(0, {x, y, x + 1, y + 1}, exact, records[run]);
        }
        seconds[run] = thread_cpu_seconds() - begin;
    });
    // Rays and time of an audit are reported apart: they are no part of the frame's cost
    for (size_t run = 0; run < runs; ++run) {
        out.audit_rays += records[run].counters.rays();
        out.stages.audit += seconds[run];
    }
    for (const AuditPixel& pixel : drawn) {
        AuditedPixel& found = out.audited_pixels.emplace_back();
        found.weight = pixel.weight;
        for (size_t g = 0; g < kLightGroups; ++g)
            if (!out.groups[g].empty()) {
                const size_t p = size_t(pixel.y) * size_t(out.width) + pixel.x;
                // By group, because a cache may be right about one kind of light and wrong about
                // another
                found.error[g] = out.groups[g][p] - exact.groups[g][p];
            }
    }
}

/// Runs the pilot if a setting depends on it, and stores its result in the context.
void make_forecast(ProductContext& product, const EyePathTracer& tracer, OracleSource& source,
                   Counters& counters, const Control& control, FrameResult& out) {
    VisMapSettings& s = product.settings;
    // Without a setting that needs it, the pilot's rays are saved
    const bool for_alpha = s.alpha.mode == AlphaMode::kPreviousPass && s.first_alpha == FirstAlpha::kPilot;
    if (s.replace || !(for_alpha || s.density() == DensityChoice::kAuto)) return;
    const double start = wall_seconds();
    out.forecast = forecast(product, tracer, source, tracer.frame.threads, counters, control);
    product.guided = out.forecast->guided;
    // Before the first tile, so that all tiles have the same α
    if (for_alpha) s.alpha.value = out.forecast->alpha;
    out.pilot_s = wall_seconds() - start;
}

/// Cuts the frame, or its part, into tiles. They do not depend on the oracles, so that any oracle can answer
/// the recorded queries of a frame.
std::vector<Tile> make_tiles(const FrameContext& c, int dealt_edge, FrameResult& out) {
    bool directions = false;
    for (const SharedLights& s : c.shared) {
        // A sky of many shared directions wants large tiles, whichever engine answers it in the end
        directions |= s.ends.semantic == Semantic::kDirection && s.ends.count >= kManyDirections;
        if (s.ends.group == int(LightGroup::kVpl)) out.n_vpls = s.ends.count;
    }
    const FrameSettings& f = c.frame;
    const TileRule& rule = directions ? kTilesOfDirections : kTiles;
    // The paper's form deals fixed tiles to its threads; a frame has one size of tiles for all of
    // its parts
    out.tile_edge_px = dealt_edge ? dealt_edge : tile_edge(rule, f.width, f.height, f.spp);
    // Parts interleave tiles, so each has about the same work
    const auto tiles = tiles_of_part(cut_tiles(f.width, f.height, out.tile_edge_px), f.part, f.parts);
    out.threads = std::min<int>(resolve_threads(f.threads), int(std::max<size_t>(1, tiles.size())));
    return tiles;
}

using Workers = std::vector<std::unique_ptr<TileWorker>>;  // by thread; nullptr: it had no tile

/// Renders all tiles as one round of the source, and merges what they leave in the order of the tiles.
Workers render_tiles(const FrameContext& c, std::span<const Tile> tiles, OracleSource& source,
                     Counters& counters, FrameResult& out, Control& control) {
    Workers workers(size_t(out.threads));
    std::vector<TileRecord> records(tiles.size());
    const auto render_tile = [&](size_t i, int worker) {
        control.check();
        auto& mine = workers[size_t(worker)];
        if (!mine) mine = std::make_unique<TileWorker>(c, source, control);
        mine->render(i, tiles[i], out, records[i]);
        source.end_item(mine->oracle(), i);
        control.done.fetch_add(1);
    };
    // Progress counts tiles; a preparation before may have counted in other units
    control.total = tiles.size();
    source.begin_round(tiles.size());
    // Tables that live through all tiles of a thread need them dealt in a fixed way, not taken as
    // threads become free
    if (source.dealt_tile_edge())
        parallel_for(size_t(out.threads), out.threads, [&](size_t share, int) {
            for (size_t i = share; i < tiles.size(); i += size_t(out.threads)) render_tile(i, int(share));
        });
    else
        parallel_for(tiles.size(), out.threads, render_tile);
    // Counters and sums are merged by tile, so they are the same for any number of threads
    for (const TileRecord& tile : records) {
        if (c.frame.parts > 1)
            // Real sums of a whole frame are added tile by tile: whoever merges parts repeats that
            // order
            out.tile_sums.push_back({tile.counters.lost_throughput, tile.counters.expected_false_hits});
        if (c.frame.audit_share > 0) out.audited_queries.push_back(tile.audit);
        counters.merge(tile.counters);
        out.stages.merge(tile.stages);
        out.product.merge(tile.product);
    }
    return workers;
}

}  // namespace

FrameResult sized_result(const FrameSettings& frame) {
    FrameResult out;
    out.width = frame.width;
    out.height = frame.height;
    out.spp = frame.spp;
    const size_t n = size_t(out.width) * size_t(out.height);
    for (auto* layer : {&out.color, &out.emitted, &out.normal, &out.albedo}) layer->resize(n);
    for (auto* layer : {&out.depth, &out.coverage}) layer->resize(n);
    return out;
}

FrameResult render_frame(const Scene& scene, const RayCaster& caster, const Camera& camera,
                         const IntegratorSettings& integrator, const FrameSettings& frame,
                         OracleSource& source, Control& control, const EnvironmentMaps* maps,
                         const AlignedEngines* aligned, KeptLights* lights) {
    check_camera(camera);
    const FilmCamera film(camera, frame.width, frame.height);
    Counters counters;
    const double start = wall_seconds();
    // Lights, and what else all tiles share
    FrameContext context{{scene, caster, film, integrator, frame}, {}};
    // Passes of a progressive frame may share their lights, whose tracing would repeat
    const bool kept = lights && lights->groups;
    context.shared = kept ? *lights->groups
                          : make_shared_lights(scene, caster, film, integrator, frame, control, counters);
    // Shares of corrections need the mean light; it is kept with the lights
    if (source.corrects() && !kept) set_mean_light(context.shared, context, counters, control);
    if (lights) lights->groups = context.shared;
    std::optional<EnvironmentPyramid> light;
    std::optional<ProductContext> product;
    if (integrator.direct && scene.environment() && integrator.environment == EnvironmentSampling::kProduct &&
        integrator.n_environment > 0) {
        // The pyramid of the environment is only built for product sampling
        light.emplace(*scene.environment());
        product.emplace(ProductContext{*light, integrator, frame.seed, frame.width,
                                       maps ? &maps->source : nullptr,
                                       maps ? maps->settings : VisMapSettings{}});
        context.product = &*product;
    }
    FrameResult out = empty_result(context, source.corrects());
    // Light without shadows is computed while tiles are shaded, if enough pixels will be drawn by
    // it
    if (frame.audit_pixels >= kLeastByUnoccluded) out.unoccluded.resize(out.color.size());
    out.lights_s = wall_seconds() - start;
    // The source's own preparation, which may render a small frame
    // Sources see the far ends alone: what lights bring is no business of theirs
    std::vector<const FarEnds*> groups;
    for (const SharedLights& s : context.shared) groups.push_back(&s.ends);
    const auto render = [&](const FrameSettings& small, OracleSource& asked, Control& c) {
        return render_frame(scene, caster, camera, integrator, small, asked, c);
    };
    RenderedStart begin(frame, std::move(groups), out, render, integrator.pick);
    const double preparing = wall_seconds();
    source.prepare(begin, control);
    out.prepare_s = wall_seconds() - preparing;
    // After the source is ready, because the pilot asks its oracles
    if (product && maps) make_forecast(*product, context, source, counters, control, out);
    // The tiles, after rays of ambient occlusion that they share
    const auto tiles = make_tiles(context, source.dealt_tile_edge(), out);
    if (frame.part > 0) counters = out.counters = {};  // the first part counts the work that all parts repeat
    std::optional<AmbientShares> shares;
    if (integrator.ambient && integrator.ambient_directions == AmbientDirections::kShared) {
        control.total = size_t(integrator.n_ambient);
        // All points of the frame at once, because the batch pays only for many points
        shares.emplace(aligned_ambient(context, tiles, *aligned, frame.threads, control));
        context.shares = &*shares;
        out.aligned = shares->choice;
        out.aligned_s = shares->trace_s;
        counters.merge(shares->counters);
        // Its progress counted directions, that of the frame counts tiles
        control.done = 0;
    }
    const Workers workers = render_tiles(context, tiles, source, counters, out, control);
    const auto is_exact = [](const auto& worker) { return !worker || worker->all_exact(); };
    // A frame of exact rays has no error to look for
    if (frame.audit_pixels > 0 && !std::ranges::all_of(workers, is_exact))
        audit_pixels(context, tiles, control, out);
    // Made before `end`, in which each worker adds its own
    if (maps && maps->source.records > 0 && product) out.tally.emplace(maps->source.records);
    for (const auto& worker : workers)
        if (worker) worker->end(out);
    // After all tiles: what the source has learnt is stored in the order of the items
    source.end_round(counters);
    out.counters.merge(counters);
    source.report(out.counters, out.source);
    out.tiles_s = wall_seconds() - start - out.lights_s - out.prepare_s - out.pilot_s;
    return out;
}

}  // namespace viscache
