#pragma once
// Objects that come, go and move in a visibility field.
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
    kOverlay,  ///< an object has lists of its own over the tiles it touches; the scene's stay as they are
    kInPlace,  ///< the paper's: its triangles are taken out of and put into the scene's lists
};

/// What a ray hits.
struct DynamicHit {
    static constexpr int64_t kScene = -1, kNothing = -2;
    float t = kInfinity;
    int64_t object = kNothing;
    uint64_t triangle = 0;  ///< of the object; of the scene, as `Scene::first_triangle` numbers them
    float u = 0, v = 0;
};

/// [VLF Sec. 8] A field over a scene and over objects: to move one, all directions delete it from the tiles
/// that its rasterization gives, and rasterize it anew where it went. Answers are those of a field built from
/// scratch.
///
/// Rays may be asked from several threads, but not while an object changes.
class DynamicField {
public:
    /// As VisibilityField; `settings.head_room` is the room that objects have. Never lazy.
    DynamicField(std::shared_ptr<const Scene> scene, const FieldSettings& settings, UpdateMode mode,
                 int threads, Control& control);

    /// Number of the new object. Throws std::invalid_argument where it leaves the field's ball.
    uint32_t insert(std::vector<FlatTriangle> triangles, int threads);
    void remove(uint32_t object, int threads);
    /// Puts the object where `place` sends the triangles it was inserted with.
    void transform(uint32_t object, const Affine& place, int threads);

    DynamicHit nearest(const Ray& ray) const;
    bool any(const Ray& ray) const;
    const Scene& scene() const { return triangles_.scene(); }
    const FieldSettings& settings() const { return settings_; }
    size_t objects() const { return objects_.size(); }
    uint64_t bytes() const;

    /// (tile, triangle) of one direction's lists as they are, ascending, without repeats.
    std::vector<std::pair<uint32_t, uint32_t>> listed(uint32_t direction) const;
    /// The same of lists built from scratch over what is there now.
    std::vector<std::pair<uint32_t, uint32_t>> listed_anew(uint32_t direction) const;

private:
    struct Object {
        uint32_t first, count;  ///< ids of its triangles
        std::vector<FlatTriangle> inserted;
    };
    struct Range {
        uint32_t first, count;
    };
    Object& object(uint32_t number);
    void require_inside(std::span<const FlatTriangle> triangles) const;
    uint32_t take_ids(uint32_t count);
    /// Takes the object out of all lists, changes its triangles by `change`, puts it in again.
    template <class Change>
    void update(uint32_t number, const Object& object, bool out, bool in, int threads, Change change);
    void put_out(size_t direction, uint32_t number, const Object& object);
    void put_in(size_t direction, uint32_t number, const Object& object, SubfieldBuilder& builder);
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
    std::vector<uint32_t> owner_;  ///< object of each id beyond the scene's
    // In place
    std::vector<EditableSubfield> editable_;
    // Overlays
    std::vector<Subfield> static_;
    std::vector<std::map<uint32_t, Subfield>> overlays_;  ///< by direction, then object
    std::vector<std::vector<const Subfield*>> layers_;    ///< by direction: the scene's and the overlays
};

}  // namespace viscache
