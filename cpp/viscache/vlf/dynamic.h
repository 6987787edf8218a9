#pragma once
// Objects that are added, removed and moved in a visibility field.
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "viscache/math/affine.h"
#include "viscache/math/parallel.h"
#include "viscache/vlf/editable_subfield.h"
#include "viscache/vlf/field_walk.h"
#include "viscache/vlf/visibility_field.h"

namespace viscache {

enum class UpdateMode {
    kOverlay,  ///< an object has its own lists over the tiles that it touches; the lists of the scene stay
               ///< unchanged
    kInPlace,  ///< as in the paper: triangles are removed from the lists of the scene and inserted into them
};

/// What a ray hits.
struct DynamicHit {
    static constexpr int64_t kScene = -1, kNothing = -2;
    float t = kInfinity;
    int64_t object = kNothing;
    uint64_t triangle = 0;  ///< index in the object; for the scene, as `Scene::first_triangle` numbers them
    float u = 0, v = 0;
};

/// [VLF Sec. 8] A field over a scene and moving objects. To move an object, every direction deletes it from
/// the tiles given by its rasterization and rasterizes it at its new place. Answers are those of a field
/// built from scratch.
///
/// Several threads may trace rays at the same time, but not while an object changes.
class DynamicField {
public:
    /// As VisibilityField; `settings.head_room` is the space available to objects. Never lazy.
    DynamicField(std::shared_ptr<const Scene> scene, const FieldSettings& settings, UpdateMode mode,
                 int threads, Control& control);

    /// Returns the number of the new object. Throws std::invalid_argument if it leaves the ball of the
    /// field.
    uint32_t insert(std::vector<FlatTriangle> triangles, int threads);
    void remove(uint32_t object, int threads);
    /// Moves the object: applies `place` to the triangles with which it was inserted.
    void transform(uint32_t object, const Affine& place, int threads);

    DynamicHit nearest(const Ray& ray) const;
    bool any(const Ray& ray) const;
    const Scene& scene() const { return triangles_.scene(); }
    const FieldSettings& settings() const { return settings_; }
    size_t objects() const { return objects_.size(); }
    uint64_t bytes() const;

    /// (tile, triangle) of the current lists of one direction, ascending, without duplicates.
    std::vector<std::pair<uint32_t, uint32_t>> listed(uint32_t direction) const;
    /// The same for lists built from scratch over the current triangles.
    std::vector<std::pair<uint32_t, uint32_t>> listed_anew(uint32_t direction) const;

private:
    struct Object {
        uint32_t first, count;  ///< ids of its triangles
        // As inserted; `transform` starts from them.
        std::vector<FlatTriangle> inserted;
    };
    struct Range {
        uint32_t first, count;
    };
    Object& object(uint32_t number);
    void require_inside(std::span<const FlatTriangle> triangles) const;
    uint32_t take_ids(uint32_t count);
    /// Removes the object from all lists, calls `change`, and inserts it again.
    template <class Change>
    void update(uint32_t number, const Object& object, bool out, bool in, int threads, Change change);
    void remove_lists(size_t direction, uint32_t number, const Object& object);
    void insert_lists(size_t direction, uint32_t number, const Object& object, SubfieldBuilder& builder);
    template <class Visit>
    void for_touches(size_t direction, const Object& object, Visit visit) const;

    UpdateMode mode_;
    FieldTriangles triangles_;
    FieldSettings settings_;
    const Directions& directions_;
    SubfieldShape shape_;
    size_t scene_triangles_;
    std::map<uint32_t, Object> objects_;
    uint32_t next_object_ = 0;
    std::vector<Range> free_ids_;
    std::vector<uint32_t> owner_;  ///< object of each id past those of the scene
    // UpdateMode::kInPlace
    std::vector<EditableSubfield> editable_;
    // UpdateMode::kOverlay
    std::vector<Subfield> static_;
    std::vector<std::map<uint32_t, Subfield>> overlays_;  ///< by direction, then by object
    std::vector<std::vector<const Subfield*>>
        layers_;  ///< by direction: the subfield of the scene and the overlays
};

}  // namespace viscache
