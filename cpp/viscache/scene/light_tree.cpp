#include "viscache/scene/light_tree.h"

#include <array>
#include <numeric>
#include <span>

namespace viscache {

namespace {

/// Rotates v around the unit vector `axis`.
Vec3 rotated(Vec3 v, Vec3 axis, double angle) {
    const float c = float(std::cos(angle)), s = float(std::sin(angle));
    return v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
}

}  // namespace

NormalCone united(const NormalCone& first, const NormalCone& second) {
    if (first.empty()) return second;
    if (second.empty()) return first;
    // The wider one first: it may hold the other whole
    const NormalCone& a = first.angle >= second.angle ? first : second;
    const NormalCone& b = first.angle >= second.angle ? second : first;
    const double between = std::acos(std::clamp(double(dot(a.axis, b.axis)), -1.0, 1.0));
    if (std::min(between + b.angle, M_PI) <= a.angle) return a;
    // The new cone touches the far sides of both: its axis lies between theirs, turned from the
    // wider one
    const double angle = 0.5 * (a.angle + between + b.angle);
    const Vec3 side = normalize(cross(a.axis, b.axis));
    // Opposite axes have no plane to turn in: all directions are safe
    if (angle >= M_PI || !(length2(side) > 0)) return {a.axis, M_PI};
    return {normalize(rotated(a.axis, side, angle - a.angle)), angle};
}

namespace {

/// Cuts are tried between bins of equal width, as in builders of ray tracing trees.
constexpr int kBins = 12;
constexpr int kDepthOfHalves =
    40;  // below this depth, groups are cut into halves: bounds the depth of the tree

/// What the split heuristic sums over a group of lights.
struct Group {
    Bounds box;
    NormalCone normals;
    double intensity = 0;

    void add(const Group& g) {
        box.add(g.box);
        normals = united(normals, g.normals);
        intensity += g.intensity;
    }
    /// Surface area of the box. A share of its squared extents is added, because lights in a line have none.
    double area() const {
        const Vec3 e = box.hi - box.lo;
        const double x = e.x, y = e.y, z = e.z;
        return x * y + y * z + z * x + 0.01 * (x * x + y * y + z * z);
    }
    /// Measure of the directions into which the group can shine: the cone of normals, widened by the
    /// hemisphere of each light and weighted by its cosine.
    double directions() const {
        const double o = normals.angle, w = std::min(o + 0.5 * M_PI, M_PI);
        return 2 * M_PI * (1 - std::cos(o)) +
               0.5 * M_PI * (2 * w * std::sin(o) - std::cos(o - 2 * w) - 2 * o * std::sin(o) + std::cos(o));
    }
    double cost() const { return intensity * area() * directions(); }
};

Group group_of(const EmissiveTriangle& t) {
    Group g;
    for (const Vec3 p : {t.a, t.b, t.c}) g.box.add(p);
    // Two sides shine every way
    g.normals = {t.normal, t.two_sided ? M_PI : 0.0};
    g.intensity = luminance_in_double(t.radiance) * t.area;
    return g;
}

Group group_of(const SphereLight& s) {
    Group g;
    const Vec3 side{s.radius, s.radius, s.radius};
    g.box.add(s.center - side);
    g.box.add(s.center + side);
    g.normals = {{0, 0, 1}, M_PI};
    // The disk that a far point sees
    g.intensity = luminance_in_double(s.radiance) * M_PI * double(s.radius) * s.radius;
    return g;
}

LightGroupBounds bounds_of(const Group& g) {
    // Grown, so that bounds in float never leave out a light of the group
    constexpr double kConeSlack = 1e-3;  // radians, for rounding
    LightGroupBounds b;
    b.center = g.box.center();
    b.radius = length(g.box.hi - b.center) * 1.001f + 1e-6f * g.box.magnitude();
    b.axis = g.normals.axis;
    const double angle = g.normals.angle + kConeSlack;
    b.every_way = angle >= M_PI;
    b.normals = {float(std::cos(angle)), float(std::sin(angle))};
    b.intensity = g.intensity;
    return b;
}

/// Splits groups of lights by the surface area and orientation heuristic.
class Builder {
public:
    Builder(std::vector<Group> lights, std::vector<LightTree::Node>& nodes, std::vector<uint32_t>& leaf_of)
        : lights_(std::move(lights)), order_(lights_.size()), nodes_(nodes), leaf_of_(leaf_of) {
        std::iota(order_.begin(), order_.end(), 0u);
        // A binary tree with one light per leaf has 2n − 1 nodes
        nodes_.reserve(2 * lights_.size());
        leaf_of_.resize(lights_.size());
        build(order_, 0, 0);
    }

private:
    using Range = std::span<uint32_t>;

    Group build(Range range, uint32_t parent, int depth) {
        // The first child follows its parent, so a node stores the place of the other alone
        const uint32_t at = uint32_t(nodes_.size());
        nodes_.push_back({});
        nodes_[at].parent = parent;
        if (range.size() == 1) {
            const uint32_t light = range.front();
            nodes_[at].box = lights_[light].box;
            nodes_[at].other = light;
            nodes_[at].leaf = true;
            leaf_of_[light] = at;
            return lights_[light];
        }
        const size_t first = split(range, depth);
        Group all = build(range.first(first), at, depth + 1);
        const uint32_t other = uint32_t(nodes_.size());
        all.add(build(range.subspan(first), at, depth + 1));
        nodes_[at].other = other;
        nodes_[at].box = all.box;
        nodes_[at].bounds = bounds_of(all);
        return all;
    }

    /// Orders the range in two parts. Returns the length of the first one.
    size_t split(Range range, int depth) {
        Bounds centers;
        for (const uint32_t i : range) centers.add(lights_[i].box.center());
        const Vec3 extent = centers.hi - centers.lo;
        Cut best;
        if (depth < kDepthOfHalves)
            for (int axis = 0; axis < 3; ++axis)
                if (extent[axis] > 0) try_axis(range, centers, axis, best);
        // Lights at one place, or a tree that is too deep
        if (best.axis < 0) return halve(range, extent);
        const auto middle = std::partition(
            range.begin(), range.end(), [&](uint32_t i) { return bin(i, centers, best.axis) < best.bins; });
        return size_t(middle - range.begin());
    }

    struct Cut {
        double cost = std::numeric_limits<double>::infinity();
        int axis = -1;
        int bins = 0;  ///< number of bins in the first part
    };

    int bin(uint32_t light, const Bounds& centers, int axis) const {
        const float from = centers.lo[axis], size = centers.hi[axis] - from;
        // The same expression decides in which bin a light counts and on which side of the cut it
        // lies
        const float place = (lights_[light].box.center()[axis] - from) / size;
        return std::clamp(int(place * kBins), 0, kBins - 1);
    }

    void try_axis(Range range, const Bounds& centers, int axis, Cut& best) const {
        std::array<Group, kBins> bins;
        for (const uint32_t i : range) bins[size_t(bin(i, centers, axis))].add(lights_[i]);
        // Costs of all lower parts in one sweep, of the upper ones in another
        std::array<double, kBins> below{};
        Group sum;
        for (size_t i = 0; i + 1 < kBins; ++i) {
            sum.add(bins[i]);
            below[i] = sum.normals.empty() ? 0 : sum.cost();
        }
        // Thin groups are not cut along their short sides
        Bounds box;
        for (const Group& g : bins) box.add(g.box);
        const Vec3 e = box.hi - box.lo;
        const double factor = double(max_component(e)) / std::max(double(e[axis]), 1e-30);
        Group above;
        for (size_t i = kBins - 1; i > 0; --i) {
            above.add(bins[i]);
            // A cut with nothing on one side is none
            if (above.normals.empty() || below[i - 1] == 0) continue;
            const double cost = factor * (below[i - 1] + above.cost());
            if (cost < best.cost) best = {cost, axis, int(i)};
        }
    }

    /// Two halves along the longest extent.
    size_t halve(Range range, Vec3 extent) {
        int axis = 0;
        for (int i = 1; i < 3; ++i)
            if (extent[i] > extent[axis]) axis = i;
        const size_t half = range.size() / 2;
        std::nth_element(range.begin(), range.begin() + ptrdiff_t(half), range.end(),
                         [&](uint32_t a, uint32_t b) {
                             const float x = lights_[a].box.center()[axis], y = lights_[b].box.center()[axis];
                             // Ties by number: the same tree everywhere
                             return x < y || (x == y && a < b);
                         });
        return half;
    }

    std::vector<Group> lights_;
    std::vector<uint32_t> order_;
    std::vector<LightTree::Node>& nodes_;
    std::vector<uint32_t>& leaf_of_;
};

}  // namespace

LightTree::LightTree(const AreaLights& lights) : lights_(lights) {
    std::vector<Group> groups;
    groups.reserve(lights.size());
    for (const EmissiveTriangle& t : lights.triangles) groups.push_back(group_of(t));
    for (const SphereLight& s : lights.spheres) groups.push_back(group_of(s));
    Builder(std::move(groups), nodes_, leaf_of_);
}

double LightTree::node_importance(uint32_t node, const Receiver& r) const {
    const Node& n = nodes_[node];
    return n.leaf ? estimated_light(lights_, n.other, r) : importance(n.bounds, n.box, r);
}

namespace {

/// Largest double below 1: a rescaled number must stay in [0, 1).
constexpr double kBelowOne = 0x1.fffffffffffffp-1;

/// Draws whose ways have reached a node.
struct Arrived {
    uint32_t node;
    uint32_t first, last;
    double pmf;
};

}  // namespace

void LightTree::sample(const Receiver& r, std::span<LightDraw> draws, std::span<LightPick> picks) const {
    // All samples walk together: draws are sorted, so those of a node are one range
    std::array<Arrived, kMostWaiting> stack;
    size_t size = 0;
    stack[size++] = {0, 0, uint32_t(draws.size()), 1};
    while (size > 0) {
        const Arrived at = stack[--size];
        const Node& node = nodes_[at.node];
        if (node.leaf) {
            for (uint32_t i = at.first; i < at.last; ++i) picks[draws[i].sample] = {node.other, at.pmf};
            continue;
        }
        const double a = node_importance(at.node + 1, r), b = node_importance(node.other, r);
        // Neither side can shine at the receiver
        if (!(a + b > 0)) {
            for (uint32_t i = at.first; i < at.last; ++i) picks[draws[i].sample] = {};
            continue;
        }
        // Numbers below the share go to the first child; each part is stretched to [0, 1) again,
        // which keeps its stratification
        const double share = a / (a + b);
        uint32_t middle = at.first;
        for (; middle < at.last && draws[middle].u < share; ++middle)
            draws[middle].u = std::min(draws[middle].u / share, kBelowOne);
        for (uint32_t i = middle; i < at.last; ++i)
            draws[i].u = std::min((draws[i].u - share) / (1 - share), kBelowOne);
        if (middle < at.last) stack[size++] = {node.other, middle, at.last, at.pmf * (1 - share)};
        if (at.first < middle) stack[size++] = {at.node + 1, at.first, middle, at.pmf * share};
    }
}

double LightTree::pmf(const Receiver& r, size_t light) const {
    double pmf = 1;
    // From the leaf up: the product of the choices that lead to it
    for (uint32_t at = leaf_of_[light]; at != 0; at = nodes_[at].parent) {
        const uint32_t one = nodes_[at].parent + 1, other = nodes_[nodes_[at].parent].other;
        const double a = node_importance(one, r), b = node_importance(other, r);
        if (!(a + b > 0)) return 0;
        const double share = a / (a + b);
        pmf *= at == one ? share : 1 - share;
    }
    return pmf;
}

}  // namespace viscache
