#include "viscache/shafts/shaft_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace viscache {

namespace {

constexpr uint32_t kLeaf = kShaftLanes;
constexpr int kBins = 32;
/// Parts with more triangles are split one level at a time, all parts of a level at once. Smaller ones belong
/// to one thread.
constexpr uint32_t kOwnPart = 4096;
constexpr size_t kBoxesAtOnce = 1 << 14;

Bounds bounds_of(const ShaftTriangle& t) {
    return {min(min(t.corner[0], t.corner[1]), t.corner[2]), max(max(t.corner[0], t.corner[1]), t.corner[2])};
}

/// Sides of a triangle in double, where they are exact or nearly so.
struct Sides {
    double side[3][3];
    explicit Sides(const ShaftTriangle& t) {
        for (int i = 0; i < 3; ++i)
            for (int x = 0; x < 3; ++x) side[i][x] = double(t.corner[(i + 1) % 3][x]) - t.corner[i][x];
    }
    double longest() const {
        double most = 0;
        for (const auto& s : side) most = std::max(most, s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
        return std::sqrt(most);
    }
    double twice_area() const {
        double sum = 0;
        for (int x = 0; x < 3; ++x) {
            const int y = (x + 1) % 3, z = (x + 2) % 3;
            const double n = side[0][y] * side[1][z] - side[0][z] * side[1][y];
            sum += n * n;
        }
        return std::sqrt(sum);
    }
    double least_height() const { return longest() > 0 ? twice_area() / longest() : 0; }
};

ShaftPart range(uint32_t first, uint32_t last) {
    ShaftPart part;
    part.first = first;
    part.count = last - first;
    return part;
}
ShaftPart left_of(const ShaftPart& part, uint32_t middle) { return range(part.first, middle); }
ShaftPart right_of(const ShaftPart& part, uint32_t middle) { return range(middle, part.first + part.count); }

/// Sets the halves of a part.
void join(std::vector<ShaftPart>& parts, size_t index, int32_t left, int32_t right) {
    parts[index].left = left;
    parts[index].right = right;
    parts[index].width = std::max(parts[size_t(left)].width, parts[size_t(right)].width);
}

/// Splits ranges of one order.
class PartSplitter {
public:
    PartSplitter(std::span<const ShaftTriangle> triangles, int threads, const Control& control)
        : triangles_(triangles), control_(control), box_(triangles.size()), order_(triangles.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
        const size_t n = triangles.size();
        parallel_for((n + kBoxesAtOnce - 1) / kBoxesAtOnce, threads, [&](size_t c, int) {
            for (size_t i = c * kBoxesAtOnce; i < std::min(n, (c + 1) * kBoxesAtOnce); ++i)
                box_[i] = bounds_of(triangles[i]);
        });
    }

    /// Sets the box of a part. Returns the start of its right half, or the end of the part if it is a leaf.
    uint32_t open(ShaftPart& part) {
        control_.check();
        Bounds centres;
        for (uint32_t i = part.first; i < part.first + part.count; ++i) {
            const Bounds& b = box_[order_[i]];
            part.box.add(b);
            centres.add((b.lo + b.hi) * 0.5f);
        }
        if (part.count > kLeaf) return divide(part.first, part.count, centres);
        for (uint32_t i = part.first; i < part.first + part.count; ++i)
            part.width = std::max(part.width, width_of(order_[i]));
        return part.first + part.count;
    }
    /// Splits a part down to leaves. `parts` receives it and all below; returns its index there.
    int32_t split(ShaftPart part, std::vector<ShaftPart>& parts) {
        const uint32_t middle = open(part);
        const size_t index = parts.size();
        parts.push_back(part);
        if (part.count > kLeaf) {
            const int32_t left = split(left_of(part, middle), parts);
            const int32_t right = split(right_of(part, middle), parts);
            join(parts, index, left, right);
        }
        return int32_t(index);
    }
    std::vector<uint32_t>& order() { return order_; }

private:
    struct Cut {
        int axis = -1;
        int bin = 0;
    };
    /// Maps centres of boxes to bins along one axis.
    struct Bins {
        int axis;
        float lo, scale;
        int operator()(const Bounds& b) const {
            const float at = (0.5f * (b.lo[axis] + b.hi[axis]) - lo) * scale;
            return std::min(kBins - 1, std::max(0, int(at)));
        }
    };

    float width_of(uint32_t triangle) const {
        // A triangle with holes covers nothing
        if (!triangles_[triangle].solid) return 0;
        return float(Sides(triangles_[triangle]).least_height());
    }

    /// Reorders a range and returns the start of its right part.
    uint32_t divide(uint32_t first, uint32_t count, const Bounds& centres) {
        const Cut cut = cheapest_cut(first, count, centres);
        const auto begin = order_.begin() + first;
        uint32_t middle = first + count / 2;
        if (cut.axis >= 0) {
            const Bins bins = bins_along(cut.axis, centres);
            middle = uint32_t(
                std::partition(begin, begin + count, [&](uint32_t i) { return bins(box_[i]) < cut.bin; }) -
                order_.begin());
        }
        // All centres in one place: any halves will do
        return middle == first || middle == first + count ? first + count / 2 : middle;
    }

    static Bins bins_along(int axis, const Bounds& centres) {
        return {axis, centres.lo[axis], float(kBins) / (centres.hi[axis] - centres.lo[axis])};
    }

    Cut cheapest_cut(uint32_t first, uint32_t count, const Bounds& centres) const {
        // The price of a side is its area times its blocks, counted as half full
        const auto price = [](const Bounds& b, uint32_t n) { return b.half_area() * float((n + 7) / 8); };
        Cut best;
        float least = std::numeric_limits<float>::infinity();
        for (int axis = 0; axis < 3; ++axis) {
            if (!(centres.hi[axis] > centres.lo[axis])) continue;
            const Bins bins = bins_along(axis, centres);
            Bounds box[kBins];
            uint32_t n[kBins] = {};
            for (uint32_t i = first; i < first + count; ++i) {
                const int k = bins(box_[order_[i]]);
                box[k].add(box_[order_[i]]);
                ++n[k];
            }
            float right_price[kBins];
            Bounds side;
            uint32_t on_side = 0;
            for (int k = kBins - 1; k > 0; --k) {
                side.add(box[k]);
                on_side += n[k];
                right_price[k] = price(side, on_side);
            }
            side = {};
            on_side = 0;
            for (int k = 1; k < kBins; ++k) {
                side.add(box[k - 1]);
                on_side += n[k - 1];
                if (on_side == 0 || on_side == count) continue;
                const float cost = price(side, on_side) + right_price[k];
                if (cost >= least) continue;
                least = cost;
                best = {axis, k};
            }
        }
        return best;
    }

    std::span<const ShaftTriangle> triangles_;
    const Control& control_;
    std::vector<Bounds> box_;
    std::vector<uint32_t> order_;
};

/// Puts the parts below a small part into the tree, at its own index.
void graft(std::vector<ShaftPart>& tree, size_t index, const std::vector<ShaftPart>& below) {
    const auto offset = int32_t(tree.size()) - 1;  // below[0] takes the place of the small part itself
    const auto moved = [&](ShaftPart part) {
        if (!part.is_leaf()) {
            part.left += offset;
            part.right += offset;
        }
        return part;
    };
    tree[index] = moved(below[0]);
    for (size_t i = 1; i < below.size(); ++i) tree.push_back(moved(below[i]));
}

}  // namespace

double longest_side(const ShaftTriangle& triangle) { return Sides(triangle).longest(); }

ShaftParts split_into_parts(std::span<const ShaftTriangle> triangles, int threads, const Control& control) {
    PartSplitter splitter(triangles, threads, control);
    std::vector<ShaftPart> parts{range(0, uint32_t(triangles.size()))};
    std::vector<size_t> level{0}, small;
    size_t top = 0;  // number of parts above the small ones, and of these
    while (!level.empty()) {
        std::erase_if(level, [&](size_t i) {
            const bool own = parts[i].count <= kOwnPart;
            if (own) small.push_back(i);
            return own;
        });
        std::vector<uint32_t> middle(level.size());
        parallel_for(level.size(), threads,
                     [&](size_t i, int) { middle[i] = splitter.open(parts[level[i]]); });
        std::vector<size_t> next;
        for (size_t i = 0; i < level.size(); ++i) {
            const ShaftPart part = parts[level[i]];
            for (const ShaftPart& half : {left_of(part, middle[i]), right_of(part, middle[i])}) {
                next.push_back(parts.size());
                parts.push_back(half);
            }
            parts[level[i]].left = int32_t(parts.size()) - 2;
            parts[level[i]].right = int32_t(parts.size()) - 1;
        }
        level = std::move(next);
        top = parts.size();
    }
    std::vector<std::vector<ShaftPart>> below(small.size());
    parallel_for(small.size(), threads, [&](size_t i, int) { splitter.split(parts[small[i]], below[i]); });
    for (size_t i = 0; i < small.size(); ++i) graft(parts, small[i], below[i]);
    // Parts of the top come before their halves; small ones have their width already
    for (size_t i = top; i-- > 0;)
        if (!parts[i].is_leaf()) join(parts, i, parts[i].left, parts[i].right);
    return {std::move(splitter.order()), std::move(parts)};
}

}  // namespace viscache
