#include "viscache/vlf/aligned_sample.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "viscache/vlf/aligned_kernels.h"

namespace viscache {

namespace {

/// One ray in this many is traced for the estimate.
constexpr uint64_t kRaysPerSampled = 256;
/// Points of a run. Long runs show how neighbouring points share work; short ones leave more to choose from.
constexpr size_t kLongRun = 4096, kShortRun = 1024;
constexpr uint64_t kFewPasses = 4, kMostPasses = 64;
/// The batch turns a block of triangles once for all runs of a range. R runs need about R to the power of
/// this as many blocks as one run. From the measurements of `viscache bench aligned`.
constexpr double kBlocksOfRuns = 0.6;
/// Steps of the additive sequences for runs and axes, times 2³²: two numbers that share no short period.
/// Inverses of the golden ratio and of the plastic number. Together they spread pairs of a run and an axis
/// evenly over the plane (R2 sequence), for any number of passes.
constexpr uint64_t kRunStep = 2654435769u, kAxisStep = 3242174889u;

/// Element i of an additive sequence over n numbers.
size_t spread(uint64_t i, uint64_t step, size_t n) {
    const uint64_t part = ((uint64_t{1} << 31) + i * step) & 0xffffffffu;
    return size_t((part * n) >> 32);
}

/// What a pass of the sample did and found.
struct Pass {
    AlignedCounts work;
    uint64_t rays = 0, free = 0;
};

/// Traces the points [first, last) of the order along one axis.
Pass trace_pass(const AlignedBatch& batch, const AlignedInput& input, std::span<const uint32_t> run,
                size_t axis, const Control& control, Isa isa) {
    std::vector<Vec3> origin, normal;
    for (const uint32_t i : run) {
        origin.push_back(input.origin[i]);
        normal.push_back(input.normal[i]);
    }
    // The run is already in kd-order: packets take the points as they come.
    std::vector<uint32_t> as_given(run.size());
    std::iota(as_given.begin(), as_given.end(), 0u);
    const TriangleBlocks& triangles = batch.triangles();
    const PointPackets points(triangles.placement, origin, normal, control, as_given);
    AxisState state(points.packets);
    trace_axis_kernel(isa)(triangles, points, {0, points.packets}, input.axes[axis],
                           input.t_max * triangles.placement.scale, state, control);
    control.check();
    Pass pass{state.counts, run.size(), 0};
    for (const uint16_t free : state.free) pass.free += uint64_t(std::popcount(free));
    return pass;
}

}  // namespace

AlignedWork AlignedWork::of(const AlignedCounts& counts, uint64_t rays, uint64_t free) {
    if (rays == 0) return {};
    const double share = 1 / double(rays);
    return {double(counts.blocks) * share, double(counts.nodes) * share, double(counts.pairs) * share,
            double(counts.tests) * share,  double(counts.wide) * share,  double(counts.exact) * share,
            double(free) * share};
}

AlignedWork sampled_work(const AlignedBatch& batch, const AlignedInput& input, int threads, Control& control,
                         Isa isa) {
    const size_t n = input.origin.size(), axes = input.axes.size();
    if (n == 0 || axes == 0) return {};
    const std::vector<uint32_t> sorted =
        input.order.empty() ? kd_order(input.origin, control) : std::vector<uint32_t>{};
    const std::span<const uint32_t> order = input.order.empty() ? std::span(sorted) : input.order;
    const uint64_t wanted = uint64_t(n) * axes / kRaysPerSampled;
    // Few passes would see only a few places of the scene; shorter runs give four times as many.
    const size_t run = wanted < kFewPasses * kLongRun ? kShortRun : kLongRun, runs = (n + run - 1) / run;
    const uint64_t passes = std::clamp<uint64_t>(wanted / run, 1, kMostPasses);
    std::vector<Pass> found(passes);
    parallel_for(passes, threads, [&](size_t i, int) {
        // Runs start at multiples of `run`, as the nodes of the kd-order do, so each is compact.
        const size_t first = spread(i, kRunStep, runs) * run;
        found[i] = trace_pass(batch, input, order.subspan(first, std::min(run, n - first)),
                              spread(i, kAxisStep, axes), control, isa);
    });
    Pass all;
    for (const Pass& pass : found) {
        all.work.merge(pass.work);
        all.rays += pass.rays;
        all.free += pass.free;
    }
    AlignedWork work = AlignedWork::of(all.work, all.rays, all.free);
    // The sample turned each block for one run; all runs of a range will share it
    const double range = double(std::min(n, kPointsAtOnce));
    const double of_run = double(all.work.blocks) / double(passes);
    const double of_range = of_run * std::pow(std::max(1., range / double(std::min(n, run))), kBlocksOfRuns);
    work.blocks = std::min(of_range, double(batch.triangles().blocks)) / range;
    return work;
}

}  // namespace viscache
