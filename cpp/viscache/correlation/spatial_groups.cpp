#include "viscache/correlation/spatial_groups.h"

#include <algorithm>
#include <numeric>

#include "viscache/math/bounds.h"

namespace viscache {

namespace {

int longest_axis(const Bounds& b) {
    const Vec3 size = b.hi - b.lo;
    if (size.x >= size.y && size.x >= size.z) return 0;
    return size.y >= size.z ? 1 : 2;
}

/// Assigns the groups [first, first + count) to `members`; count is a power of two.
void halve(std::span<uint32_t> members, int first, int count, std::span<const Vec3> points,
           std::vector<int32_t>& group) {
    if (count == 1) {
        for (uint32_t i : members) group[i] = first;
        return;
    }
    Bounds box;
    for (uint32_t i : members) box.add(points[i]);
    // The longest axis: groups stay compact, and points of different groups are far apart.
    const int axis = longest_axis(box);
    const size_t half = members.size() / 2;
    std::nth_element(members.begin(), members.begin() + ptrdiff_t(half), members.end(),
                     [&](uint32_t a, uint32_t b) {
                         const float va = points[a][axis], vb = points[b][axis];
                         // The index breaks ties, so groups do not depend on the library.
                         return va < vb || (va == vb && a < b);
                     });
    halve(members.first(half), first, count / 2, points, group);
    halve(members.subspan(half), first + count / 2, count / 2, points, group);
}

}  // namespace

std::vector<int32_t> spatial_groups(std::span<const Vec3> points) {
    std::vector<uint32_t> members(points.size());
    std::iota(members.begin(), members.end(), 0u);
    std::vector<int32_t> group(points.size());
    halve(members, 0, kSpatialGroups, points, group);
    return group;
}

}  // namespace viscache
