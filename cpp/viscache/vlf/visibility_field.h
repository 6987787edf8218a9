#pragma once
// The visibility field: which triangles lie along beams in fixed directions, and rays by look-up.
#include <memory>
#include <span>
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vlf/directions.h"
#include "viscache/vlf/field_triangles.h"
#include "viscache/vlf/field_walk.h"
#include "viscache/vlf/subfield_store.h"

namespace viscache {

/// What the tiles of a direction cover: the square around the scene's ball, or the scene's own box there.
enum class FieldFit { kSphere, kBox };

struct FieldSettings {
    uint32_t n_directions = 513;  ///< l: 1 or 2·4^k + 1; 0 = chosen to fit the budget
    int n_tiles = 128;            ///< n; in [1, 4096]; 0 = chosen
    int bsp_depth = -1;           ///< most halvings of a tile's depth; in [0, 12]; −1 = chosen
    int leaf_target = 4;          ///< triangles a leaf may keep; 0 = every tile gets the full depth
    DepthSplit split = DepthSplit::kUniform;
    LeafWalk walk = LeafWalk::kLinear;
    bool tile_ranges = true;  ///< depth range per tile; else [−1, 1] for all
    FieldFit fit = FieldFit::kSphere;
    TriangleKernel kernel = TriangleKernel::kWatertight;
    double head_room = 1;                    ///< the field's ball over the scene's sphere; in [1, 1000]
    bool lazy = false;                       ///< subfields are built by the first ray of their direction
    bool snap = false;                       ///< rays run along their nearest axis: approximate
    uint64_t max_bytes = uint64_t{2} << 30;  ///< of subfields and triangles
    double max_build_s = 0;                  ///< CPU seconds that what is chosen may take to build; 0 = any

    /// Throws std::invalid_argument that says what must hold.
    void validate() const;
    /// Of settings without anything left to choose.
    SubfieldShape shape() const;
};
constexpr int kMostTiles = 4096;
/// Throws std::invalid_argument unless n_tiles is in [1, 4096].
void check_tiles(int n_tiles);

struct FieldStats {
    uint64_t triangles = 0, degenerate = 0;
    uint64_t built = 0, given_up = 0;  ///< subfields, ever
    /// Of the subfields present:
    uint64_t subfields = 0, tiles = 0, empty_tiles = 0, leaves = 0, references = 0;
    uint64_t bytes = 0;  ///< subfields and triangles
};

/// Rays by look-up. Its hits are those of its triangle kernel, whatever direction, tiles and leaves lead
/// there; they may differ from Embree's within rounding of an edge.
class VisibilityField final : public RayCaster {
public:
    /// Builds all subfields, in parallel over directions, or leaves that to the rays; the same for any number
    /// of threads. Throws std::invalid_argument, or OverBudget for a field that would be larger than
    /// `settings.max_bytes`. A lazy field keeps below that by giving up subfields.
    VisibilityField(std::shared_ptr<const Scene> scene, const FieldSettings& settings, int threads,
                    Control& control);
    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override;
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override;
    uint16_t occluded16(uint16_t mask, RayPacket16& rays, Coherence coherence) const override;

    const Scene& scene() const { return triangles_.scene(); }
    const FieldSettings& settings() const { return settings_; }
    const Directions& directions() const { return directions_; }
    const FieldTriangles& triangles() const { return triangles_; }
    SubfieldLease subfield(uint32_t direction) const { return store_.get(direction); }
    FieldStats stats() const;
    /// Nearest hit by way of a given direction's subfield: the same hit, by more or fewer tiles.
    Hit nearest(const Ray& ray, uint32_t direction, FieldSteps* steps = nullptr) const;
    bool any(const Ray& ray, uint32_t direction, FieldSteps* steps = nullptr) const;

private:
    /// A direction's subfield and its rotation.
    struct View {
        const Subfield& field;
        const Frame3& frame;
    };
    Hit nearest_in(const View& view, const Ray& ray, FieldSteps* steps) const;
    bool any_in(const View& view, const Ray& ray, FieldSteps* steps) const;
    template <class Trace>
    void for_rays(std::span<const Ray> rays, Trace trace) const;
    Ray aimed(const Ray& ray, uint32_t direction) const;

    FieldTriangles triangles_;
    FieldSettings settings_;  ///< nothing left to choose
    const Directions& directions_;
    SubfieldStore store_;
};

}  // namespace viscache
