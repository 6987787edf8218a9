#include "viscache/vlf/engine_choice.h"

namespace viscache {

namespace {

constexpr size_t kProbedAxes = 4;
/// One axis is probed for so many there are, up to kProbedAxes.
constexpr size_t kAxesPerProbe = 32;
/// The batch must be cheaper by this much: below, predictions are not good enough to tell.
constexpr double kMargin = 0.9;
constexpr uint64_t kHopelessTrianglesPerPoint = 40, kSparseTrianglesPerPoint = 8;

/// What a ray, a test of 16 boxes and a test of 16 pairs cost the batch, in nanoseconds. Fitted to 18
/// measurements of 8 scenes with 128² to 1024² points (AVX-512, a shared Zen 4; within 30 % of each).
struct BatchCosts {
    double ray, node, test;
};
BatchCosts batch_costs(Isa isa) {
    constexpr BatchCosts avx512{2.2, 24.6, 32.7};
    const double slower = isa == Isa::kAvx512 ? 1 : isa == Isa::kAvx2 ? 1.5 : 4;
    return {slower * avx512.ray, slower * avx512.node, slower * avx512.test};
}

/// Nanoseconds of a ray by Embree from the batch's tests per ray, which tell how crowded its way is; the same
/// measurements, within a factor of 1.6.
double embree_cost(double tests) { return 20 + 85 * tests; }

}  // namespace

bool is_hopeless(uint64_t triangles, uint64_t points) {
    return triangles / kHopelessTrianglesPerPoint > points;
}

AlignedOrder embree_order(uint64_t triangles, uint64_t points) {
    return triangles / kSparseTrianglesPerPoint > points ? AlignedOrder::kByPoint : AlignedOrder::kByAxis;
}

EngineChoice choose_engine(const AlignedBatch& batch, const AlignedInput& input, int threads,
                           Control& control, Isa isa) {
    EngineChoice choice;
    const size_t axes = input.axes.size();
    if (input.origin.empty() || axes == 0) return choice;
    const size_t n = std::clamp<size_t>(axes / kAxesPerProbe, 1, kProbedAxes);
    std::vector<Frame3> some;
    for (size_t i = 0; i < n; ++i) some.push_back(input.axes[(2 * i + 1) * axes / (2 * n)]);
    AlignedInput probe = input;
    probe.axes = some;
    std::vector<Word> rows(input.origin.size() * words_for(n));
    const AlignedCounts work = batch.rows(probe, rows, threads, control, isa);
    const double rays = double(input.origin.size()) * double(n);
    const BatchCosts cost = batch_costs(isa);
    choice.batch_ns = cost.ray + (cost.node * double(work.nodes) + cost.test * double(work.tests)) / rays;
    choice.embree_ns = embree_cost(double(work.tests) / rays);
    if (choice.batch_ns > kMargin * choice.embree_ns) choice.engine = AlignedEngine::kEmbree;
    return choice;
}

}  // namespace viscache
