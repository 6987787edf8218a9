#pragma once
// A map of voxel-to-voxel visibilities that frames pass on to later frames.
//
// A frame adds what its own small frame has learnt and then reads the map. If the frame is not finished, this
// is taken back. So the map depends on the finished frames alone.
#include <deque>
#include <mutex>
#include <optional>

#include "viscache/oracles/voxel_visibility.h"

namespace viscache {

/// What oracles of several threads added to a map.
class VoxelJournal {
public:
    using Entries = std::vector<uint64_t>;  ///< twice the place, plus 1 if seen
    /// The entries of one thread. They stay where they are.
    Entries& of_thread() {
        const std::lock_guard lock(mutex_);
        return threads_.emplace_back();
    }
    void take_back(VoxelVisibility& map) {
        for (const Entries& entries : threads_)
            for (const uint64_t e : entries) map.remove_at(e >> 1, e & 1);
        threads_.clear();
    }
    void clear() { threads_.clear(); }

private:
    std::mutex mutex_;
    std::deque<Entries> threads_;
};

/// One frame at a time may use it: begin, then commit or roll_back.
class KeptVoxels {
public:
    uint64_t frames() const { return frames_; }
    uint64_t bytes() const { return map_ ? map_->bytes() : 0; }
    uint64_t pairs_tested() const { return map_ ? map_->pairs_tested() : 0; }
    const VoxelVisibility* map() const { return map_ ? &*map_ : nullptr; }
    VoxelJournal& journal() { return journal_; }

    /// The map for the next frame; made at the first one. It must have the same settings in all frames.
    VoxelVisibility& begin(const Bounds& bounds, const NeePlusPlusSettings& settings) {
        if (!map_) map_.emplace(bounds, settings);
        return *map_;
    }
    void commit() {
        journal_.clear();
        ++frames_;
    }
    void roll_back() {
        if (frames_ == 0)
            map_.reset();
        else
            journal_.take_back(*map_);
        journal_.clear();
    }
    /// Starts with the counts of a file.
    void begin_restore(const Bounds& bounds, const NeePlusPlusSettings& settings, uint64_t frames) {
        map_.emplace(bounds, settings);
        frames_ = frames;
    }
    void restore(size_t place, VoxelVisibility::Counts counts) { map_->restore(place, counts); }

private:
    std::optional<VoxelVisibility> map_;
    VoxelJournal journal_;
    uint64_t frames_ = 0;
};

}  // namespace viscache
