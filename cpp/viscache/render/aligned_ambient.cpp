#include "viscache/render/aligned_ambient.h"

#include <chrono>

#include "viscache/math/isa_variants.h"
#include "viscache/vlf/field_rows.h"

namespace viscache {

namespace {

// 144 MiB: enough points for the batch to pay, without memory that grows with the frame
constexpr size_t kWordsPerRun = size_t{9} << 21;  // rows that are kept at a time, in words

struct Points {
    std::vector<Vec3> origin, normal;
};

/// The eye points of tiles [first, last), one list per tile.
std::vector<Points> eye_points(const EyePathTracer& tracer, std::span<const Tile> tiles, int threads,
                               Control& control) {
    std::vector<Points> found(tiles.size());
    std::vector<EyeTile> traced(size_t(resolve_threads(threads)));
    // All engines start from the points of the batch, except where it would lose shadows: there it must be
    // asked for by name
    const bool by_size =
        !tracer.scene.is_coarse() || tracer.integrator.ambient_engine == AmbientEngine::kBatch;
    parallel_for(tiles.size(), threads, [&](size_t i, int worker) {
        control.check();
        // Only origins and normals are kept: with all the data of shading, the points of a frame
        // would take many times the memory
        Counters unused;  // shading traces the tiles again and counts there
        EyeTile& tile = traced[size_t(worker)];
        tracer.trace(tiles[i], tile, unused, control);
        // Each tile has a slot of its own, so their order does not depend on threads
        const EyeBlock& eyes = tile.block;
        found[i] = {by_size ? spawned(eyes.position, eyes.normal, aligned_extent(tracer.scene)) : eyes.origin,
                    eyes.normal};
    });
    return found;
}

void append(std::vector<Vec3>& to, const std::vector<Vec3>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

/// Traces the rows of some points with the engine that was asked for or chosen.
EngineChoice trace(const AlignedEngines& engines, AmbientEngine wish, AlignedInput input,
                   std::span<Word> rows, int threads, Control& control) {
    EngineChoice choice;
    // The field walks its own tiles and needs no order of points
    if (wish == AmbientEngine::kField) {
        field_rows(*engines.field, input, rows, threads, control);
        choice.engine = AlignedEngine::kField;
        return choice;
    }
    // Neighbours in space share packets in both other engines; the choice between them needs that
    // order as well
    const std::vector<uint32_t> sorted = kd_order(input.origin, control);
    input.order = sorted;
    // `kBatch` is the default of the choice, so what was asked for by name falls through
    if (wish == AmbientEngine::kEmbree || !engines.batch)
        choice.engine = AlignedEngine::kEmbree;
    else if (wish == AmbientEngine::kAuto)
        choice = choose_engine(*engines.batch, input, threads, control);
    if (choice.engine == AlignedEngine::kBatch) {
        engines.batch->rows(input, rows, threads, control);
    } else {
        const auto order = embree_order(engines.embree.scene().placed_triangles(), input.origin.size());
        embree_rows(engines.embree, input, rows, order, 16, std::nullopt, threads, control);
    }
    return choice;
}

}  // namespace

DirectionCells::DirectionCells(const Directions& directions) : count(directions.size()) {
    // Whole words: `sum_shares` reads blocks of 16, and cells of weight 0 add nothing
    for (std::vector<float>* v : {&x, &y, &z, &weight}) v->resize(words_for(count) * kWordBits);
    for (size_t k = 0; k < count; ++k) {
        const Vec3 w = directions.axes()[k];
        x[k] = w.x;
        y[k] = w.y;
        z[k] = w.z;
        weight[k] = directions.weights()[k];
    }
}

namespace {

/// Body of `free_share`. It is compiled once per instruction set, with the same operations in the same order.
[[gnu::always_inline]] inline float sum_shares(const DirectionCells& cells, Vec3 normal,
                                               std::span<const Word> row) {
    constexpr size_t kSums = 16;  // independent sums, which the compiler vectorises
    float seen[kSums] = {}, all[kSums] = {};
    for (size_t first = 0; first < cells.count; first += kSums) {
        // Bits of the block's 16 directions, in the low end
        const auto bits = int32_t(row[first / kWordBits] >> (first % kWordBits) & 0xffff);
        for (size_t j = 0; j < kSums; ++j) {
            const size_t k = first + j;
            const float cosine = cells.x[k] * normal.x + cells.y[k] * normal.y + cells.z[k] * normal.z;
            // The absolute value: an axis stands for both of its ends, of which the one above the
            // surface is traced
            const float part = std::fabs(cosine) * cells.weight[k];
            // The same sum without visibility: dividing by it removes the error of the quadrature
            // for this normal, so a free point has exactly 1
            all[j] += part;
            seen[j] += bits & (1 << j) ? part : 0.f;
        }
    }
    // In the order of the lanes, whatever the instruction set
    for (size_t j = 1; j < kSums; ++j) {
        seen[0] += seen[j];
        all[0] += all[j];
    }
    return all[0] > 0 ? seen[0] / all[0] : 0.f;
}

}  // namespace

float free_share(const DirectionCells& cells, Vec3 normal, std::span<const Word> row) {
    return variant_of<sum_shares>(std::min(active_isa(), Isa::kAvx2))(cells, normal, row);
}

AmbientShares aligned_ambient(const EyePathTracer& tracer, const std::vector<Tile>& tiles,
                              const AlignedEngines& engines, int threads, Control& control) {
    const IntegratorSettings& s = tracer.integrator;
    const Directions& directions = directions_of(uint32_t(s.n_ambient));
    const DirectionCells cells(directions);
    // As many points as fit in a run, at least one tile
    const size_t words = words_for(directions.size()), most = std::max<size_t>(1, kWordsPerRun / words);
    const std::vector<Points> points = eye_points(tracer, tiles, threads, control);
    AmbientShares out;
    auto& counted = out.counters.groups[size_t(LightGroup::kAmbient)];
    const auto start = std::chrono::steady_clock::now();
    for (size_t tile = 0; tile < tiles.size();) {
        Points run;
        const size_t before = out.share.size();
        // Whole tiles, so that the points of a tile are consecutive in `share`
        for (; tile < tiles.size() && run.origin.size() < most; ++tile) {
            out.first.push_back(before + run.origin.size());
            append(run.origin, points[tile].origin);
            append(run.normal, points[tile].normal);
        }
        // A reach of 0 stands for rays without an end
        const float t_max = s.ambient_reach.distance > 0 ? float(s.ambient_reach.distance) : kInfinity;
        std::vector<Word> rows(run.origin.size() * words);
        const EngineChoice choice =
            trace(engines, s.ambient_engine, {run.origin, run.normal, directions.frames(), t_max, {}}, rows,
                  threads, control);
        // Reported once: the runs of one frame are alike
        if (before == 0) out.choice = choice;
        out.share.resize(before + run.origin.size());
        // Rows become shares at once, and the memory of the rows is reused by the next run
        constexpr size_t kChunk = 4096;
        parallel_for((run.origin.size() + kChunk - 1) / kChunk, threads, [&](size_t chunk, int) {
            control.check();
            const size_t last = std::min(run.origin.size(), (chunk + 1) * kChunk);
            for (size_t i = chunk * kChunk; i < last; ++i)
                out.share[before + i] =
                    free_share(cells, run.normal[i], std::span(rows).subspan(i * words, words));
        });
        // Free bits now, all queries at the end: occluded = queries − free, in unsigned arithmetic
        // that wraps around and back
        for (Word w : rows) counted.occluded -= uint64_t(std::popcount(w));
        counted.queries += run.origin.size() * directions.size();
    }
    counted.rays = counted.queries;
    counted.occluded += counted.queries;
    out.trace_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return out;
}

}  // namespace viscache
