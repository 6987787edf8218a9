#include "viscache/vlf/engine_choice.h"

namespace viscache {

namespace {

constexpr size_t kProbedAxes = 4;
/// One axis is probed per this many axes, up to kProbedAxes.
constexpr size_t kAxesPerProbe = 32;
/// The batch must be cheaper than Embree by this factor; predictions cannot resolve smaller differences.
constexpr double kMargin = 0.9;
/// The factor for sparse points. Their packets are wide and overlap more triangles than their rays do.
/// Embree's cost is predicted from these tests, so it is overestimated.
constexpr double kSparseMargin = 0.72;
constexpr uint64_t kHopelessTrianglesPerPoint = 40, kSparseTrianglesPerPoint = 8;

/// Cost for the batch of a ray, of rotating a block, of a test of 16 boxes and of a test of 16 pairs, in
/// nanoseconds. Fitted to 18 measurements of 8 scenes with 128² to 1024² points (AVX-512, a shared Zen 4;
/// within 30 % of each); the cost of blocks to 8 measurements with few points. The other instruction sets
/// were measured on the same machine: AVX2 takes 1.11 to 1.19 times as long, portable code 2.4 to 3.9 times
/// (four scenes, 513 directions).
struct BatchCosts {
    double ray, block, node, test;
};
BatchCosts batch_costs(Isa isa) {
    constexpr BatchCosts avx512{2.2, 20, 24.6, 32.7};
    const double slower = isa == Isa::kAvx512 ? 1 : isa == Isa::kAvx2 ? 1.15 : 3.1;
    return {slower * avx512.ray, slower * avx512.block, slower * avx512.node, slower * avx512.test};
}

/// Nanoseconds per ray with Embree, from the batch's tests per ray, which measure the depth complexity. From
/// the same measurements, within a factor of 1.6.
double embree_cost(double tests) { return 20 + 85 * tests; }

}  // namespace

bool is_hopeless(uint64_t triangles, uint64_t points) {
    return triangles / kHopelessTrianglesPerPoint > points;
}

AlignedOrder embree_order(uint64_t triangles, uint64_t points) {
    return triangles / kSparseTrianglesPerPoint > points ? AlignedOrder::kByPoint : AlignedOrder::kByAxis;
}

std::vector<size_t> probed_axes(size_t axes) {
    const size_t n = std::min(axes, std::clamp<size_t>(axes / kAxesPerProbe, 1, kProbedAxes));
    std::vector<size_t> some;
    for (size_t i = 0; i < n; ++i) some.push_back((2 * i + 1) * axes / (2 * n));
    return some;
}

EngineChoice predicted_costs(const AlignedCounts& work, double rays, Isa isa) {
    EngineChoice choice;
    if (rays == 0) return choice;
    const BatchCosts cost = batch_costs(isa);
    const double shared = cost.block * double(work.blocks) + cost.node * double(work.nodes);
    choice.batch_ns = cost.ray + (shared + cost.test * double(work.tests)) / rays;
    choice.embree_ns = embree_cost(double(work.tests) / rays);
    return choice;
}

EngineChoice decided(EngineChoice costs, bool sparse) {
    const bool expensive = costs.batch_ns > (sparse ? kSparseMargin : kMargin) * costs.embree_ns;
    costs.engine = expensive ? AlignedEngine::kEmbree : AlignedEngine::kBatch;
    return costs;
}

EngineChoice choose_engine(const AlignedBatch& batch, const AlignedInput& input, int threads,
                           Control& control, Isa isa) {
    if (input.origin.empty()) return {};
    std::vector<Frame3> some;
    for (const size_t axis : probed_axes(input.axes.size())) some.push_back(input.axes[axis]);
    AlignedInput probe = input;
    probe.axes = some;
    std::vector<Word> rows(input.origin.size() * words_for(some.size()));
    const AlignedCounts work = batch.rows(probe, rows, threads, control, isa);
    const EngineChoice costs = predicted_costs(work, double(input.origin.size()) * double(some.size()), isa);
    const uint64_t triangles = batch.triangles().triangles;
    return decided(costs, embree_order(triangles, input.origin.size()) == AlignedOrder::kByPoint);
}

}  // namespace viscache
