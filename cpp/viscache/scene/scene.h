#pragma once
// The immutable scene: a validated description and the values that every ray needs, computed once.
#include <memory>

#include "viscache/math/bounds.h"
#include "viscache/scene/description.h"
#include "viscache/scene/envmap.h"
#include "viscache/scene/lights.h"
#include "viscache/scene/surface.h"

namespace viscache {

class Scene {
public:
    /// Checks the description and freezes it; 0 threads = all. Throws SceneError that says what is wrong and
    /// where.
    static std::shared_ptr<const Scene> freeze(SceneDescription description, int threads = 0);

    const SceneDescription& description() const { return d_; }
    const std::vector<Mesh>& meshes() const { return d_.meshes; }
    const std::vector<Material>& materials() const { return d_.materials; }
    /// Number of meshes in the description. The meshes after them are tessellated sphere lights.
    size_t described_meshes() const { return described_meshes_; }
    /// Number of materials in the description. One more material follows, for the sphere lights.
    size_t described_materials() const { return described_materials_; }
    /// Bounds of all placed meshes, without sphere lights.
    const Bounds& bounds() const { return bounds_; }
    /// Centre and radius of the bounding sphere: c and B_R of the quantized cache.
    Vec3 center() const { return bounds_.empty() ? Vec3{} : bounds_.center(); }
    float radius() const { return std::max(0.5f * bounds_.diagonal(), 1e-30f); }
    /// Together with |p|, the scale of self-intersection offsets (visibility/query.h).
    float offset_extent() const { return bounds_.diagonal(); }
    /// Number of placed triangles, with instances expanded and without sphere lights.
    uint64_t placed_triangles() const { return placed_triangles_; }
    uint64_t unique_triangles() const { return unique_triangles_; }
    uint64_t memory_bytes() const { return memory_bytes_; }
    const AreaLights& area_lights() const { return area_lights_; }
    /// nullptr if the scene has none.
    const EnvironmentMap* environment() const { return environment_.get(); }
    /// Index of the sphere light that a mesh tessellates, or -1.
    int sphere_light_of(uint32_t mesh) const {
        return mesh < described_meshes_ ? -1 : int(mesh - described_meshes_);
    }
    /// Index of the mesh's first triangle in the numbering over all meshes (`intersect`'s triangle ids).
    uint64_t first_triangle(uint32_t mesh) const { return first_triangle_[mesh]; }

    /// Surface at the barycentric coordinates (u, v) of a triangle; instance < 0 for meshes of the world.
    SurfacePoint surface(uint32_t mesh, uint32_t triangle, int instance, float u, float v) const;
    /// False where the material's alpha cuts a hole.
    bool solid_at(uint32_t mesh, uint32_t triangle, float u, float v) const;
    bool has_cutout(uint32_t mesh) const;

private:
    Scene() = default;
    void build_lights(int threads);
    void warn_of_size();
    void add_sphere_light_meshes();
    void measure();

    SceneDescription d_;
    size_t described_meshes_ = 0, described_materials_ = 0;
    Bounds bounds_;
    uint64_t placed_triangles_ = 0, unique_triangles_ = 0, memory_bytes_ = 0;
    std::vector<uint64_t> first_triangle_;
    AreaLights area_lights_;
    std::unique_ptr<EnvironmentMap> environment_;
};

}  // namespace viscache
