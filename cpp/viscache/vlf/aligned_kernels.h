#pragma once
// Which points see along an axis: the inner loops, one variant per instruction set, same bits.
#include "viscache/math/isa.h"
#include "viscache/vlf/aligned_blocks.h"

namespace viscache {

/// Traces the ray of every point of the packets in `range` along `axis` (its z) or against it, on the side of
/// the point's normal; n·z = 0 counts as along; or as `state.up` and `state.asked` say. Sets `state.free`,
/// adds to `state.counts`. `reach` is t_max in placed units, infinity for none. Ends early when cancelled;
/// the caller checks.
using TraceAxis = void (*)(const TriangleBlocks& triangles, const PointPackets& points, PacketRange range,
                           const Frame3& axis, float reach, AxisState& state, const Control& control);

TraceAxis trace_axis_kernel(Isa isa);

/// A pair decided in double, where products of floats are exact.
struct ExactHit {
    bool hit = false;
    float u = 0, v = 0;  ///< barycentrics of b and c
};
/// Corners relative to the point, x and y across the axis, z along it: does the ray along (`up`) or against
/// the axis hit within reach?
ExactHit blocks_exactly(const float a[3], const float b[3], const float c[3], bool up, float reach);

}  // namespace viscache
