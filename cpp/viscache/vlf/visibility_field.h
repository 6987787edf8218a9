#pragma once
// The visibility field: lists of triangles along beams in fixed directions; rays are traced by lookup.
#include <memory>
#include <span>

#include "viscache/math/parallel.h"
#include "viscache/scene/scene.h"
#include "viscache/visibility/ray_caster.h"
#include "viscache/vlf/directions.h"
#include "viscache/vlf/field_settings.h"
#include "viscache/vlf/field_triangles.h"
#include "viscache/vlf/field_walk.h"
#include "viscache/vlf/subfield_store.h"

namespace viscache {

struct FieldStats {
    uint64_t triangles = 0, degenerate = 0;
    uint64_t built = 0, evicted = 0;  ///< total numbers of subfields built and evicted
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
