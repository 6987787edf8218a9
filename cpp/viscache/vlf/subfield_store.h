#pragma once
// The subfields of a field. Either all are built at once, or each is built on first use and the least
// recently used ones are evicted.
#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "viscache/math/parallel.h"
#include "viscache/vlf/directions.h"
#include "viscache/vlf/subfield.h"

namespace viscache {

/// Keeps a subfield alive.
struct SubfieldLease {
    const Subfield* field = nullptr;
    std::shared_ptr<const Subfield> keep;  ///< set if the subfield may be evicted
    const Subfield* operator->() const { return field; }
};

class SubfieldStore {
public:
    SubfieldStore(const Directions& directions, const SubfieldShape& shape)
        : directions_(directions), shape_(shape) {}

    /// Builds all subfields in parallel over directions. The result is the same for any number of threads.
    void build_all(std::span<const FlatTriangle> triangles, int threads, Control& control);
    /// From now on, subfields are built on first use and evicted when their total size exceeds the budget.
    void be_lazy(std::span<const FlatTriangle> triangles, uint64_t max_bytes) {
        slots_ = std::make_unique<Slot[]>(directions_.size());
        triangles_ = triangles;
        max_bytes_ = max_bytes;
    }
    bool lazy() const { return slots_ != nullptr; }
    /// Thread-safe.
    SubfieldLease get(uint32_t direction) const {
        if (!lazy()) return {all_[direction].get(), nullptr};
        return get_lazily(direction);
    }
    /// Moves out one of the subfields that were built at once.
    Subfield take(uint32_t direction) { return std::move(*all_[direction]); }
    /// The subfields that currently exist.
    std::vector<std::shared_ptr<const Subfield>> present() const;
    uint64_t built() const { return built_; }
    uint64_t evicted() const { return evicted_; }

private:
    struct Slot {
        // `building` is held for as long as a build takes, `access` only for a copy of the pointer.
        std::mutex building, access;
        std::shared_ptr<const Subfield> field;  ///< guarded by access
        std::atomic<uint64_t> used{0};          ///< time of the last use

        std::shared_ptr<const Subfield> load() {
            const std::lock_guard lock(access);
            return field;
        }
        /// Replaces the subfield; returns the previous one.
        std::shared_ptr<const Subfield> exchange(std::shared_ptr<const Subfield> other) {
            const std::lock_guard lock(access);
            return std::exchange(field, std::move(other));
        }
    };
    SubfieldLease get_lazily(uint32_t direction) const;
    void place(uint32_t direction, std::shared_ptr<const Subfield> field) const;

    const Directions& directions_;
    SubfieldShape shape_;
    std::vector<std::shared_ptr<Subfield>> all_;
    // For lazy fields
    std::unique_ptr<Slot[]> slots_;
    std::span<const FlatTriangle> triangles_;
    uint64_t max_bytes_ = 0;
    mutable std::mutex room_;
    mutable uint64_t bytes_ = 0;  ///< bytes of the existing subfields; guarded by room_
    mutable std::atomic<uint64_t> clock_{0}, built_{0}, evicted_{0};
};

}  // namespace viscache
