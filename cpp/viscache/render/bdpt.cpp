#include "viscache/render/bdpt.h"

#include <numeric>

#include "viscache/math/wall_clock.h"
#include "viscache/render/connections.h"
#include "viscache/render/frame_start.h"
#include "viscache/render/stage_clock.h"
#include "viscache/scene/check.h"

namespace viscache {

namespace {

constexpr int kPathTileEdge = 16;      // in pixels; a work item is one sample of every pixel of a tile
constexpr size_t kFirstRound = 4;      // items in the first round; later rounds grow
constexpr size_t kItemsPerRound = 64;  // up to this size

/// One work item's contribution to the frame. It is kept until the end of its round, because light paths
/// may fall on pixels of other items.
struct ItemResult {
    EyeLight light;
    std::array<std::vector<Rgb>, kLightGroups> sums;  ///< per pixel of the tile
    std::vector<std::pair<uint32_t, Rgb>> splats;     ///< on pixels of the frame, in order
    Counters counters;
    StageSeconds stages;
};

/// Renders items on one thread. Its buffers are reused.
class ItemWorker {
public:
    ItemWorker(const BdptContext& context, std::unique_ptr<VisibilityOracle> oracle, const Control& control)
        : c_(context), tracer_(context), oracle_(std::move(oracle)) {
        oracle_->watch(control);
    }
    VisibilityOracle& oracle() { return *oracle_; }

    void run(const SampleTile& work, const FrameResult& frame, ItemResult& out, const Control& control) {
        StageClock clock;
        out.counters = {};
        out.stages = {};
        out.splats.clear();
        // Both kinds of sub-paths first: rays of many paths are traced together
        tracer_.trace_light(work, light_paths_, out.counters, control);
        tracer_.trace_eye(work, eye_paths_, out.light, out.counters, control);
        clock.lap(out.stages.eye_paths);
        const size_t pixels = out.light.emitted.size();
        for (size_t g = 0; g < out.sums.size(); ++g)
            // Light on the camera goes to splats, whose pixels are those of the frame
            out.sums[g].assign(frame.groups[g].empty() || g == size_t(LightGroup::kCamera) ? 0 : pixels, {});
        connections_.clear();
        Connector connector(c_, connections_, out.counters);
        const int width = work.tile.x1 - work.tile.x0;
        // Paths are numbered along the curve, so consecutive ones have neighbouring eye points
        const auto places = morton_pixels(width, work.tile.y1 - work.tile.y0);
        for (size_t p = 0; p < places.size(); ++p)
            // One eye path with the light path of the same number (N_P = N_S)
            connector.join(eye_paths_, light_paths_, p,
                           uint32_t(places[p].second) * uint32_t(width) + places[p].first);
        clock.lap(out.stages.contributions);
        // All connections of an item in one call, so that the oracle can sort them
        oracle_->begin_tile(connections_.eyes);
        const Answer answer = oracle_->pairs({connections_.eyes, connections_.queries}, out.counters);
        clock.lap(out.stages.visibility);
        add(answer, out);
        clock.lap(out.stages.shading);
    }

private:
    void add(const Answer& answer, ItemResult& out) {
        for_each_bit(answer.row(0), [&](size_t i) {
            const float weight = answer.weights.empty() ? 1.f : answer.weights[i];
            const Rgb value = connections_.contribution[i] * weight;
            const uint32_t pixel = connections_.pixel[i];
            const uint8_t group = connections_.queries[i].group;
            if (group == uint8_t(LightGroup::kCamera))
                // In the order of the connections, which is the same for any number of threads
                out.splats.emplace_back(pixel, value);
            else
                out.sums[group][pixel] += value;
        });
    }

    const BdptContext& c_;
    SubpathTracer tracer_;
    std::unique_ptr<VisibilityOracle> oracle_;
    Subpaths eye_paths_, light_paths_;
    Connections connections_;
};

FrameResult empty_bdpt_result(const BdptContext& c) {
    FrameResult out = sized_result(c.frame);
    const size_t n = out.color.size();
    out.seen_emitters.resize(n);
    auto has = [&](LightGroup g, bool there) {
        if (there) out.groups[size_t(g)].resize(n);
    };
    const SceneDescription& d = c.scene.description();
    // A group exists if the scene and the length of paths can bring it light; a frame shows no
    // empty layers
    const bool lit = !c.lights.empty();
    has(LightGroup::kPoint, !d.point_lights.empty());
    has(LightGroup::kDirectional, !d.directional_lights.empty());
    has(LightGroup::kArea, !c.scene.area_lights().empty());
    has(LightGroup::kEnvironment, c.scene.environment() != nullptr);
    has(LightGroup::kConnection, lit && c.settings.max_depth > 2);
    has(LightGroup::kCamera, lit && c.settings.max_depth > 1 && c.to_camera());
    return out;
}

void merge(const ItemResult& item, const Tile& tile, FrameResult& out) {
    // Several samples of a tile are separate items, so their light adds up here
    const size_t width = size_t(tile.x1 - tile.x0);
    for (int y = tile.y0; y < tile.y1; ++y)
        for (int x = tile.x0; x < tile.x1; ++x) {
            const size_t from = size_t(y - tile.y0) * width + size_t(x - tile.x0);
            const size_t to = size_t(y) * size_t(out.width) + size_t(x);
            out.emitted[to] += item.light.emitted[from];
            out.seen_emitters[to] += item.light.seen[from];
            for (size_t g = 0; g < item.sums.size(); ++g)
                if (!item.sums[g].empty()) out.groups[g][to] += item.sums[g][from];
            const FirstHits& first = item.light.first[from];
            out.coverage[to] += float(first.count);
            out.depth[to] += first.depth;
            out.normal[to] += first.normal;
            out.albedo[to] += first.albedo;
        }
    // Last, in a fixed order: the sum of a pixel depends on it in its last bits
    for (const auto& [pixel, value] : item.splats) out.groups[size_t(LightGroup::kCamera)][pixel] += value;
    out.counters.merge(item.counters);
    out.stages.merge(item.stages);
}

/// Turns sums into colours and means.
void finish(FrameResult& out) {
    for (size_t i = 0; i < out.color.size(); ++i) {
        out.color[i] = out.emitted[i];
        for (const auto& group : out.groups)
            if (!group.empty()) out.color[i] += group[i];
        // First hits are means over the samples that hit anything; light was divided by all samples
        // before
        const float hits = out.coverage[i], share = hits > 0 ? 1 / hits : 0.f;
        out.coverage[i] = hits / float(out.spp);
        out.depth[i] *= share;
        out.normal[i] = out.normal[i] * share;
        out.albedo[i] = out.albedo[i] * share;
    }
}

/// The order of the items: sample by sample. Within a sample, tiles follow each other in steps of the golden
/// ratio, so that the first samples of a cluster are spread over it.
SampleTile item_at(size_t number, const std::vector<Tile>& tiles) {
    // Coprime to the number of tiles, so that the steps visit each of them once
    size_t step = std::max<size_t>(1, size_t(0.6180339887 * double(tiles.size())));
    while (std::gcd(step, tiles.size()) != 1) ++step;
    return {tiles[number % tiles.size() * step % tiles.size()], uint32_t(number / tiles.size())};
}

}  // namespace

FrameResult render_bdpt(const Scene& scene, const RayCaster& caster, const Camera& camera,
                        const BdptSettings& settings, const FrameSettings& frame, OracleSource& source,
                        Control& control) {
    // Before anything is made: an error names the camera, not what follows from it
    check_camera(camera);
    const double start = wall_seconds();
    const LightSampler lights(scene);
    const BdptContext context{scene,    caster, lights, FilmCamera(camera, frame.width, frame.height),
                              settings, frame};
    FrameResult out = empty_bdpt_result(context);
    out.tile_edge_px = kPathTileEdge;
    const auto tiles = cut_tiles(frame.width, frame.height, kPathTileEdge);
    const size_t items = tiles.size() * size_t(frame.spp);
    // More threads than items of a round would have nothing to do
    out.threads = std::min<int>(resolve_threads(frame.threads), int(std::min(items, kItemsPerRound)));
    std::vector<std::unique_ptr<ItemWorker>> workers(size_t(out.threads));
    // One slot per item of a round, reused from round to round
    std::vector<ItemResult> results(kItemsPerRound);
    out.lights_s = wall_seconds() - start;
    // For sources that learn from a small frame of the same view
    const auto render = [&](const FrameSettings& small, OracleSource& asked, Control& c) {
        return render_bdpt(scene, caster, camera, settings, small, asked, c);
    };
    RenderedStart begin(frame, {}, out, render);  // no light is shared
    source.prepare(begin, control);
    out.prepare_s = wall_seconds() - start - out.lights_s;
    control.total = items;

    size_t first = 0;
    // What the cache learns in the first rounds saves rays in all later ones, so the first are short;
    // long rounds keep all threads busy. Sizes depend on the number of items alone, and so do answers
    for (size_t size = kFirstRound; first < items; first += size, size += size / 2) {
        size = std::min({size, kItemsPerRound, items - first});
        source.begin_round(size);
        parallel_for(size, out.threads, [&](size_t i, int worker) {
            control.check();
            auto& mine = workers[size_t(worker)];
            // Made on the thread that uses it, when its first item comes
            if (!mine) mine = std::make_unique<ItemWorker>(context, source.make(), control);
            mine->run(item_at(first + i, tiles), out, results[i], control);
            source.end_item(mine->oracle(), i);
            control.done.fetch_add(1);
        });
        // Merge in the order of the items, so that the result does not depend on threads
        source.end_round(out.counters);
        for (size_t i = 0; i < size; ++i) merge(results[i], item_at(first + i, tiles).tile, out);
    }
    finish(out);
    source.report(out.counters, out.source);
    out.tiles_s = wall_seconds() - start - out.lights_s - out.prepare_s;
    return out;
}

}  // namespace viscache
