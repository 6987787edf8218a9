#pragma once
// The immutable scene: a validated description and the values that every ray needs, computed once.
#include <memory>
#include <mutex>

#include "viscache/math/bounds.h"
#include "viscache/scene/bsdf.h"
#include "viscache/scene/description.h"
#include "viscache/scene/envmap.h"
#include "viscache/scene/lights.h"
#include "viscache/scene/surface.h"

namespace viscache {

class LightTree;

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
    /// Coat of a material; nullptr if it has none.
    const Coat* coat(int material) const { return coats_.empty() ? nullptr : coats_[size_t(material)]; }
    /// Metal of a material; nullptr if it is not described by its index of refraction.
    const Conductor* metal(int material) const {
        const Conductor& metal = d_.materials[size_t(material)].metal;
        return metal.is_given() ? &metal : nullptr;
    }
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
    /// Root of the mean area of the placed triangles.
    float triangle_size() const { return triangle_size_; }
    uint64_t unique_triangles() const { return unique_triangles_; }
    uint64_t memory_bytes() const { return memory_bytes_; }
    const AreaLights& area_lights() const { return area_lights_; }
    /// Tree over the area lights, of which there must be one at least. Built at the first call.
    const LightTree& light_tree() const;
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
    /// What the material reflects at that point; normals and `wo` are the caller's.
    ShadingPoint reflection(const SurfacePoint& s) const;
    /// Mean radiance that a triangle of a mesh emits.
    Rgb mean_emission(uint32_t mesh, uint32_t triangle) const {
        return emission_means_.empty() || emission_means_[mesh].empty() ? d_.meshes[mesh].emission
                                                                        : emission_means_[mesh][triangle];
    }
    /// False where the material's alpha cuts a hole, and in the holes of a fixed pattern that leave
    /// `opacity` of the surface: cells of 1/4096 of the triangle's edges, chosen by a hash.
    bool solid_at(uint32_t mesh, uint32_t triangle, float u, float v) const;
    bool has_cutout(uint32_t mesh) const;

private:
    Scene() = default;
    void build_lights(int threads);
    void average_emission();
    EmissiveImage emissive_image(const Mesh& mesh, Vec3u triangle) const;
    void build_coats();
    void mix_metal(const Material& material, SurfacePoint& s) const;
    void warn_of_size();
    void add_sphere_light_meshes();
    void measure();

    SceneDescription d_;
    size_t described_meshes_ = 0, described_materials_ = 0;
    Bounds bounds_;
    float triangle_size_ = 0;
    uint64_t placed_triangles_ = 0, unique_triangles_ = 0, memory_bytes_ = 0;
    std::vector<uint64_t> first_triangle_;
    std::vector<const Coat*> coats_;  ///< by material; empty if none has a coat
    AreaLights area_lights_;
    std::vector<std::vector<Rgb>> emission_means_;  ///< of meshes whose emission has an image; else empty
    mutable std::once_flag light_tree_once_;
    mutable std::shared_ptr<const LightTree> light_tree_;
    std::unique_ptr<EnvironmentMap> environment_;
};

}  // namespace viscache
