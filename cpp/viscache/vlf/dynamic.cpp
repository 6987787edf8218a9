#include "viscache/vlf/dynamic.h"

#include <stdexcept>
#include <string>

#include "viscache/vlf/auto_settings.h"
#include "viscache/vlf/field_trace.h"

namespace viscache {

DynamicField::DynamicField(std::shared_ptr<const Scene> scene, const FieldSettings& settings, UpdateMode mode,
                           int threads, Control& control)
    : mode_(mode),
      triangles_((settings.validate(), std::move(scene)), settings.kernel, settings.head_room),
      settings_(chosen_settings(triangles_, settings, threads, control)),
      directions_(directions_of(settings_.n_directions)),
      shape_(settings_.shape()),
      scene_triangles_(triangles_.size()) {
    // The box follows from the triangles that a subfield is built of, and these change.
    if (settings_.fit == FieldFit::kBox)
        throw std::invalid_argument("fit must be \"sphere\" where objects move, got \"psf_box\"");
    const int builders = check_budget(triangles_, settings_, threads, control);
    // Subfields are built as those of a field that does not change. Then each mode takes them over.
    SubfieldStore store(directions_, shape_);
    store.build_all(triangles_.in_ball(), builders, control);
    for (uint32_t i = 0; i < directions_.size(); ++i) {
        Subfield built = store.take(i);
        if (mode_ == UpdateMode::kInPlace)
            editable_.emplace_back(built);
        else
            static_.push_back(std::move(built));
    }
    overlays_.resize(static_.size());
    for (const Subfield& f : static_) layers_.push_back({&f});
}

DynamicField::Object& DynamicField::object(uint32_t number) {
    const auto found = objects_.find(number);
    if (found == objects_.end())
        throw std::invalid_argument("object must be one that was inserted and not deleted, got " +
                                    std::to_string(number));
    return found->second;
}

void DynamicField::require_inside(std::span<const FlatTriangle> triangles) const {
    for (const FlatTriangle& t : triangles)
        if (!triangles_.holds(t))
            throw std::invalid_argument(
                "objects must stay inside the field's ball; give it more head_room, got " +
                std::to_string(settings_.head_room));
}

/// Reserves `count` consecutive ids; returns the first.
/// The triangles of an object have consecutive ids, so that an overlay's list is ascending. Ranges of deleted
/// objects are used again, the first that is large enough.
uint32_t DynamicField::take_ids(uint32_t count) {
    for (Range& free : free_ids_)
        if (free.count >= count) {
            const uint32_t first = free.first;
            free.first += count;
            free.count -= count;
            return first;
        }
    const uint32_t first = uint32_t(triangles_.size());
    triangles_.grow(count);
    owner_.resize(triangles_.size() - scene_triangles_);
    return first;
}

/// Calls visit(tile, entry) for the tiles that the triangles of an object touch at their current place.
/// Rasterizes the stored floats with the same grid and frame as before, so removal finds exactly the tiles
/// and depths of the insertion.
template <class Visit>
void DynamicField::for_touches(size_t direction, const Object& object, Visit visit) const {
    for (uint32_t id = object.first; id < object.first + object.count; ++id)
        cover_tiles(projected(triangles_.in_ball()[id], directions_.frames()[direction]), shape_.grid,
                    [&](int x, int y, float low, float high) {
                        visit(size_t(y) * size_t(shape_.grid.n) + size_t(x), TileEntry{id, low, high});
                    });
}

void DynamicField::remove_lists(size_t direction, uint32_t number, const Object& object) {
    if (mode_ == UpdateMode::kInPlace) {
        for_touches(direction, object,
                    [&](size_t tile, const TileEntry& entry) { editable_[direction].remove(tile, entry); });
    } else {
        // Layers hold pointers into the overlays: the pointer goes first.
        const auto overlay = overlays_[direction].find(number);
        std::erase(layers_[direction], &overlay->second);
        overlays_[direction].erase(overlay);
    }
}

void DynamicField::insert_lists(size_t direction, uint32_t number, const Object& object,
                                SubfieldBuilder& builder) {
    if (mode_ == UpdateMode::kInPlace) {
        for_touches(direction, object,
                    [&](size_t tile, const TileEntry& entry) { editable_[direction].insert(tile, entry); });
    } else {
        std::vector<uint32_t> ids(object.count);
        for (uint32_t i = 0; i < object.count; ++i) ids[i] = object.first + i;
        // Tight: an overlay covers only the rectangle of tiles that its object touches.
        Subfield overlay = builder.build(triangles_.in_ball().subspan(object.first, object.count), ids,
                                         directions_.frames()[direction], true);
        // Elements of a map never move, so the pointer stays valid when other objects come and go.
        layers_[direction].push_back(
            &overlays_[direction].insert_or_assign(number, std::move(overlay)).first->second);
    }
}

/// Order matters: the lists lose the triangles at the old place, which they must still find there; then the
/// triangles change; then the lists gain them at the new one. Directions are independent of each other.
template <class Change>
void DynamicField::update(uint32_t number, const Object& object, bool out, bool in, int threads,
                          Change change) {
    const size_t n = directions_.size();
    if (out) parallel_for(n, threads, [&](size_t i, int) { remove_lists(i, number, object); });
    change();
    if (!in) return;
    std::vector<SubfieldBuilder> builders(size_t(resolve_threads(threads)), SubfieldBuilder(shape_));
    parallel_for(n, threads,
                 [&](size_t i, int worker) { insert_lists(i, number, object, builders[size_t(worker)]); });
}

uint32_t DynamicField::insert(std::vector<FlatTriangle> triangles, int threads) {
    require_inside(triangles);
    const uint32_t number = next_object_++, count = uint32_t(triangles.size());
    const uint32_t first = take_ids(count);
    const Object& made = objects_[number] = {first, count, std::move(triangles)};
    update(number, made, false, true, threads, [&] {
        for (uint32_t i = 0; i < count; ++i) {
            triangles_.set(first + i, made.inserted[i]);
            owner_[first + i - scene_triangles_] = number;
        }
    });
    return number;
}

void DynamicField::remove(uint32_t number, int threads) {
    const Object& gone = object(number);
    update(number, gone, true, false, threads, [&] { free_ids_.push_back({gone.first, gone.count}); });
    objects_.erase(number);
}

void DynamicField::transform(uint32_t number, const Affine& place, int threads) {
    const Object& moved = object(number);
    std::vector<FlatTriangle> there;
    // From the triangles as inserted, not as last placed: errors of repeated moves do not add up.
    for (const FlatTriangle& t : moved.inserted)
        there.push_back({place.point(t.a), place.point(t.b), place.point(t.c)});
    // Checked before anything changes: a refused move leaves the object where it was.
    require_inside(there);
    update(number, moved, true, true, threads, [&] {
        for (uint32_t i = 0; i < moved.count; ++i) triangles_.set(moved.first + i, there[i]);
    });
}

DynamicHit DynamicField::nearest(const Ray& ray) const {
    if (ray.d == Vec3{}) return {};
    const uint32_t direction = directions_.nearest(ray.d);
    const Frame3& frame = directions_.frames()[direction];
    // One layer where lists change in place; the scene's and one per object otherwise. The same walk serves
    // both.
    NearestHit best{ray.t_max};
    if (mode_ == UpdateMode::kInPlace) {
        const EditableSubfield* const layers[] = {&editable_[direction]};
        best = nearest_hit<EditableSubfield>(triangles_, layers, frame, TileFit{}, settings_, ray, nullptr);
    } else {
        best =
            nearest_hit<Subfield>(triangles_, layers_[direction], frame, TileFit{}, settings_, ray, nullptr);
    }
    if (best.id == kNoHit) return {};
    // Ids past those of the scene belong to objects.
    if (best.id >= scene_triangles_) {
        const uint32_t number = owner_[best.id - scene_triangles_];
        return {best.t, number, best.id - objects_.at(number).first, best.u, best.v};
    }
    const Hit hit = triangles_.hit(best);
    return {best.t, DynamicHit::kScene, scene().first_triangle(hit.mesh) + hit.triangle, best.u, best.v};
}

bool DynamicField::any(const Ray& ray) const {
    if (ray.d == Vec3{}) return false;
    const uint32_t direction = directions_.nearest(ray.d);
    const Frame3& frame = directions_.frames()[direction];
    if (mode_ == UpdateMode::kInPlace) {
        const EditableSubfield* const layers[] = {&editable_[direction]};
        return any_hit<EditableSubfield>(triangles_, layers, frame, TileFit{}, settings_, ray, nullptr);
    }
    return any_hit<Subfield>(triangles_, layers_[direction], frame, TileFit{}, settings_, ray, nullptr);
}

uint64_t DynamicField::bytes() const {
    uint64_t sum = triangles_.bytes();
    for (const EditableSubfield& f : editable_) sum += f.bytes();
    for (const Subfield& f : static_) sum += f.bytes();
    for (const auto& of_direction : overlays_)
        for (const auto& [number, f] : of_direction) sum += f.bytes();
    return sum;
}

namespace {

/// Adds (tile, triangle) of all leaves; tiles are numbered in the whole grid.
template <class Layer>
void add_listed(const Layer& layer, int n, std::vector<std::pair<uint32_t, uint32_t>>& pairs) {
    for (int y = layer.rect.y; y < layer.rect.y + layer.rect.height; ++y)
        for (int x = layer.rect.x; x < layer.rect.x + layer.rect.width; ++x) {
            const size_t tile = layer.rect.index(x, y);
            for (int l = 0; l < layer.bsp(tile).leaves; ++l)
                for (const uint32_t id : layer.leaf(tile, l)) pairs.emplace_back(uint32_t(y * n + x), id);
        }
}

std::vector<std::pair<uint32_t, uint32_t>> unique(std::vector<std::pair<uint32_t, uint32_t>> pairs) {
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    return pairs;
}

}  // namespace

std::vector<std::pair<uint32_t, uint32_t>> DynamicField::listed(uint32_t direction) const {
    std::vector<std::pair<uint32_t, uint32_t>> pairs;
    if (mode_ == UpdateMode::kInPlace) {
        add_listed(editable_[direction], shape_.grid.n, pairs);
    } else {
        for (const Subfield* layer : layers_[direction]) add_listed(*layer, shape_.grid.n, pairs);
    }
    return unique(std::move(pairs));
}

std::vector<std::pair<uint32_t, uint32_t>> DynamicField::listed_anew(uint32_t direction) const {
    // What `listed` must give after any sequence of changes. The ids are those in use, so lists can be
    // compared.
    std::vector<FlatTriangle> triangles(triangles_.in_ball().begin(),
                                        triangles_.in_ball().begin() + ptrdiff_t(scene_triangles_));
    std::vector<uint32_t> ids(scene_triangles_);
    for (uint32_t i = 0; i < ids.size(); ++i) ids[i] = i;
    for (const auto& [number, object] : objects_)
        for (uint32_t id = object.first; id < object.first + object.count; ++id) {
            triangles.push_back(triangles_.in_ball()[id]);
            ids.push_back(id);
        }
    std::vector<std::pair<uint32_t, uint32_t>> pairs;
    SubfieldBuilder builder(shape_);
    add_listed(builder.build(triangles, ids, directions_.frames()[direction]), shape_.grid.n, pairs);
    return unique(std::move(pairs));
}

}  // namespace viscache
