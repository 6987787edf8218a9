#include "viscache/visibility/point_order.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

#include "viscache/math/bounds.h"

namespace viscache {

namespace {

constexpr size_t kPacket = 16;

/// A number with the order of the float; NaN is in it, so that any input has an order.
uint32_t sortable(float v) {
    const uint32_t bits = std::bit_cast<uint32_t>(v);
    return bits >> 31 ? ~bits : bits | 0x80000000u;
}

int longest_extent(Vec3 extent) {
    if (extent.x >= extent.y && extent.x >= extent.z) return 0;
    return extent.y >= extent.z ? 1 : 2;
}

/// Largest 16 · 2^k below `count`.
size_t left_side(size_t count) {
    size_t left = kPacket;
    while (left * 2 < count) left *= 2;
    return left;
}

class PointSplitter {
public:
    PointSplitter(std::span<const Vec3> points, std::span<uint32_t> order)
        : points_(points), order_(order), keys_(points.size()) {}

    void split(size_t first, size_t last) {
        if (last - first <= kPacket) return;
        Bounds bounds;
        for (size_t i = first; i < last; ++i) bounds.add(points_[order_[i]]);
        const int axis = longest_extent(bounds.hi - bounds.lo);
        const size_t middle = first + left_side(last - first);
        // One integer holds coordinate and index: their order is total
        for (size_t i = first; i < last; ++i)
            keys_[i] = uint64_t{sortable(points_[order_[i]][axis])} << 32 | order_[i];
        const auto at = [&](size_t i) { return keys_.begin() + ptrdiff_t(i); };
        std::nth_element(at(first), at(middle), at(last));
        for (size_t i = first; i < last; ++i) order_[i] = uint32_t(keys_[i]);
        split(first, middle);
        split(middle, last);
    }

private:
    std::span<const Vec3> points_;
    std::span<uint32_t> order_;
    std::vector<uint64_t> keys_;
};

}  // namespace

std::vector<uint32_t> packet_order(std::span<const Vec3> points) {
    std::vector<uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    PointSplitter(points, order).split(0, points.size());
    return order;
}

void gather_rows(const BitMatrix& from, std::span<const uint32_t> order, BitMatrix& to) {
    to.reset(from.rows(), from.columns());
    for (size_t i = 0; i < order.size(); ++i)
        std::memcpy(to.row(i), from.row(order[i]), from.row_words() * sizeof(Word));
}

void scatter_rows(const BitMatrix& from, std::span<const uint32_t> order, BitMatrix& to) {
    for (size_t i = 0; i < order.size(); ++i)
        std::memcpy(to.row(order[i]), from.row(i), from.row_words() * sizeof(Word));
}

}  // namespace viscache
