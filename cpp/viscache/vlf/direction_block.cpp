#include "viscache/vlf/direction_block.h"

#include <bit>
#include <numeric>

#include "viscache/oracles/exact.h"
#include "viscache/vlf/aligned_kernels.h"

namespace viscache {

namespace {

/// Cost of blocks relative to one ray of each point along each axis. The batch converts bits to columns and
/// back; Embree traces neighbouring directions of the sky one after the other. Measured on 4 scenes with
/// 2048 to 16,384 points and 9216 directions, within 30 %.
constexpr double kTurningBits = 1.15, kEmbreeAtBlocks = 0.7;
/// The batch is taken below this share of Embree's predicted cost. On seven blocks of four scenes the
/// measured share was at most 1.1 times the predicted one.
constexpr double kBlockShare = 0.8;
/// One axis is traced before the decision per this many axes, at least one, up to kProbedBlockAxes.
constexpr size_t kAxesPerBlockProbe = 64, kProbedBlockAxes = 4;

std::vector<Vec3> directions_of(const FarEnds& lights) {
    std::vector<Vec3> directions;
    for (size_t k = 0; k < lights.count; ++k)
        directions.push_back({lights.tx[k], lights.ty[k], lights.tz[k]});
    return directions;
}

}  // namespace

/// Slightly below kFarthest, because the origins of rays are offset from their surface.
constexpr float kFarEnough = 0.99f * kFarthest;

bool fits_batch(const AlignedBatch& batch, std::span<const Vec3> points) {
    const Placement& placement = batch.triangles().placement;
    if (batch.triangles().scene->is_coarse()) return false;
    for (const Vec3 p : points)
        if (!(max_abs(placement.apply(p)) <= kFarEnough)) return false;
    return true;
}

DirectionBlock::DirectionBlock(const AlignedBatch& batch, const EyeBlock& eyes, const FarEnds& lights,
                               const BitMatrix& wanted, int threads, const Control& control)
    : batch_(batch),
      points_(batch.triangles().placement,
              spawned(eyes.position, eyes.normal, aligned_extent(*batch.triangles().scene)), eyes.normal,
              control),
      axes_(axes_of(directions_of(lights))),
      directions_(lights.count),
      t_max_(lights.t_max),
      threads_(resolve_threads(threads)),
      control_(control) {
    take(wanted);
}

/// Calls work(first, last) for runs of packets.
template <class Work>
void DirectionBlock::for_packets(Work work) const {
    constexpr size_t kPacketsPerChunk = 64;
    parallel_for(
        (points_.packets + kPacketsPerChunk - 1) / kPacketsPerChunk, threads_, [&](size_t chunk, int) {
            control_.check();
            work(chunk * kPacketsPerChunk, std::min(points_.packets, (chunk + 1) * kPacketsPerChunk));
        });
}

/// Converts rows of requested bits in the caller's order to columns in the order of the packets.
///
///     rows      one word per point: 64 directions          columns   16 bits per direction and packet
///     point 0   d d d d d d ...                            d 0       [16 lanes of packet 0] [packet 1] ...
///     point 1   d d d d d d ...                 -->        d 1       [16 lanes of packet 0] [packet 1] ...
///
/// The kernel traces one direction at a time and wants the lanes of a packet in one mask.
void DirectionBlock::take(const BitMatrix& wanted) {
    rays_ = count_bits(wanted);
    columns_.assign(words_for(directions_) * kWordBits * points_.packets, 0);
    for_packets([&](size_t first, size_t last) {
        BitMatrix rows(kLanes, kWordBits);
        uint16_t turned[kWordBits];
        for (size_t w = 0; w < words_for(directions_); ++w)
            for (size_t p = first; p < last; ++p) {
                for (size_t i = 0; i < kLanes; ++i) {
                    const size_t lane = p * kLanes + i;
                    // Padding lanes request nothing.
                    rows.row(i)[0] = lane < points_.points ? wanted.row(points_.order[lane])[w] : 0;
                }
                // Transposes 16 points × 64 directions at a time.
                columns16(rows, 0, 0, turned);
                for (size_t j = 0; j < kWordBits; ++j) column(w * kWordBits + j)[p] = turned[j];
            }
    });
}

/// The inverse, for visible bits.
void DirectionBlock::give(BitMatrix& visible) const {
    for_packets([&](size_t first, size_t last) {
        BitMatrix rows;
        uint16_t turned[kWordBits];
        for (size_t w = 0; w < words_for(directions_); ++w)
            for (size_t p = first; p < last; ++p) {
                rows.reset(kLanes, kWordBits);
                for (size_t j = 0; j < kWordBits; ++j) turned[j] = column(w * kWordBits + j)[p];
                or_columns16(rows, 0, 0, turned);
                for (size_t i = 0; i < std::min(kLanes, points_.points - p * kLanes); ++i)
                    visible.row(points_.order[p * kLanes + i])[w] = rows.row(i)[0];
            }
    });
}

/// Replaces the requested lanes along and against an axis by the visible ones. If a lane requests both
/// directions (they may be opposite only up to rounding), the axis is traced twice.
void DirectionBlock::trace_axis(const SharedAxis& axis, TraceAxis kernel, Worker& worker, uint16_t* along,
                                uint16_t* against) const {
    const float reach = t_max_ * axis.length * batch_.triangles().placement.scale;
    AxisState& s = worker.state;
    // Requested lanes that run along the axis, for all packets; nullptr would take the side of the normal.
    const auto trace = [&](const uint16_t* up) {
        s.up = up;
        s.asked = worker.asked.data();
        kernel(batch_.triangles(), points_, {0, points_.packets}, axis.frame, reach, s, control_);
        control_.check();
    };
    // One pass serves both directions: lanes that request `along` run up, all others down. This halves the
    // work where points see a whole sphere of directions, each point on one side of its surface.
    uint16_t any = 0, both = 0;
    for (size_t p = 0; p < points_.packets; ++p) {
        const uint16_t down = against ? against[p] : uint16_t{0};
        worker.asked[p] = along[p] | down;
        any |= worker.asked[p];
        both |= along[p] & down;
    }
    if (!any) return;
    trace(along);
    std::vector<uint16_t> twice;
    for (size_t p = 0; p < points_.packets; ++p) {
        if (both) twice.push_back(uint16_t(along[p] & against[p]));
        // First `against`, which needs the requested lanes of `along`; these are overwritten in the next
        // line.
        if (against) against[p] = uint16_t(against[p] & ~along[p] & s.free[p]);
        along[p] &= s.free[p];
    }
    if (!both) return;
    // The second pass serves lanes that request both. None runs up, so all run against the axis.
    const std::vector<uint16_t> none(points_.packets);
    worker.asked = twice;
    trace(none.data());
    for (size_t p = 0; p < points_.packets; ++p) against[p] |= s.free[p];
}

AlignedCounts DirectionBlock::trace(BitMatrix& visible, Isa isa) {
    if (points_.points == 0 || axes_.empty()) return {};
    const TraceAxis kernel = trace_axis_kernel(isa);
    // More threads than axes would have nothing to do.
    std::vector<Worker> workers;
    for (size_t t = 0; t < std::min(size_t(threads_), axes_.size()); ++t) workers.emplace_back(points_);
    parallel_for(axes_.size(), threads_, [&](size_t a, int worker) {
        control_.check();
        const SharedAxis& axis = axes_[a];
        trace_axis(axis, kernel, workers[size_t(worker)], column(axis.along),
                   axis.against == SharedAxis::kNone ? nullptr : column(axis.against));
    });
    give(visible);
    AlignedCounts counts;
    for (const Worker& worker : workers) counts.merge(worker.state.counts);
    return counts;
}

EngineChoice DirectionBlock::choose(Isa isa) const {
    const TraceAxis kernel = trace_axis_kernel(isa);
    const std::vector<size_t> some = probed_axes(
        axes_.size(),
        std::min(axes_.size(), std::clamp<size_t>(axes_.size() / kAxesPerBlockProbe, 1, kProbedBlockAxes)));
    std::vector<AlignedCounts> work(some.size());
    std::vector<uint64_t> rays(some.size()), seen(some.size());
    const auto lanes_in = [](const std::vector<uint16_t>& lanes) {
        uint64_t n = 0;
        for (const uint16_t m : lanes) n += uint64_t(std::popcount(m));
        return n;
    };
    parallel_for(some.size(), threads_, [&](size_t i, int) {
        const SharedAxis& axis = axes_[some[i]];
        Worker worker(points_);
        // `trace_axis` replaces requested lanes by visible ones, so a probe works on copies.
        const auto copy = [&](uint32_t direction) {
            std::vector<uint16_t> lanes(points_.packets);
            if (direction != SharedAxis::kNone)
                std::copy_n(column(direction), points_.packets, lanes.begin());
            rays[i] += lanes_in(lanes);
            return lanes;
        };
        std::vector<uint16_t> along = copy(axis.along), against = copy(axis.against);
        trace_axis(axis, kernel, worker, along.data(), against.data());
        seen[i] = lanes_in(along) + lanes_in(against);
        work[i] = worker.state.counts;
    });
    AlignedCounts all;
    for (const AlignedCounts& w : work) all.merge(w);
    const uint64_t traced = std::accumulate(rays.begin(), rays.end(), uint64_t{0});
    const uint64_t free = std::accumulate(seen.begin(), seen.end(), uint64_t{0});
    const AlignedOrder order = embree_order(batch_.triangles().triangles, points_.points);
    // Length of rays over the diameter of the scene
    const float length = t_max_ / (2 * batch_.triangles().scene->radius());
    // The prediction is of rays that cover every point and axis; blocks differ by measured factors.
    EngineChoice costs = predicted_costs(AlignedWork::of(all, traced, free), order, length, isa);
    costs.batch_ns *= kTurningBits;
    costs.embree_ns *= kEmbreeAtBlocks;
    return decided(costs, kBlockShare);
}

}  // namespace viscache
