#include "viscache/oracles/voxel_visibility.h"

#include <new>
#include <stdexcept>
#include <string>

#include "viscache/math/octahedral.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

namespace {

/// Cells per unit of length; 0 along an axis without extent.
float cells_per_unit(uint32_t n, float low, float high) {
    const float scale = float(n) / (high - low);
    return std::isfinite(scale) && scale > 0 ? scale : 0.f;
}

}  // namespace

VoxelVisibility::VoxelVisibility(const Bounds& bounds, const NeePlusPlusSettings& settings)
    : n_(uint32_t(settings.n_voxels)),
      edge_(uint32_t(settings.n_directions)),
      voxels_(n_ * n_ * n_),
      directions_(edge_ * edge_),
      low_(bounds.lo),
      symmetric_(settings.symmetric),
      min_probability_(settings.min_probability),
      exponent_(settings.exponent) {
    settings.validate();
    scale_ = {cells_per_unit(n_, bounds.lo.x, bounds.hi.x), cells_per_unit(n_, bounds.lo.y, bounds.hi.y),
              cells_per_unit(n_, bounds.lo.z, bounds.hi.z)};
    const uint64_t v = voxels_;
    voxel_pairs_ = symmetric_ ? v * (v + 1) / 2 : v * v;
    size_ = voxel_pairs_ + v * directions_;
    const uint64_t needed = bytes();
    if (needed > settings.max_bytes)
        throw std::invalid_argument("max_bytes must be >= " + std::to_string(needed) + " for " +
                                    std::to_string(n_) + "³ voxels, got " +
                                    std::to_string(settings.max_bytes));
    counts_.reset(static_cast<Counts*>(std::calloc(size_, sizeof(Counts))));
    if (!counts_) throw std::bad_alloc();
}

uint32_t VoxelVisibility::far_cell(Semantic semantic, Vec3 far) const {
    if (!is_direction(semantic)) return voxel(far);
    const Vec2 p = direction_to_octahedral(far);
    auto cell = [&](float u) {
        float t = u * float(edge_);
        t = t > 0 ? t : 0;
        return uint32_t(std::min(t, float(edge_ - 1)));
    };
    return voxels_ + cell(p.y) * edge_ + cell(p.x);
}

void VoxelVisibility::add_at(size_t place, bool seen) {
    Counts& c = counts_[place];
    if (std::atomic_ref(c.tested).fetch_add(1, std::memory_order_relaxed) == 0)
        pairs_tested_.fetch_add(1, std::memory_order_relaxed);
    if (seen) std::atomic_ref(c.seen).fetch_add(1, std::memory_order_relaxed);
}

void VoxelVisibility::remove_at(size_t place, bool seen) {
    Counts& c = counts_[place];
    c.seen -= seen;
    if (--c.tested == 0) pairs_tested_.fetch_sub(1);
}

void VoxelVisibility::restore(size_t place, Counts counts) {
    detail::require(place < size_, "a pair of voxels must have a number in its range", place);
    detail::require(counts.tested > 0 && counts.seen <= counts.tested && counts_[place].tested == 0,
                    "a pair of voxels must have counts once, with seen <= tested", counts.seen);
    counts_[place] = counts;
    pairs_tested_.fetch_add(1);
}

}  // namespace viscache
