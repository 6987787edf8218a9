#include "viscache/vlf/aligned_batch.h"

#include "viscache/visibility/packet_choice.h"
#include "viscache/vlf/aligned_kernels.h"
#include "viscache/vlf/axis_bits.h"

namespace viscache {

AlignedCounts AlignedBatch::rows(const AlignedInput& input, std::span<Word> rows, int threads,
                                 Control& control, Isa isa) const {
    constexpr size_t kPacketsAtOnce = kPointsAtOnce / kLanes;
    const TraceAxis trace = trace_axis_kernel(isa);
    if (input.origin.empty()) return {};
    const PointPackets points(triangles_.placement, input.origin, input.normal, control, input.order);
    // Triangles and points are placed, so the length of rays must be, too. The scale is a power of two:
    // nothing is rounded.
    const float reach = input.t_max * triangles_.placement.scale;
    threads = resolve_threads(threads);
    // One state per thread. Rotated packets and the tree over them are scratch data that every axis
    // overwrites.
    std::vector<AxisState> states;
    for (int t = 0; t < threads; ++t) states.emplace_back(std::min(points.packets, kPacketsAtOnce));
    rows_by_axis(input.axes.size(), kPacketsAtOnce, points.order, rows, threads, control,
                 [&](size_t axis, PacketRange range, int worker, uint16_t* lanes) {
                     AxisState& state = states[size_t(worker)];
                     trace(triangles_, points, range, input.axes[axis], reach, state, control);
                     std::copy_n(state.free.begin(), range.packets, lanes);
                 });
    AlignedCounts counts;
    for (const AxisState& state : states) counts.merge(state.counts);
    return counts;
}

namespace {

/// The flag that suits the mean packet, for rays along one axis.
Coherence flag_along(const EmbreeCaster& caster, const PointPackets& points) {
    double sum = 0;
    for (size_t i = 0; i < points.packets * kLanes; i += kLanes)
        sum += half_diagonal(&points.x[i], &points.y[i], &points.z[i]);
    return caster.flag_for(float(sum / double(points.packets)));
}

/// Axes as arrays of components, padded with copies of the last.
struct AxisArrays {
    std::vector<float> x, y, z;
    explicit AxisArrays(std::span<const Frame3> axes) {
        for (size_t k = 0; k < in_lanes(axes.size()) * kLanes; ++k) {
            const Vec3 w = axes[std::min(k, axes.size() - 1)].z;
            x.push_back(w.x);
            y.push_back(w.y);
            z.push_back(w.z);
        }
    }
};

}  // namespace

void embree_rows(const EmbreeCaster& caster, const AlignedInput& input, std::span<Word> rows,
                 AlignedOrder order, int width, std::optional<Coherence> flag, int threads,
                 Control& control) {
    if (input.origin.empty() || input.axes.empty()) return;
    // Embree traces in the space of the scene, so the points are not placed. Packets give only their order.
    const PointPackets points(Placement{}, input.origin, input.normal, control, input.order);
    if (order == AlignedOrder::kByAxis) {
        const PointLanes lanes{points.x.data(),  points.y.data(),  points.z.data(),     points.nx.data(),
                               points.ny.data(), points.nz.data(), points.asked.data(), points.packets};
        const PacketPlan plan{width, flag ? *flag : flag_along(caster, points)};
        rows_by_axis(input.axes.size(), points.packets, points.order, rows, threads, control,
                     [&](size_t axis, PacketRange, int, uint16_t* free) {
                         caster.blocked_along(lanes, input.axes[axis].z, input.t_max, free, plan);
                         // `blocked_along` gives the blocked lanes. Free are the requested lanes that are
                         // left.
                         for (size_t p = 0; p < points.packets; ++p)
                             free[p] = uint16_t(points.asked[p] & ~free[p]);
                     });
        return;
    }
    // By point: the rays of one point along all axes. They spread over its hemisphere, so by default Embree
    // is not promised coherent rays.
    const AxisArrays axes(input.axes);
    const AxisLanes lanes{axes.x.data(), axes.y.data(), axes.z.data(), input.axes.size(), axes.x.size()};
    const size_t words = words_for(lanes.count), tail = lanes.count % kWordBits;
    constexpr size_t kPointsPerChunk = 64;
    const PacketPlan plan{width, flag.value_or(Coherence::kIncoherent)};
    const auto trace = [&](size_t i) {
        Word* row = &rows[i * words];
        caster.blocked_from(input.origin[i], input.normal[i], lanes, input.t_max, row, plan);
        // Embree finds blocked rays, rows contain free ones. Padding bits, which the inversion has set,
        // become 0 again.
        for (size_t w = 0; w < words; ++w) row[w] = ~row[w];
        if (tail) row[words - 1] &= (Word{1} << tail) - 1;
    };
    const size_t chunks = (points.points + kPointsPerChunk - 1) / kPointsPerChunk;
    parallel_for(chunks, threads, [&](size_t chunk, int) {
        control.check();
        // In the order of packets, the rays of successive points descend the same parts of Embree's tree.
        const size_t first = chunk * kPointsPerChunk, last = std::min(points.points, first + kPointsPerChunk);
        for (size_t p = first; p < last; ++p) trace(points.order[p]);
    });
}

}  // namespace viscache
