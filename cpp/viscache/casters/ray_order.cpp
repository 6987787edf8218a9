#include "viscache/casters/ray_order.h"

#include <algorithm>

#include "viscache/casters/row_lanes.h"
#include "viscache/math/bounds.h"
#include "viscache/math/isa_variants.h"
#include "viscache/visibility/direction_bins.h"

namespace viscache {

namespace {

// A class is a cell of the origin × a bin of the direction. Measured on hemisphere, short and point-to-point
// rays: 512 cells × 64 directions are fastest, by a small margin.
constexpr uint32_t kEdge = 8;                    // along each axis of both grids
constexpr uint32_t kDirections = kEdge * kEdge;  // bins of the octahedral square
constexpr uint32_t kClasses = kEdge * kEdge * kEdge * kDirections;
constexpr size_t kBoxStride = 16;  // a sample of the origins suffices for their bounding box
constexpr size_t kRun = 32;        // steps from a ray to the next in one place of the sample
constexpr size_t kRuns = 16;       // places of the sample

#define VISCACHE_INLINE inline __attribute__((always_inline))

/// Number of the cell along one axis, its bits two places apart. Points outside belong to the nearest cell.
VISCACHE_INLINE uint32_t spread_step(float v) {
    const float below = v < kEdge - 1.f ? v : kEdge - 1.f;
    const uint32_t step = uint32_t(int32_t(below > 0 ? below : 0.f));
    // Room for the other two axes: joined, they are a Morton code of nine bits
    return (step & 1) | (step & 2) << 2 | (step & 4) << 4;
}

/// Cells along a Morton curve × directions, sixteen rays at a time. `count` is a multiple of 16.
VISCACHE_INLINE void classify_body(const RayOrder::Cells& cells, const float* origin, const float* direction,
                                   size_t count, uint16_t* out) {
    for (size_t at = 0; at < count; at += 16) {
        float x[16], y[16], z[16], dx[16], dy[16], dz[16];
        rows_to_lanes16(origin + 3 * at, x, y, z);
        rows_to_lanes16(direction + 3 * at, dx, dy, dz);
        for (size_t i = 0; i < 16; ++i) {
            const uint32_t cell = spread_step((x[i] - cells.lo.x) * cells.scale.x) |
                                  spread_step((y[i] - cells.lo.y) * cells.scale.y) << 1 |
                                  spread_step((z[i] - cells.lo.z) * cells.scale.z) << 2;
            out[at + i] = uint16_t(cell * kDirections + direction_bin<kEdge>({dx[i], dy[i], dz[i]}));
        }
    }
}

#undef VISCACHE_INLINE

RayOrder::Cells cells_of(const RayArrays& rays, size_t first, size_t count, size_t stride) {
    Bounds box;
    // The box only scales the cells: rays outside of it fall into those at the border
    for (size_t i = first; i < first + count; i += stride) box.add(rays.origin[i]);
    const auto per_unit = [](float extent) { return extent > 1e-30f ? kEdge / extent : 0.f; };
    const Vec3 extent = box.hi - box.lo;
    return {box.lo, {per_unit(extent.x), per_unit(extent.y), per_unit(extent.z)}};
}

}  // namespace

RayOrder::RayOrder(Isa isa) : classify_(variant_of<classify_body>(isa)) {}

/// Stores the classes of the rays [first, first + count) from class_[at] on.
void RayOrder::classify(const RayArrays& rays, const Cells& cells, size_t first, size_t count, size_t at) {
    size_t done = 0;
    if (rays.origin.stride == 3 && rays.direction.stride == 3) {
        done = count / 16 * 16;
        classify_(cells, rays.origin.data + 3 * first, rays.direction.data + 3 * first, done, &class_[at]);
    }
    // Rows with gaps and the last ones are copied
    for (; done < count; done += 16) {
        float origin[48], direction[48];
        uint16_t classes[16];
        const size_t n = std::min<size_t>(16, count - done);
        for (size_t i = 0; i < 16; ++i) {
            const size_t k = first + done + std::min(i, n - 1);
            const Vec3 o = rays.origin[k], d = rays.direction[k];
            std::copy_n(&o.x, 3, origin + 3 * i);
            std::copy_n(&d.x, 3, direction + 3 * i);
        }
        classify_(cells, origin, direction, 16, classes);
        std::copy_n(classes, n, &class_[at + done]);
    }
}

double RayOrder::share_in_order(const RayArrays& rays, size_t first, size_t count) {
    if (count < 2) return 1;
    // Runs of neighbours at places spread over the batch: what counts is whether a ray resembles
    // the one before it
    const size_t runs = std::clamp<size_t>(count / (2 * kRun), 1, kRuns);
    const size_t length = std::min(count, runs == 1 ? count : kRun + 1);
    class_.resize(std::max(class_.size(), runs * length));
    const Cells cells = cells_of(rays, first, count, std::max<size_t>(1, count / 256));
    size_t same = 0;
    for (size_t run = 0; run < runs; ++run) {
        const size_t begin = run * (count - length) / std::max<size_t>(1, runs - 1);
        classify(rays, cells, first + begin, length, run * length);
        for (size_t i = 1; i < length; ++i) same += class_[run * length + i] == class_[run * length + i - 1];
    }
    return double(same) / double(runs * (length - 1));
}

std::span<const uint32_t> RayOrder::sort(const RayArrays& rays, size_t first, size_t count) {
    class_.resize(count);
    classify(rays, cells_of(rays, first, count, kBoxStride), first, count, 0);
    // Counting sort, stable: equal rays keep the caller's order, and the order is the same
    // everywhere
    begin_.assign(kClasses + 1, 0);
    for (size_t i = 0; i < count; ++i) ++begin_[class_[i] + 1u];
    for (size_t c = 1; c <= kClasses; ++c) begin_[c] += begin_[c - 1];
    order_.resize(count);
    for (size_t i = 0; i < count; ++i) order_[begin_[class_[i]]++] = uint32_t(first + i);
    return order_;
}

}  // namespace viscache
