#include "viscache/visibility/shaft_tree.h"

#include <cmath>
#include <limits>
#include <numeric>

namespace viscache {

namespace {

constexpr uint32_t kLeaf = kShaftLanes;

float half_area(const Bounds& b) {
    if (b.empty()) return 0;
    const Vec3 e = b.hi - b.lo;
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

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

/// A binary tree by the surface area heuristic, made wide afterwards.
class Builder {
public:
    Builder(std::span<const ShaftTriangle> triangles, const Control& control)
        : triangles_(triangles), control_(control), box_(triangles.size()), order_(triangles.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
        for (size_t i = 0; i < triangles.size(); ++i) box_[i] = bounds_of(triangles[i]);
    }
    ShaftTree build() {
        if (triangles_.empty()) {
            tree_.nodes.push_back(ShaftNode{});
            return std::move(tree_);
        }
        const int32_t root = split(0, uint32_t(triangles_.size()));
        tree_.bounds = part(root).box;
        widen(root);
        return std::move(tree_);
    }

private:
    struct Part {
        Bounds box;
        int32_t left = -1, right = -1;
        uint32_t first = 0, count = 0;
        float width = 0;
        bool is_leaf() const { return left < 0; }
    };
    struct Cut {
        int axis = -1;
        int bin = 0;
    };
    static constexpr int kBins = 32;
    /// Maps centres of boxes to bins along one axis.
    struct Bins {
        int axis;
        float lo, scale;
        int operator()(const Bounds& b) const {
            const float at = (0.5f * (b.lo[axis] + b.hi[axis]) - lo) * scale;
            return std::min(kBins - 1, std::max(0, int(at)));
        }
    };

    Part& part(int32_t i) { return parts_[size_t(i)]; }

    int32_t split(uint32_t first, uint32_t count) {
        control_.check();
        Part here;
        here.first = first;
        here.count = count;
        Bounds centres;
        for (uint32_t i = first; i < first + count; ++i) {
            const Bounds& b = box_[order_[i]];
            here.box.add(b);
            centres.add((b.lo + b.hi) * 0.5f);
        }
        const int32_t index = int32_t(parts_.size());
        parts_.push_back(here);
        if (count <= kLeaf) {
            for (uint32_t i = first; i < first + count; ++i)
                part(index).width = std::max(part(index).width, width_of(order_[i]));
            return index;
        }
        const uint32_t middle = divide(first, count, centres);
        const int32_t left = split(first, middle - first);
        const int32_t right = split(middle, first + count - middle);
        part(index).left = left;
        part(index).right = right;
        part(index).width = std::max(part(left).width, part(right).width);
        return index;
    }

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
        const auto price = [](const Bounds& b, uint32_t n) { return half_area(b) * float((n + 7) / 8); };
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

    /// Makes a node of the largest parts below one part; returns its index.
    int32_t widen(int32_t top) {
        std::vector<int32_t> kids{top};
        while (kids.size() < kShaftLanes) {
            size_t largest = kids.size();
            for (size_t i = 0; i < kids.size(); ++i) {
                if (part(kids[i]).is_leaf()) continue;
                const bool first = largest == kids.size();
                if (first || half_area(part(kids[i]).box) > half_area(part(kids[largest]).box)) largest = i;
            }
            if (largest == kids.size()) break;
            const Part& opened = part(kids[largest]);
            kids[largest] = opened.left;
            kids.push_back(opened.right);
        }
        const size_t index = tree_.nodes.size();
        tree_.nodes.push_back(ShaftNode{});
        for (size_t lane = 0; lane < kids.size(); ++lane) {
            const Part& kid = part(kids[lane]);
            const int32_t child = kid.is_leaf() ? ~add_block(kid) : widen(kids[lane]);
            ShaftNode& node = tree_.nodes[index];
            for (int x = 0; x < 3; ++x) {
                node.lo[x][lane] = kid.box.lo[x];
                node.hi[x][lane] = kid.box.hi[x];
            }
            node.size[lane] = max_component(kid.box.hi - kid.box.lo);
            node.width[lane] = kid.width;
            node.child[lane] = child;
            node.used |= 1u << lane;
            if (kid.is_leaf()) node.leaves |= 1u << lane;
        }
        return int32_t(index);
    }

    int32_t add_block(const Part& leaf) {
        ShaftBlock block{};
        for (uint32_t lane = 0; lane < kShaftLanes; ++lane) {
            const bool in = lane < leaf.count;
            const ShaftTriangle& t = triangles_[order_[leaf.first + (in ? lane : 0)]];
            for (int c = 0; c < 9; ++c) block.corner[c][lane] = in ? t.corner[c / 3][c % 3] : std::nanf("");
            // One more ulp than the rounding of the double
            block.longest[lane] = std::max(float(Sides(t).longest()) * 1.000001f, kShortestSide);
            if (in) block.used |= 1u << lane;
            if (in && !t.solid) block.holed |= 1u << lane;
        }
        tree_.blocks.push_back(block);
        return int32_t(tree_.blocks.size() - 1);
    }

    std::span<const ShaftTriangle> triangles_;
    const Control& control_;
    std::vector<Bounds> box_;
    std::vector<uint32_t> order_;
    std::vector<Part> parts_;
    ShaftTree tree_;
};

}  // namespace

uint64_t most_shaft_bytes(uint64_t triangles) {
    // The price of a cut keeps blocks at least half full on average, and a node has at least eight children
    const uint64_t blocks = triangles / (kShaftLanes / 2) + 1;
    return blocks * sizeof(ShaftBlock) + (blocks / 8 + 2) * sizeof(ShaftNode);
}

ShaftTree build_shaft_tree(std::span<const ShaftTriangle> triangles, const Control& control) {
    return Builder(triangles, control).build();
}

}  // namespace viscache
