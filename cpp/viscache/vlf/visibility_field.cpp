#include "viscache/vlf/visibility_field.h"

#include <bit>
#include <string>

#include "viscache/casters/bsp_tree.h"
#include "viscache/vlf/auto_settings.h"
#include "viscache/vlf/field_trace.h"

namespace viscache {

VisibilityField::VisibilityField(std::shared_ptr<const Scene> scene, const FieldSettings& settings,
                                 int threads, Control& control)
    : triangles_((settings.validate(), std::move(scene)), settings.kernel, settings.head_room),
      settings_(chosen_settings(triangles_, settings, threads, control)),
      directions_(directions_of(settings_.n_directions)),
      store_(directions_, settings_.shape()) {
    if (settings_.lazy) {
        const uint64_t fixed = triangles_.bytes();
        if (fixed > settings_.max_bytes)
            throw OverBudget("the visibility field's triangles alone take " + std::to_string(fixed) +
                             " bytes, max_bytes is " + std::to_string(settings_.max_bytes));
        // What the triangles leave of the budget is for subfields.
        store_.be_lazy(triangles_.in_ball(), settings_.max_bytes - fixed);
    } else {
        const int builders = check_budget(triangles_, settings_, threads, control);
        store_.build_all(triangles_.in_ball(), builders, control);
    }
}

FieldStats VisibilityField::stats() const {
    FieldStats s{.triangles = triangles_.size(), .degenerate = triangles_.degenerate()};
    s.built = store_.built();
    s.evicted = store_.evicted();
    s.bytes = triangles_.bytes();
    for (const auto& field : store_.present()) {
        const Subfield& f = *field;
        ++s.subfields;
        s.tiles += f.tiles();
        // Counted from the lists themselves, for tests and reports; nothing is counted while rays run.
        for (size_t i = 0; i < f.tiles(); ++i) {
            const int leaves = f.bsp(i).leaves;
            s.leaves += uint64_t(leaves);
            s.empty_tiles += leaves == 0;
            for (int l = 0; l < leaves; ++l) s.references += f.leaf(i, l).size();
        }
        s.bytes += f.bytes();
    }
    return s;
}

Hit VisibilityField::nearest_in(const View& view, const Ray& ray, FieldSteps* steps) const {
    const Subfield* const layers[] = {&view.field};
    return triangles_.hit(
        nearest_hit<Subfield>(triangles_, layers, view.frame, view.field.fit, settings_, ray, steps));
}

bool VisibilityField::any_in(const View& view, const Ray& ray, FieldSteps* steps) const {
    const Subfield* const layers[] = {&view.field};
    return any_hit<Subfield>(triangles_, layers, view.frame, view.field.fit, settings_, ray, steps);
}

Hit VisibilityField::nearest(const Ray& ray, uint32_t direction, FieldSteps* steps) const {
    const SubfieldLease lease = store_.get(direction);
    return nearest_in({*lease.field, directions_.frames()[direction]}, ray, steps);
}

bool VisibilityField::any(const Ray& ray, uint32_t direction, FieldSteps* steps) const {
    const SubfieldLease lease = store_.get(direction);
    return any_in({*lease.field, directions_.frames()[direction]}, ray, steps);
}

/// The ray itself, or with `snap` the ray along its axis.
Ray VisibilityField::aimed(const Ray& ray, uint32_t direction) const {
    if (!settings_.snap) return ray;
    const Vec3 axis = directions_.axes()[direction];
    // Same length and side as before, so t stays comparable.
    return {ray.o, ray.t_min, axis * std::copysign(length(ray.d), dot(ray.d, axis)), ray.t_max};
}

/// Calls trace(i, view, ray) for all rays with a nonzero direction. For a lazy field the rays are sorted by
/// direction, to keep as few subfields alive as possible.
template <class Trace>
void VisibilityField::for_rays(std::span<const Ray> rays, Trace trace) const {
    const auto frames = directions_.frames();
    if (!settings_.lazy) {
        for (size_t i = 0; i < rays.size(); ++i) {
            if (rays[i].d == Vec3{}) continue;
            const uint32_t direction = directions_.nearest(rays[i].d);
            // Subfields of such a field are never evicted: no lease is needed.
            trace(i, View{*store_.get(direction).field, frames[direction]}, aimed(rays[i], direction));
        }
        return;
    }
    std::vector<std::pair<uint32_t, size_t>> order;
    for (size_t i = 0; i < rays.size(); ++i)
        if (!(rays[i].d == Vec3{})) order.emplace_back(directions_.nearest(rays[i].d), i);
    // By direction, then by index
    std::sort(order.begin(), order.end());
    SubfieldLease lease;
    for (size_t k = 0; k < order.size(); ++k) {
        const auto [direction, i] = order[k];
        if (k == 0 || order[k - 1].first != direction) lease = store_.get(direction);
        trace(i, View{*lease.field, frames[direction]}, aimed(rays[i], direction));
    }
}

void VisibilityField::intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const {
    std::fill(hits.begin(), hits.end(), Hit{});
    for_rays(rays,
             [&](size_t i, const View& view, const Ray& ray) { hits[i] = nearest_in(view, ray, nullptr); });
}

void VisibilityField::occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const {
    std::fill(occluded.begin(), occluded.end(), uint8_t(0));
    for_rays(rays,
             [&](size_t i, const View& view, const Ray& ray) { occluded[i] = any_in(view, ray, nullptr); });
}

uint16_t VisibilityField::occluded16(uint16_t mask, RayPacket16& p, Coherence) const {
    // Rays of a packet mostly have different subfields or tiles, so they are traced one by one.
    Ray rays[16];
    for (uint32_t left = mask; left; left &= left - 1) {
        const int i = std::countr_zero(left);
        rays[i] = p.ray(size_t(i));
    }
    uint32_t answer = 0;
    // Lanes outside the mask have direction zero
    for_rays(rays, [&](size_t i, const View& view, const Ray& ray) {
        answer |= uint32_t(any_in(view, ray, nullptr)) << i;
    });
    return uint16_t(answer);
}

}  // namespace viscache
