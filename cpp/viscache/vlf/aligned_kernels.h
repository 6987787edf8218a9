#pragma once
// Visibility of points along an axis: the inner loops, with one variant per instruction set. All variants
// give the same bits.
#include "viscache/math/isa.h"
#include "viscache/vlf/aligned_blocks.h"

namespace viscache {

/// Traces one ray of every point of the packets in `range`, along `axis` (its z) or against it, on the side
/// of the point's normal; n·z = 0 counts as along. `state.up` and `state.asked` override the side and the
/// requested points. Sets `state.free` and adds to `state.counts`. `reach` is t_max in units of the
/// placement, or infinity. Returns early when cancelled; the caller checks.
using TraceAxis = void (*)(const TriangleBlocks& triangles, const PointPackets& points, PacketRange range,
                           const Frame3& axis, float reach, AxisState& state, const Control& control);

TraceAxis trace_axis_kernel(Isa isa);

/// Result for a pair decided in double, where products of two floats are exact.
struct ExactHit {
    bool hit = false;
    float u = 0, v = 0;  ///< barycentric coordinates of b and c
};
/// The corners are relative to the point, with x and y across the axis and z along it. Does the ray along
/// the axis (`up`) or against it hit the triangle within reach?
ExactHit blocks_exactly(const float a[3], const float b[3], const float c[3], bool up, float reach);

}  // namespace viscache
