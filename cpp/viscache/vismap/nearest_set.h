#pragma once
// The nearest records found by a search.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "viscache/math/vec.h"

namespace viscache {

struct TreePoint {
    Vec3 position, normal;
    uint32_t id = 0;
};

/// The nearest points found so far, at most m, in order of distance. Of two points at equal distance, the
/// one with the lower id counts as nearer.
class NearestSet {
public:
    static constexpr int kMost = 64;
    struct Found {
        uint64_t key;  ///< distance² above the id; a float ≥ 0 is ordered like its bits
        const TreePoint* point;
        float distance2() const { return std::bit_cast<float>(uint32_t(key >> 32)); }
        uint32_t id() const { return uint32_t(key); }
    };

    /// Accepts distances below `radius`.
    NearestSet(int m, float radius) : m_(m), radius2_(radius * radius) {}

    /// Points with a larger squared distance cannot become part of the set.
    float reach2() const { return size_ < m_ ? radius2_ : found_[size_t(m_ - 1)].distance2(); }
    void clear() { size_ = 0; }
    /// `point` must outlive the set.
    void offer(float distance2, const TreePoint& point) {
        // Strictly, as in Sec. 5.1: records within d_max. NaN fails, too.
        if (!(distance2 < radius2_)) return;
        // Distance in the high bits, id in the low ones: one comparison orders both.
        const uint64_t key = uint64_t(std::bit_cast<uint32_t>(distance2)) << 32 | point.id;
        if (size_ == m_) {
            if (key >= found_[size_t(m_ - 1)].key) return;
            --size_;
        }
        // Insertion sort: m is small, and most points that pass the first test belong near the end.
        int place = size_++;
        for (; place > 0 && found_[size_t(place - 1)].key > key; --place)
            found_[size_t(place)] = found_[size_t(place - 1)];
        found_[size_t(place)] = {key, &point};
    }
    /// In order of distance.
    std::span<const Found> sorted() const { return {found_.data(), size_t(size_)}; }
    /// The same after removing the entries for which `drop` holds.
    template <class Drop>
    std::span<const Found> sorted_without(Drop drop) {
        const auto end = std::remove_if(found_.begin(), found_.begin() + size_, drop);
        size_ = int(end - found_.begin());
        return sorted();
    }

private:
    int m_, size_ = 0;
    float radius2_;
    std::array<Found, kMost> found_;
};

}  // namespace viscache
