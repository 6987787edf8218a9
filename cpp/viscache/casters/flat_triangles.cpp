#include "viscache/casters/flat_triangles.h"

#include <stdexcept>
#include <string>

#include "viscache/visibility/ray_caster.h"

namespace viscache {

namespace {

/// Compares the squared cross product of two edges with zero. In double, edges of float corners are exact or
/// nearly so.
bool has_area(const FlatTriangle& tri) {
    double e1[3], e2[3], sum = 0;
    for (int i = 0; i < 3; ++i) {
        e1[i] = double(tri.b[i]) - tri.a[i];
        e2[i] = double(tri.c[i]) - tri.a[i];
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double n = e1[j] * e2[k] - e1[k] * e2[j];
        sum += n * n;
    }
    return sum > 0 && std::isfinite(sum);
}

void add_mesh(FlatTriangles& flat, const Scene& scene, uint32_t index, uint32_t instance) {
    const Mesh& mesh = scene.meshes()[index];
    const Affine* to_world = instance == kNoHit ? nullptr : &scene.description().instances[instance].to_world;
    const auto corner = [&](uint32_t v) {
        return to_world ? to_world->point(mesh.vertices[v]) : mesh.vertices[v];
    };
    for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
        const Vec3u t = mesh.triangles[i];
        const FlatTriangle tri{corner(t.x), corner(t.y), corner(t.z)};
        if (!has_area(tri)) {
            ++flat.degenerate;
            continue;
        }
        flat.triangles.push_back(tri);
        flat.sources.push_back({index, i, instance});
        flat.bounds.add(tri.bounds());
    }
}

float middle(float lo, float hi) {
    const bool far = lo > 0 ? hi <= 2 * lo : hi < 0 && lo >= 2 * hi;
    return far ? lo * 0.5f + hi * 0.5f : 0.f;
}

}  // namespace

Vec3 exact_origin(const Bounds& b) {
    if (b.empty()) return {};
    return {middle(b.lo.x, b.hi.x), middle(b.lo.y, b.hi.y), middle(b.lo.z, b.hi.z)};
}

FlatTriangles flat_triangles(const Scene& scene) {
    uint64_t count = 0;
    const auto& meshes = scene.meshes();
    const auto& instances = scene.description().instances;
    for (const Mesh& mesh : meshes) count += mesh.in_world ? mesh.triangles.size() : 0;
    for (const Instance& instance : instances)
        for (int mesh : instance.meshes) count += meshes[size_t(mesh)].triangles.size();
    if (count >= kNoHit)
        throw std::length_error("a flat list holds at most 2^32 - 2 placed triangles, the scene has " +
                                std::to_string(count));
    FlatTriangles flat;
    flat.triangles.reserve(count);
    flat.sources.reserve(count);
    for (uint32_t m = 0; m < meshes.size(); ++m)
        if (meshes[m].in_world) add_mesh(flat, scene, m, kNoHit);
    for (uint32_t i = 0; i < instances.size(); ++i)
        for (int mesh : instances[i].meshes) add_mesh(flat, scene, uint32_t(mesh), i);
    return flat;
}

}  // namespace viscache
