#pragma once
// One block of points × shared directions by the batch: bits asked for in, bits of what is seen out.
#include <optional>

#include "viscache/visibility/oracle.h"
#include "viscache/vlf/aligned_kernels.h"
#include "viscache/vlf/direction_axes.h"
#include "viscache/vlf/engine_choice.h"

namespace viscache {

/// The points of a block, the directions they share as axes, and who asks along which. `lights` must be
/// directions, and every point must satisfy `fits_batch`.
class DirectionBlock {
public:
    DirectionBlock(const AlignedBatch& batch, const EyeBlock& eyes, const FarEnds& lights,
                   const BitMatrix& wanted, int threads, const Control& control);

    /// Predicts what both engines cost from the work along a few axes.
    EngineChoice choose(Isa isa) const;
    /// Sets the bits of `visible` (zeroed, of the size of `wanted`) that are wanted and free. The same for
    /// any number of threads and any instruction set.
    AlignedCounts trace(BitMatrix& visible, Isa isa);
    uint64_t rays() const { return rays_; }
    size_t axes() const { return axes_.size(); }

private:
    /// What a thread needs.
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
    std::vector<uint16_t> columns_;  ///< per direction and packet: lanes asked, in the end lanes that see
    uint64_t rays_ = 0;
};

/// True if the points are near enough to the scene for the batch.
bool fits_batch(const AlignedBatch& batch, std::span<const Vec3> points);

}  // namespace viscache
