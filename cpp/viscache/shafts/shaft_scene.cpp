#include "viscache/shafts/shaft_scene.h"

#include <cmath>
#include <stdexcept>

namespace viscache {

namespace {

/// Embree never hits a triangle with two equal corners: its normal is zero.
bool has_distinct_corners(Vec3 a, Vec3 b, Vec3 c) { return !(a == b) && !(b == c) && !(c == a); }

std::vector<ShaftTriangle> scaled_triangles(const Scene& scene, float scale) {
    std::vector<ShaftTriangle> triangles;
    triangles.reserve(scene.unique_triangles());
    for (uint32_t m = 0; m < scene.meshes().size(); ++m) {
        const Mesh& mesh = scene.meshes()[m];
        if (!mesh.in_world) continue;
        const bool solid = !scene.has_cutout(m);
        for (const Vec3u t : mesh.triangles) {
            const Vec3 a = mesh.vertices[t.x], b = mesh.vertices[t.y], c = mesh.vertices[t.z];
            if (has_distinct_corners(a, b, c))
                triangles.push_back({{a * scale, b * scale, c * scale}, solid});
        }
    }
    return triangles;
}

Bounds bounds_of_world(const Scene& scene) {
    Bounds bounds;
    for (const Mesh& mesh : scene.meshes())
        if (mesh.in_world)
            for (const Vec3 v : mesh.vertices) bounds.add(v);
    return bounds;
}

}  // namespace

ShaftScene::ShaftScene(std::shared_ptr<const Scene> scene, uint64_t max_bytes) : scene_(std::move(scene)) {
    for (const Mesh& mesh : scene_->meshes()) triangles_ += mesh.in_world ? mesh.triangles.size() : 0;
    const Bounds bounds = bounds_of_world(*scene_);
    const float extent = max_component(bounds.hi - bounds.lo);
    if (!scene_->description().instances.empty()) {
        // Embree turns the ray into the instance's space, so its bits are not those of placed triangles
        refusal_ = "the scene has instances";
    } else if (triangles_ == 0 || !(extent > 0)) {
        refusal_ = "the scene has no triangles";
    } else if (triangles_ > uint64_t{1} << 30) {
        refusal_ = "the scene has more than 2^30 triangles";
    } else if (max_bytes && most_shaft_bytes(triangles_) > max_bytes) {
        refusal_ = "the tree might exceed max_bytes";
    } else {
        scale_ = std::ldexp(1.f, -std::ilogb(extent));
        // Farther from the origin than this, floats are too far apart for triangles
        constexpr float kFarthest = 64;
        if (!(bounds.magnitude() * scale_ <= kFarthest)) refusal_ = "the scene lies far from the origin";
    }
}

const ShaftTree& ShaftScene::tree(int threads, const Control& control) const {
    if (!refusal_.empty()) throw std::logic_error("shafts cannot be used: " + refusal_);
    std::call_once(once_, [&] {
        const std::vector<ShaftTriangle> triangles = scaled_triangles(*scene_, scale_);
        tree_ = build_shaft_tree(triangles, threads, control);
        has_tree_.store(true, std::memory_order_release);
    });
    return tree_;
}

}  // namespace viscache
