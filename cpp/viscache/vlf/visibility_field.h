#pragma once
// The visibility field: lists of triangles along beams in fixed directions; rays are traced by lookup.
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

/// What the tiles of a direction cover: the square around the ball of the scene, or the bounding box of the
/// scene in that direction.
enum class FieldFit { kSphere, kBox };

struct FieldSettings {
    uint32_t n_directions = 513;  ///< l: 1 or 2·4^k + 1; 0: chosen to fit the budget
    int n_tiles = 128;            ///< n; in [1, 4096]; 0: chosen
    int bsp_depth = -1;           ///< maximum number of halvings of a tile's depth; in [0, 12]; −1: chosen
    int leaf_target = 4;          ///< triangles per leaf to aim for; 0: every tile gets the full depth
    DepthSplit split = DepthSplit::kUniform;
    LeafWalk walk = LeafWalk::kLinear;
    bool tile_ranges = true;  ///< depth range per tile; false: [−1, 1] for all
    FieldFit fit = FieldFit::kSphere;
    TriangleKernel kernel = TriangleKernel::kWatertight;
    double head_room = 1;  ///< radius of the ball over that of the scene's sphere; in [1, 1000]
    bool lazy = false;     ///< subfields are built by the first ray of their direction
    bool snap = false;     ///< rays run along their nearest axis: approximate
    uint64_t max_bytes = uint64_t{2} << 30;  ///< of subfields and triangles
    double max_build_s = 0;  ///< limit on the estimated CPU seconds to build chosen settings; 0: none

    /// Throws std::invalid_argument with a message that says what must hold.
    void validate() const;
    /// The shape of the subfields. The settings must leave nothing open.
    SubfieldShape shape() const;
};
constexpr int kMostTiles = 4096;
/// Throws std::invalid_argument unless n_tiles is in [1, 4096].
void check_tiles(int n_tiles);

struct FieldStats {
    uint64_t triangles = 0, degenerate = 0;
    uint64_t built = 0, given_up = 0;  ///< total numbers of subfields built and evicted
    /// Of the existing subfields:
    uint64_t subfields = 0, tiles = 0, empty_tiles = 0, leaves = 0, references = 0;
    uint64_t bytes = 0;  ///< of subfields and triangles
};

/// Traces rays by lookup. The hits are those of its triangle kernel, regardless of the direction, tiles and
/// leaves that lead to them. They may differ from those of Embree within rounding error of an edge.
class VisibilityField final : public RayCaster {
public:
    /// Builds all subfields in parallel over directions, or leaves that to the rays if lazy. The result is
    /// the same for any number of threads. Throws std::invalid_argument, or OverBudget if the field would
    /// exceed `settings.max_bytes`. A lazy field stays within that limit by evicting subfields.
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
    /// Nearest hit through the subfield of a given direction. The hit is the same; the number of tiles
    /// varies.
    Hit nearest(const Ray& ray, uint32_t direction, FieldSteps* steps = nullptr) const;
    bool any(const Ray& ray, uint32_t direction, FieldSteps* steps = nullptr) const;

private:
    /// The subfield of a direction, with its rotation.
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
    FieldSettings settings_;  ///< nothing left open
    const Directions& directions_;
    SubfieldStore store_;
};

}  // namespace viscache
