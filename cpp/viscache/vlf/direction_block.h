#pragma once
// One block of points × shared directions, traced by the batch: requested bits in, visible bits out.
#include "viscache/visibility/oracle.h"
#include "viscache/vlf/aligned_kernels.h"
#include "viscache/vlf/direction_axes.h"
#include "viscache/vlf/engine_choice.h"

namespace viscache {

/// The points of a block, their shared directions as axes, and the requested pairs. `lights` must be
/// directions, and every point must satisfy `fits_batch`.
class DirectionBlock {
public:
    DirectionBlock(const AlignedBatch& batch, const EyeBlock& eyes, const FarEnds& lights,
                   const BitMatrix& wanted, int threads, const Control& control);

    /// Predicts the cost of both engines from the work along a few axes.
    EngineChoice choose(Isa isa) const;
    /// Sets the bits of `visible` that are requested and free. `visible` must be zero and have the size of
    /// `wanted`. The result is the same for any number of threads and any instruction set.
    AlignedCounts trace(BitMatrix& visible, Isa isa);
    uint64_t rays() const { return rays_; }
    size_t axes() const { return axes_.size(); }

private:
    /// State of one thread.
    struct Worker {
        AxisState state;
        std::vector<uint16_t> asked;
        explicit Worker(const PointPackets& points) : state(points.packets), asked(points.packets) {}
    };
    template <class Work>
    void for_packets(Work work) const;
    void take(const BitMatrix& wanted);
    void give(BitMatrix& visible) const;
    void trace_axis(const SharedAxis& axis, TraceAxis kernel, Worker& worker, uint16_t* along,
                    uint16_t* against) const;
    uint16_t* column(size_t direction) { return &columns_[direction * points_.packets]; }
    const uint16_t* column(size_t direction) const { return &columns_[direction * points_.packets]; }

    const AlignedBatch& batch_;
    PointPackets points_;
    std::vector<SharedAxis> axes_;
    size_t directions_;
    float t_max_;
    int threads_;
    const Control& control_;
    std::vector<uint16_t> columns_;  ///< per direction and packet: requested lanes, later the visible ones
    uint64_t rays_ = 0;
};

/// True if all points are close enough to the scene for the batch, and its offsets are small beside
/// triangles.
bool fits_batch(const AlignedBatch& batch, std::span<const Vec3> points);

}  // namespace viscache
