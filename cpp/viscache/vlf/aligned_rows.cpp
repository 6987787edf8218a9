#include "viscache/vlf/aligned_rows.h"

#include <numeric>

namespace viscache {

// Bounds the memory: the bits of a run are held for all directions at once, as rows and as columns.
namespace {
constexpr size_t kPointsPerRun = size_t{1} << 14;
}

AlignedRows aligned_rows(const AlignedBatch& batch, const RayCaster& caster, float extent,
                         const RowInput& input, std::span<Word> rows, const AlignedWish& wish, int threads,
                         Control& control) {
    AlignedRows out;
    const size_t n = input.position.size();
    // Embree takes all rows, never some of them: which engine answered is one fact of the call.
    const auto by_caster = [&] {
        out.choice.engine = AlignedEngine::kEmbree;
        out.rays =
            visibility_rows(caster, extent, input, rows, std::nullopt, threads, control, &control.done);
        return out;
    };
    if (wish.engine == AlignedEngine::kEmbree) return by_caster();
    // Refusals that need no sample.
    if (!wish.engine && (is_hopeless(*batch.triangles().scene, std::min(n, kPointsPerRun), input.t_max) ||
                         !fits_batch(batch, input.position)))
        return by_caster();
    const FarEnds sky = far_ends(input.direction, input.t_max);
    std::vector<uint32_t> points;
    RowBlock block;
    BitMatrix visible;
    for (size_t first = 0; first < n; first += kPointsPerRun) {
        points.resize(std::min(n - first, kPointsPerRun));
        std::iota(points.begin(), points.end(), uint32_t(first));
        block.fill(input, sky, points, extent);
        DirectionBlock directions(batch, block.eyes, sky, block.wanted, threads, control);
        // The first run speaks for all: it is a sample of up to 2^14 points. Nothing is written before the
        // choice.
        if (!wish.engine && first == 0) {
            out.choice = directions.choose(wish.isa);
            if (out.choice.engine == AlignedEngine::kEmbree) return by_caster();
        }
        visible.reset(points.size(), sky.count);
        directions.trace(visible, wish.isa);
        // Rows of a block are as wide as those of the result, so whole words are copied.
        for (size_t i = 0; i < points.size(); ++i)
            std::memcpy(&rows[(first + i) * visible.row_words()], visible.row(i),
                        visible.row_words() * sizeof(Word));
        out.rays += directions.rays();
        control.done += points.size();
    }
    return out;
}

}  // namespace viscache
