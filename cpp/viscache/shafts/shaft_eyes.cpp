#include "viscache/shafts/shaft_eyes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace viscache {

namespace {

constexpr size_t kChildren = 4;

size_t quarter(size_t n) { return (n + kChildren - 1) / kChildren; }

/// In double: sums of thousands of normals, and cross products of short differences.
struct Normal {
    double x = 0, y = 0, z = 0;
    double square() const { return x * x + y * y + z * z; }
};

Normal sum_of(std::span<const Vec3> normals) {
    Normal sum;
    for (const Vec3 n : normals) {
        sum.x += double(n.x);
        sum.y += double(n.y);
        sum.z += double(n.z);
    }
    return sum;
}

/// Normal of the plane through the first point, the farthest from it, and the farthest from their line. Zero
/// if all points are on one line.
Normal across(std::span<const Vec3> points) {
    const auto way = [&](Vec3 p) {
        return Normal{double(p.x) - points[0].x, double(p.y) - points[0].y, double(p.z) - points[0].z};
    };
    Normal line, best;
    for (const Vec3 p : points)
        if (const Normal w = way(p); w.square() > line.square()) line = w;
    for (const Vec3 p : points) {
        const Normal w = way(p);
        const Normal n{line.y * w.z - line.z * w.y, line.z * w.x - line.x * w.z, line.x * w.y - line.y * w.x};
        if (n.square() > best.square()) best = n;
    }
    return best;
}

/// Box and slab of the points of a node.
ShaftEyeNode node_over(std::span<const Vec3> points, std::span<const Vec3> normals) {
    ShaftEyeNode node{};
    Bounds box;
    for (const Vec3 p : points) box.add(p);
    // The slab is thin where points lie on one flat surface: along its normal
    const Normal n = normals.empty() ? across(points) : sum_of(normals);
    node.lo = box.lo;
    node.hi = box.hi;
    node.centre = (box.lo + box.hi) * 0.5f;
    node.half = (box.hi - box.lo) * 0.5f;
    node.size = max_component(box.hi - box.lo);
    const double length = std::sqrt(n.square());
    // Any unit vector will do where normals cancel or are not finite
    const bool usable = length > 0 && std::isfinite(length);
    node.normal =
        usable ? Vec3{float(n.x / length), float(n.y / length), float(n.z / length)} : Vec3{1, 0, 0};
    // With the normal as it was rounded, in double: no point lies outside of the slab
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const Vec3 p : points) {
        const double at =
            double(node.normal.x) * p.x + double(node.normal.y) * p.y + double(node.normal.z) * p.z;
        least = std::min(least, at);
        most = std::max(most, at);
    }
    node.mid = 0.5 * (least + most);
    node.reach = 0.5 * (most - least);
    return node;
}

}  // namespace

void ShaftEyes::build(std::span<const Vec3> origin, std::span<const Vec3> normal,
                      std::span<const uint32_t> order, float scale) {
    const size_t count = order.size();
    const size_t filled = (count + kShaftLanes - 1) / kShaftLanes * kShaftLanes;
    std::vector<Vec3> points(count), normals(normal.empty() ? 0 : count);
    size_ = count;
    x.resize(filled);
    y.resize(filled);
    z.resize(filled);
    magnitude_ = 0;
    for (size_t i = 0; i < filled; ++i) {
        // The last packet repeats its first point, which makes its box no larger
        const size_t from = i < count ? i : count - 1 - (count - 1) % kShaftLanes;
        const Vec3 p = origin[order[from]] * scale;
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
        // Repeated points have no part in nodes
        if (i >= count) continue;
        points[i] = p;
        if (!normal.empty()) normals[i] = normal[order[i]];
        magnitude_ = std::max({magnitude_, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
    }
    nodes.clear();
    // Level by level up to one root. Points are sorted along a curve, so four neighbours make a
    // small parent
    for (size_t n = packets(), points_below = kShaftLanes; n; n = quarter(n), points_below *= kChildren) {
        nodes.emplace_back(n);
        for (size_t i = 0; i < n; ++i) {
            const size_t first = i * points_below, some = std::min(points_below, count - first);
            const auto own =
                normals.empty() ? std::span<const Vec3>() : std::span(normals).subspan(first, some);
            nodes.back()[i] = node_over(std::span(points).subspan(first, some), own);
        }
        if (n == 1) break;
    }
}

void ShaftColumns::resize(const ShaftEyes& eyes) {
    packets_ = eyes.packets();
    // One line more than a multiple of lines: columns of a packet fall into different sets of the cache
    stride_ = (packets_ + 31) / 32 * 32 + 32;
    wanted_.resize(stride_ * kWordBits);
    visible_.assign(stride_ * kWordBits, 0);
    // Sizes follow the tree of the tile; memory is reused from tile to tile
    any_.resize(eyes.levels());
    for (size_t l = 0; l < eyes.levels(); ++l) any_[l].assign(eyes.nodes[l].size(), 0);
}

void ShaftColumns::read(Word wanted, const ShaftEyes& eyes) {
    resize(eyes);
    for (auto& level : any_) std::ranges::fill(level, wanted);
    // Lanes beyond the last point ask nothing
    const size_t last = packets_ - 1, used = eyes.size() - last * kShaftLanes;
    for (size_t k = 0; k < kWordBits; ++k) {
        const bool asked = wanted >> k & 1;
        std::fill_n(&wanted_[k * stride_], packets_, uint16_t(asked ? 0xffff : 0));
        if (asked) wanted_[k * stride_ + last] = uint16_t((1u << used) - 1);
    }
}

void ShaftColumns::read(const BitMatrix& wanted, size_t w, const ShaftEyes& eyes) {
    resize(eyes);
    uint16_t columns[kWordBits];
    for (size_t p = 0; p < packets_; ++p) {
        Word all = 0;
        const size_t first = p * kShaftLanes, last = std::min(first + kShaftLanes, wanted.rows());
        for (size_t i = first; i < last; ++i) all |= wanted.row(i)[w];
        any_[0][p] = all;
        // A transposition of 16 rows × 64 columns: shafts go light by light
        columns16(wanted, first, w, columns);
        for (size_t k = 0; k < kWordBits; ++k) wanted_[k * stride_ + p] = columns[k];
    }
    // Upwards, so that a descent can stop where nobody below asks
    for (size_t l = 1; l < any_.size(); ++l)
        for (size_t i = 0; i < any_[l - 1].size(); ++i) any_[l][i / kChildren] |= any_[l - 1][i];
}

void ShaftColumns::write(BitMatrix& visible, size_t w) const {
    uint16_t columns[kWordBits];
    for (size_t p = 0; p < packets_; ++p) {
        for (size_t k = 0; k < kWordBits; ++k) columns[k] = visible_[k * stride_ + p];
        or_columns16(visible, p * kShaftLanes, w, columns);
    }
}

}  // namespace viscache
