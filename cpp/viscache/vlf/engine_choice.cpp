#include "viscache/vlf/engine_choice.h"

#include <bit>

namespace viscache {

namespace {

/// One axis is probed per this many axes, up to kProbedAxes.
constexpr size_t kAxesPerProbe = 128, kProbedAxes = 4;
/// The batch is taken if its predicted cost is below this share of Embree's. On the fitted scenes the
/// predicted ratio has a relative spread of 1.32 from whole axes and of 1.38 from the sample alone; each
/// share keeps one such spread. Below kHope, the sample is followed by whole axes.
constexpr double kShare = 0.75, kClearShare = 0.7, kHope = 0.9;
constexpr uint64_t kSparseTrianglesPerPoint = 8, kHopelessTrianglesPerPoint = 40, kHopelessIfShort = 12;

/// Prices of the batch in nanoseconds, in the order of AlignedWork: a ray, rotating a block, a test of 16
/// boxes, a pair of a packet and a block, a test of 16 pairs of triangle and point, and a decision in double.
/// All prices are fitted by scripts/aligned_costs.py (AMD EPYC with AVX-512): the spread is 1.21 for the
/// batch and 1.31 and 1.27 for Embree by axis and by point.
struct BatchPrices {
    double ray, block, node, pair, test, exact;
};
constexpr BatchPrices kBatchPrices{1.7, 51.2, 4.9, 13.1, 21.6, 29.7};

/// Prices of Embree in nanoseconds, by the same work, which measures how crowded a ray's surroundings are.
/// Narrow tests are of one triangle against 16 points, wide ones of 16 triangles. Free rays pay for their
/// length; any hit ends the others. Packets of one point pay by pairs for what is around it.
struct EmbreePrices {
    double ray, narrow, wide, narrow_length, wide_length, exact, pair_length;
};
constexpr EmbreePrices kByAxisPrices{13.1, 8, 4.6, 59.5, 143.7, 22.7, 0},
    kByPointPrices{27.4, 15.9, 15.9, 10.6, 10.6, 0, 16.7};

/// Time of the batch over that with AVX-512.
double slowness(Isa isa) { return isa == Isa::kAvx512 ? 1 : isa == Isa::kAvx2 ? 1.15 : 3.1; }

}  // namespace

bool is_hopeless(const Scene& scene, uint64_t points, float t_max) {
    const bool is_short = t_max < scene.radius();
    return scene.placed_triangles() / (is_short ? kHopelessIfShort : kHopelessTrianglesPerPoint) > points;
}

AlignedOrder embree_order(uint64_t triangles, uint64_t points) {
    return triangles / kSparseTrianglesPerPoint > points ? AlignedOrder::kByPoint : AlignedOrder::kByAxis;
}

std::vector<size_t> probed_axes(size_t axes, size_t n) {
    std::vector<size_t> some;
    // The middles of n equal parts
    for (size_t i = 0; i < n; ++i) some.push_back((2 * i + 1) * axes / (2 * n));
    return some;
}

EngineChoice predicted_costs(const AlignedWork& work, AlignedOrder order, float length, Isa isa) {
    const BatchPrices& b = kBatchPrices;
    const EmbreePrices& e = order == AlignedOrder::kByAxis ? kByAxisPrices : kByPointPrices;
    // As fitted: the cost of free rays grows with the fourth root of their length.
    const double reach = std::sqrt(std::sqrt(std::clamp(double(length), 0., 1.)));
    EngineChoice choice;
    choice.batch_ns = slowness(isa) * (b.ray + b.block * work.blocks + b.node * work.nodes +
                                       b.pair * work.pairs + b.test * work.tests + b.exact * work.exact);
    // Narrow tests are of several points near one triangle: packets of neighbouring points share them.
    const double narrow = work.tests - work.wide, free_length = work.free * reach;
    choice.embree_ns = e.ray + (e.narrow + e.narrow_length * free_length) * narrow +
                       (e.wide + e.wide_length * free_length) * work.wide + e.exact * work.exact +
                       e.pair_length * reach * work.pairs;
    return choice;
}

EngineChoice decided(EngineChoice costs, double share) {
    const bool cheap = costs.batch_ns < share * costs.embree_ns;
    costs.engine = cheap ? AlignedEngine::kBatch : AlignedEngine::kEmbree;
    return costs;
}

EngineChoice choose_engine(const AlignedBatch& batch, const AlignedInput& input, int threads,
                           Control& control, Isa isa) {
    if (input.origin.empty() || input.axes.empty()) return {};
    if (batch.triangles().scene->is_coarse()) return {AlignedEngine::kEmbree};
    const AlignedOrder order = embree_order(batch.triangles().triangles, input.origin.size());
    const float length = input.t_max / (2 * batch.triangles().scene->radius());
    // First step: a small sample. Second step, only if the batch has a chance: whole axes.
    const EngineChoice sampled =
        predicted_costs(sampled_work(batch, input, threads, control, isa), order, length, isa);
    const std::vector<size_t> probed =
        probed_axes(input.axes.size(), std::min(input.axes.size() / kAxesPerProbe, kProbedAxes));
    // No whole axis is affordable, so only the sample decides, and it must be clearer.
    if (probed.empty()) return decided(sampled, kClearShare);
    if (sampled.batch_ns > kHope * sampled.embree_ns) return decided(sampled, kShare);
    std::vector<Frame3> some;
    for (const size_t axis : probed) some.push_back(input.axes[axis]);
    AlignedInput probe = input;
    probe.axes = some;
    // One word per point has room for all probed axes.
    std::vector<Word> rows(input.origin.size());
    static_assert(kProbedAxes <= kWordBits);
    const AlignedCounts counts = batch.rows(probe, rows, threads, control, isa);
    uint64_t free = 0;
    for (const Word row : rows) free += uint64_t(std::popcount(row));
    const auto work = AlignedWork::of(counts, uint64_t(rows.size()) * some.size(), free);
    return decided(predicted_costs(work, order, length, isa), kShare);
}

}  // namespace viscache
