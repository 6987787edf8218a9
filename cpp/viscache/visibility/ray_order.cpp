#include "viscache/visibility/ray_order.h"

#include "viscache/math/bounds.h"
#include "viscache/visibility/direction_bins.h"

namespace viscache {

namespace {

// A class is a cell of the origin × a bin of the direction. Measured on hemisphere, short and point-to-point
// rays: 512 cells × 64 directions are fastest, by a small margin.
constexpr uint32_t kEdge = 8;                    // along each axis of both grids
constexpr uint32_t kDirections = kEdge * kEdge;  // bins of the octahedral square
constexpr uint32_t kClasses = kEdge * kEdge * kEdge * kDirections;
constexpr size_t kBoxStride = 16;  // a sample of the origins suffices for their bounding box
constexpr uint32_t kSpread3[kEdge] = {0, 1, 8, 9, 64, 65, 72, 73};  // Morton code bits in three dimensions

uint32_t step(float v) { return uint32_t(std::max(0.f, std::min(v, kEdge - 1.f))); }

/// Cells of a box, numbered along a Morton curve. Points outside belong to the nearest cell.
struct OriginCells {
    Vec3 lo, scale;

    explicit OriginCells(const Bounds& box) : lo(box.lo) {
        const auto per_unit = [](float extent) { return extent > 1e-30f ? kEdge / extent : 0.f; };
        const Vec3 extent = box.hi - box.lo;
        scale = {per_unit(extent.x), per_unit(extent.y), per_unit(extent.z)};
    }
    uint32_t operator()(Vec3 p) const {
        return kSpread3[step((p.x - lo.x) * scale.x)] | kSpread3[step((p.y - lo.y) * scale.y)] << 1 |
               kSpread3[step((p.z - lo.z) * scale.z)] << 2;
    }
};

}  // namespace

void RayOrder::classify(const RayArrays& rays, size_t first, size_t count) {
    first_ = first;
    class_.resize(count);
    Bounds box;
    for (size_t i = first; i < first + count; i += kBoxStride) box.add(rays.origin[i]);
    const OriginCells cells(box);
    for (size_t i = 0; i < count; ++i)
        class_[i] = uint16_t(cells(rays.origin[first + i]) * kDirections +
                             direction_bin<kEdge>(rays.direction[first + i]));
}

double RayOrder::share_in_order() const {
    size_t same = 0;
    for (size_t i = 1; i < class_.size(); ++i) same += class_[i] == class_[i - 1];
    return class_.size() > 1 ? double(same) / double(class_.size() - 1) : 1;
}

std::span<const uint32_t> RayOrder::sort() {
    begin_.assign(kClasses + 1, 0);
    for (const uint16_t c : class_) ++begin_[c + 1u];
    for (size_t c = 1; c <= kClasses; ++c) begin_[c] += begin_[c - 1];
    order_.resize(class_.size());
    for (size_t i = 0; i < class_.size(); ++i) order_[begin_[class_[i]]++] = uint32_t(first_ + i);
    return order_;
}

}  // namespace viscache
