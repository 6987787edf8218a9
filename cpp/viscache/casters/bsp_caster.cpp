#include "viscache/casters/bsp_caster.h"

namespace viscache {

namespace {

/// 1 / d, kept finite: a plane parallel to a ray lies far ahead of it or far behind.
float inverse(float d) {
    constexpr float kLeast = 1e-30f;
    return 1 / (std::fabs(d) > kLeast ? d : std::copysign(kLeast, d));
}

/// Used when steps are not counted.
struct NoSteps {
    void node() {}
    void leaf(uint32_t) {}
};

struct WaldKernel {
    const std::vector<WaldTriangle>& records;
    const Ray& ray;
    bool operator()(uint32_t record, float limit, TriangleHit& hit) const {
        return intersect_wald(records[record], ray, limit, hit);
    }
    uint32_t id(uint32_t record) const { return records[record].id; }
};

struct WatertightKernel {
    const std::vector<WatertightTriangle>& records;
    ShearedRay ray;
    bool operator()(uint32_t record, float limit, TriangleHit& hit) const {
        return intersect_watertight(records[record], ray, limit, hit);
    }
    uint32_t id(uint32_t record) const { return records[record].id; }
};

}  // namespace

BspCaster::BspCaster(std::shared_ptr<const Scene> scene, const BspSettings& settings, int threads,
                     Control& control)
    : scene_(std::move(scene)), kernel_(settings.kernel) {
    settings.validate();
    FlatTriangles flat = flat_triangles(*scene_);
    // Scenes far from the origin of the world keep their digits: the subtraction is exact
    origin_ = exact_origin(flat.bounds);
    for (FlatTriangle& t : flat.triangles) t = {t.a - origin_, t.b - origin_, t.c - origin_};
    tree_ = build_bsp(flat.triangles, settings, threads, control);
    extent_ = tree_.bounds.magnitude();
    place_records(flat.triangles);
    sources_ = std::move(flat.sources);
    for (uint32_t m = 0; m < scene_->meshes().size(); ++m) cutouts_ |= scene_->has_cutout(m);
    stats_ = {.triangles = sources_.size(), .degenerate = flat.degenerate};
    count_nodes();
}

/// Stores triangles in the order in which leaves list them, so that those of a leaf are adjacent. Each keeps
/// the index of its triangle.
void BspCaster::place_records(std::span<const FlatTriangle> triangles) {
    std::vector<uint32_t> place(triangles.size(), kNoHit);
    uint32_t next = 0;
    for (uint32_t& id : tree_.ids) {
        const FlatTriangle& t = triangles[id];
        if (place[id] == kNoHit) {
            // The first leaf that lists a triangle decides its place; later ones refer to it
            place[id] = next++;
            if (kernel_ == TriangleKernel::kWald)
                wald_.push_back(wald_triangle(t.a, t.b, t.c, id));
            else
                corners_.push_back({t.a, t.b, t.c, id, {}});
        }
        id = place[id];
    }
}

void BspCaster::count_nodes() {
    for (const BspNode& n : tree_.nodes)
        if (n.is_leaf()) {
            ++stats_.leaves;
            stats_.empty_leaves += n.count() == 0;
        }
    stats_.nodes = tree_.nodes.size();
    stats_.references = tree_.ids.size();
    stats_.max_depth = tree_.max_depth;
    stats_.depth = tree_.depth;
    stats_.bytes = tree_.bytes() + sources_.size() * (sizeof(WaldTriangle) + sizeof(TriangleSource));
}

/// Calls limit = leaf(node, limit) for the leaves along a ray, front to back. No leaf beyond the limit is
/// entered; a negative limit ends the walk.
///
/// Each plane is extended by `slack` in both directions, to cover the rounding errors of origins, hits and
/// planes.
template <class Leaf, class OnNode>
void BspCaster::walk(const Ray& ray, float limit, OnNode on_node, Leaf leaf) const {
    if (tree_.nodes.empty() || ray.d == Vec3{}) return;
    // As a length across planes; divided by the direction it is one along the ray
    const float off = kCellUlps * kUlp * std::max(max_abs(ray.o), extent_);
    struct Axis {
        float o, inverse, slack;
        uint32_t first;  ///< the child that the ray enters first
    };
    const auto axis_of = [&](float o, float d) {
        const float inv = inverse(d);
        return Axis{o, inv, off * std::fabs(inv), inv < 0 ? 1u : 0u};
    };
    // Signs and inverses once per ray, not once per node
    const Axis axes[3] = {axis_of(ray.o.x, ray.d.x), axis_of(ray.o.y, ray.d.y), axis_of(ray.o.z, ray.d.z)};
    float near = ray.t_min, far = limit;
    for (int a = 0; a < 3; ++a) {
        const Axis& axis = axes[a];
        const float t0 = (tree_.bounds.lo[a] - axis.o) * axis.inverse,
                    t1 = (tree_.bounds.hi[a] - axis.o) * axis.inverse;
        // NaN (infinity minus infinity) leaves the interval unchanged
        near = std::max(near, std::min(t0, t1) - axis.slack);
        far = std::min(far, std::max(t0, t1) + axis.slack);
    }
    struct Entry {
        uint32_t node;
        float near, far;
    };
    // One entry per level: only the farther child waits
    Entry stack[kMostBspDepth + 1];
    int entries = 0;
    uint32_t at = 0;
    if (!(near <= far)) return;
    for (;;) {
        const BspNode node = tree_.nodes[at];
        on_node();
        if (!node.is_leaf()) {
            const Axis& axis = axes[node.axis()];
            const float t = (node.plane() - axis.o) * axis.inverse;
            const uint32_t first = node.children() + axis.first, second = node.children() + 1 - axis.first;
            // The plane lies beyond what is left of the ray, or before it: one child
            if (t - axis.slack > far) {
                at = first;
            } else if (t + axis.slack < near) {
                at = second;
            } else {
                stack[entries++] = {second, std::max(near, t - axis.slack), far};
                at = first;
                // Both children overlap by the slack, so that a hit in the plane is in both
                far = std::min(far, t + axis.slack);
            }
            continue;
        }
        if (node.count()) limit = leaf(node, limit);
        do {
            if (entries == 0) return;
            --entries;
            // What begins behind the hit cannot be nearer
        } while (stack[entries].near > limit);
        at = stack[entries].node;
        near = stack[entries].near;
        far = std::min(stack[entries].far, limit);
    }
}

bool BspCaster::solid(uint32_t id, const TriangleHit& hit) const {
    const TriangleSource& from = sources_[id];
    return scene_->solid_at(from.mesh, from.triangle, hit.u, hit.v);
}

template <class Kernel, class Steps>
NearestHit BspCaster::nearest_in(const Kernel& kernel, const Ray& local, Steps& steps) const {
    NearestHit best{local.t_max};
    walk(
        local, local.t_max, [&] { steps.node(); },
        [&](BspNode node, float) {
            steps.leaf(node.count());
            for (uint32_t i = node.first(), end = i + node.count(); i < end; ++i) {
                TriangleHit hit;
                if (!kernel(tree_.ids[i], best.t, hit)) continue;
                const uint32_t id = kernel.id(tree_.ids[i]);
                // Textures of holes are looked up last, for hits that would win
                if (best.nearer(hit, id) && (!cutouts_ || solid(id, hit))) best.take(hit, id);
            }
            return best.t;
        });
    return best;
}

template <class Kernel>
bool BspCaster::any_in(const Kernel& kernel, const Ray& local) const {
    bool found = false;
    walk(
        local, local.t_max, [] {},
        [&](BspNode node, float limit) {
            for (uint32_t i = node.first(), end = i + node.count(); i < end; ++i) {
                TriangleHit hit;
                if (!kernel(tree_.ids[i], limit, hit) || !(hit.t < limit)) continue;
                if (cutouts_ && !solid(kernel.id(tree_.ids[i]), hit)) continue;
                found = true;
                // Any hit is enough: a negative limit ends the walk
                return -kInfinity;
            }
            return limit;
        });
    return found;
}

Hit BspCaster::nearest(const Ray& ray) const {
    const Ray local = to_local(ray);
    NoSteps none;
    const NearestHit best = kernel_ == TriangleKernel::kWald
                                ? nearest_in(WaldKernel{wald_, local}, local, none)
                                : nearest_in(WatertightKernel{corners_, ShearedRay(local)}, local, none);
    if (best.id == kNoHit) return {};
    const TriangleSource& from = sources_[best.id];
    return {best.t, from.mesh, from.triangle, from.instance, best.u, best.v};
}

bool BspCaster::any(const Ray& ray) const {
    const Ray local = to_local(ray);
    return kernel_ == TriangleKernel::kWald ? any_in(WaldKernel{wald_, local}, local)
                                            : any_in(WatertightKernel{corners_, ShearedRay(local)}, local);
}

void BspCaster::intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const {
    for (size_t i = 0; i < rays.size(); ++i) hits[i] = nearest(rays[i]);
}

void BspCaster::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
    for (size_t i = 0; i < rays.size(); ++i) occluded[i] = any(rays[i]);
}

uint16_t BspCaster::occluded16(uint16_t mask, RayPacket16& p, Coherence) const {
    uint32_t answer = 0;
    for (uint32_t left = mask; left; left &= left - 1) {
        const int i = std::countr_zero(left);
        answer |= uint32_t(any(p.ray(size_t(i)))) << i;
    }
    return uint16_t(answer);
}

BspSteps BspCaster::count_steps(std::span<const Ray> rays) const {
    BspSteps steps;
    for (const Ray& ray : rays) {
        const Ray local = to_local(ray);
        if (kernel_ == TriangleKernel::kWald)
            nearest_in(WaldKernel{wald_, local}, local, steps);
        else
            nearest_in(WatertightKernel{corners_, ShearedRay(local)}, local, steps);
    }
    return steps;
}

}  // namespace viscache
