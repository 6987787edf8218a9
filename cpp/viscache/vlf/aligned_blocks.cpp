#include "viscache/vlf/aligned_blocks.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

namespace viscache {

namespace {

/// Size classes of triangles in processing order: large area, which descend the tree one by one; long;
/// medium; and the many small ones.
constexpr size_t kSizes = 4;
constexpr size_t kLarge = 1;

/// Size class of a triangle; `scale` makes the radius of the scene about one.
size_t size_class(const FlatTriangle& t, float scale) {
    const float extent = t.bounds().diagonal() * scale;
    // Twice the area of the triangle, which says how many points it may block
    const float area = length(cross((t.b - t.a) * scale, (t.c - t.a) * scale));
    return area >= 1.f / 256 ? 0 : extent >= 1.f / 4 ? 1 : extent >= 1.f / 16 ? 2 : 3;
}

/// Only sorts of longer runs look for cancellation.
constexpr size_t kPointsPerCheck = 1 << 16;

/// Where a run of n is split: near the middle, at a multiple of the largest run that is to stay compact.
/// Splits are at multiples of the unit, so that no run of 4096, 256 or 16 points joins two distant halves:
///
///     10,000 points    |       4096       |       4096       |  1808  |
///      1,808 points    |     1024 = 4 · 256     |     784      |
///
/// Nodes of the implicit 16-ary tree (`BoxLevel`) are exactly these runs.
size_t cut(size_t n) {
    const size_t unit = n > kLanes * kLanes * kLanes ? kLanes * kLanes * kLanes
                        : n > kLanes * kLanes        ? kLanes * kLanes
                                                     : kLanes;
    const size_t middle = (n / 2 + unit / 2) / unit * unit;
    return middle == 0 ? unit : middle >= n ? (n - 1) / unit * unit : middle;
}

/// Sorts `order` recursively; each split is a median along the longest side of the box of its points.
void kd_sort(std::span<uint32_t> order, std::span<const Vec3> points, const Control& control) {
    while (order.size() > kLanes) {
        if (order.size() > kPointsPerCheck) control.check();
        Bounds box;
        for (uint32_t i : order) box.add(points[i]);
        const Vec3 size = box.hi - box.lo;
        const int axis = size.x >= size.y ? (size.x >= size.z ? 0 : 2) : (size.y >= size.z ? 1 : 2);
        const size_t middle = cut(order.size());
        // Equal coordinates are split by the index, so which points form a packet does not depend on the
        // standard library.
        std::nth_element(order.begin(), order.begin() + std::ptrdiff_t(middle), order.end(),
                         [&](uint32_t a, uint32_t b) {
                             const float x = points[a][axis], y = points[b][axis];
                             return x < y || (x == y && a < b);
                         });
        // Recursion takes the first half, the loop the second one: the stack stays as deep as the tree.
        kd_sort(order.first(middle), points, control);
        order = order.subspan(middle);
    }
}

}  // namespace

std::vector<uint32_t> kd_order(std::span<const Vec3> points, const Control& control) {
    std::vector<uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0u);
    kd_sort(order, points, control);
    return order;
}

Placement Placement::of(const Bounds& bounds) {
    if (bounds.empty()) return {{}, 0};  // an empty scene: all points coincide
    const float radius = 0.5f * bounds.diagonal();
    // 2^(power−1) ≤ radius < 2^power. The limit of ±100 keeps the scale itself a normal float.
    const int power = radius > 0 ? std::clamp(std::ilogb(radius) + 1, -100, 100) : 0;
    return {bounds.center(), std::ldexp(1.f, -power)};
}

TriangleBlocks::TriangleBlocks(std::shared_ptr<const Scene> of) : scene(std::move(of)) {
    const FlatTriangles flat = flat_triangles(*scene);
    const auto& list = flat.triangles;
    placement = Placement::of(flat.bounds);
    triangles = list.size();
    // Large triangles come first: they block many points at once, and later triangles skip those points
    // Order of the blocks:
    //
    //     |          solid triangles           |       with alpha masks             |
    //     | large | long   medium   small      | large   long   medium   small      |
    //             ^ first_small                ^ first_masked
    //
    // Only large solid triangles block whole nodes (aligned_cover.inc). A masked one has holes, so it is
    // tested point by point whatever its size.
    std::vector<uint32_t> kinds[2 * kSizes];
    for (uint32_t i = 0; i < triangles; ++i)
        kinds[scene->has_cutout(flat.sources[i].mesh) * kSizes + size_class(list[i], placement.scale)]
            .push_back(i);
    for (size_t kind = 0; kind < 2 * kSizes; ++kind) {
        if (kind == kSizes) first_masked = blocks;
        if (kind == kLarge) first_small = blocks;
        blocks += in_lanes(kinds[kind].size());
    }
    for (auto& row : corner)
        for (LaneArray& a : row) a.resize(blocks * kLanes);
    size_t lane = 0;
    for (size_t kind = 0; kind < 2 * kSizes; ++kind) {
        const std::vector<uint32_t>& some = kinds[kind];
        std::vector<Vec3> middle;
        for (uint32_t i : some) middle.push_back(placement.apply(list[i].bounds().center()));
        // Neighbours in space form a block, so that its box is small and few packets overlap it.
        const std::vector<uint32_t> order = kd_order(middle, Control{});
        for (size_t k = 0; k < in_lanes(some.size()) * kLanes; ++k, ++lane) {
            // Padding lanes contain a corner of the last triangle three times. It has no area and hits
            // nothing, and it leaves the box of the block small.
            const uint32_t i = some[order[std::min(k, some.size() - 1)]];
            const FlatTriangle& t = list[i];
            set_lane(lane, k < some.size() ? t : FlatTriangle{t.a, t.a, t.a});
            if (kind >= kSizes) masked.push_back(flat.sources[i]);
        }
        if (kind >= kLarge) add_groups((lane - in_lanes(some.size()) * kLanes) / kLanes, lane / kLanes);
    }
}

/// Joins up to 16 successive blocks of a class. The box of a group is rotated before its 256 triangles are,
/// and spares them if no packet overlaps it.
void TriangleBlocks::add_groups(size_t first, size_t last) {
    for (size_t b = first; b < last; b += kLanes) {
        const size_t end = std::min(last, b + kLanes);
        Bounds box;
        for (size_t lane = b * kLanes; lane < end * kLanes; ++lane)
            for (const auto& c : corner) box.add(Vec3{c[0][lane], c[1][lane], c[2][lane]});
        groups.push_back({b, end - b, box.center(), (box.hi - box.lo) * 0.5f});
    }
}

void TriangleBlocks::set_lane(size_t lane, const FlatTriangle& t) {
    const Vec3 corners[3] = {placement.apply(t.a), placement.apply(t.b), placement.apply(t.c)};
    for (size_t c = 0; c < 3; ++c)
        for (int axis = 0; axis < 3; ++axis) corner[c][axis][lane] = corners[c][axis];
}

PointPackets::PointPackets(const Placement& placement, std::span<const Vec3> position,
                           std::span<const Vec3> normal, const Control& control,
                           std::span<const uint32_t> given)
    : points(position.size()), packets(in_lanes(points)) {
    // Lanes are numbered with 32 bits, padding included.
    if (points > UINT32_MAX - kLanes) throw std::length_error("points must be fewer than 2^32 - 16");
    std::vector<Vec3> placed(points);
    for (size_t i = 0; i < points; ++i) {
        placed[i] = placement.apply(position[i]);
        const float far = std::max({std::fabs(placed[i].x), std::fabs(placed[i].y), std::fabs(placed[i].z)});
        // Written so that NaN fails, too
        if (!(far <= kFarthest))
            throw std::invalid_argument("points must lie within 1e9 times the scene's size, row " +
                                        std::to_string(i) + " does not");
    }
    order = given.empty() ? kd_order(placed, control) : std::vector(given.begin(), given.end());
    asked.assign(packets, 0);
    for (LaneArray* a : {&x, &y, &z, &nx, &ny, &nz}) a->resize(packets * kLanes);
    // Padding lanes repeat the last point: they do not enlarge the box of their packet, and `asked` leaves
    // them out.
    for (size_t lane = 0; lane < packets * kLanes; ++lane) {
        const size_t i = order[std::min(lane, points - 1)];
        const Vec3 p = placed[i], n = normal[i];
        x[lane] = p.x;
        y[lane] = p.y;
        z[lane] = p.z;
        nx[lane] = n.x;
        ny[lane] = n.y;
        nz[lane] = n.z;
        if (lane < points) asked[lane / kLanes] |= uint16_t(1u << lane % kLanes);
    }
}

AxisState::AxisState(size_t most_packets)
    : free(most_packets), packets(most_packets), lane(most_packets * kLanes) {
    // Level 0 has a box per packet, and each further level a box per 16 boxes below. Arrays are padded to
    // whole nodes, because a node's 16 boxes are loaded at once. The root has at most 16.
    for (size_t n = most_packets;; n = in_lanes(n)) {
        BoxLevel& level = levels.emplace_back();
        level.nodes = n;
        for (LaneArray* a : {&level.x0, &level.x1, &level.y0, &level.y1, &level.from_up, &level.from_down,
                             &level.to_up, &level.to_down})
            a->resize(in_lanes(n) * kLanes);
        if (n <= kLanes) break;
    }
}

}  // namespace viscache
