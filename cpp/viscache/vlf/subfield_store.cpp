#include "viscache/vlf/subfield_store.h"

namespace viscache {

void SubfieldStore::build_all(std::span<const FlatTriangle> triangles, int threads, Control& control) {
    all_.resize(directions_.size());
    control.total = directions_.size();
    control.done = 0;
    // One builder per thread keeps its buffers over many directions.
    std::vector<SubfieldBuilder> builders(size_t(resolve_threads(threads)), SubfieldBuilder(shape_));
    parallel_for(directions_.size(), threads, [&](size_t i, int worker) {
        control.check();
        SubfieldBuilder& builder = builders[size_t(worker)];
        all_[i] = std::make_shared<Subfield>(builder.build(triangles, {}, directions_.frames()[i]));
        ++control.done;
    });
    built_ = directions_.size();
}

SubfieldLease SubfieldStore::get_lazily(uint32_t direction) const {
    Slot& slot = slots_[direction];
    // A count of uses, not a clock: the order of uses is all that eviction needs.
    slot.used = ++clock_;
    std::shared_ptr<const Subfield> field = slot.load();
    // Looks, locks, looks again: one thread builds a direction, and others that need it wait only for this
    // one.
    if (!field) {
        const std::lock_guard lock(slot.building);
        field = slot.load();
        if (!field) {
            SubfieldBuilder builder(shape_);
            field = std::make_shared<const Subfield>(
                builder.build(triangles_, {}, directions_.frames()[direction]));
            place(direction, field);
        }
    }
    return {field.get(), field};
}

/// Stores a new subfield and evicts those that were not used for longest. Rays in flight keep their
/// subfields alive.
void SubfieldStore::place(uint32_t direction, std::shared_ptr<const Subfield> field) const {
    const std::lock_guard lock(room_);
    bytes_ += field->bytes();
    ++built_;
    slots_[direction].exchange(std::move(field));
    while (bytes_ > max_bytes_) {
        // The new subfield is never evicted: the ray that needs it is about to use it.
        uint32_t oldest = direction;
        for (uint32_t i = 0; i < directions_.size(); ++i) {
            const bool older = oldest == direction || slots_[i].used < slots_[oldest].used;
            if (i != direction && older && slots_[i].load()) oldest = i;
        }
        // No other subfield is left. A single one may exceed the budget.
        if (oldest == direction) return;
        bytes_ -= slots_[oldest].exchange(nullptr)->bytes();
        ++evicted_;
    }
}

std::vector<std::shared_ptr<const Subfield>> SubfieldStore::present() const {
    if (!lazy()) return {all_.begin(), all_.end()};
    // Taken one by one: a subfield evicted meanwhile stays alive here.
    std::vector<std::shared_ptr<const Subfield>> found;
    for (uint32_t i = 0; i < directions_.size(); ++i)
        if (auto field = slots_[i].load()) found.push_back(std::move(field));
    return found;
}

}  // namespace viscache
