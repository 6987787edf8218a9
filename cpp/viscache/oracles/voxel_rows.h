#pragma once
// Rows that all eye points of a voxel share, for the oracles that know the visibilities of pairs of voxels.
#include <span>
#include <vector>

#include "viscache/oracles/voxel_visibility.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

/// Numbers the voxels that hold the eye points of a block.
class VoxelRows {
public:
    /// `map` must outlive the rows.
    explicit VoxelRows(const VoxelVisibility& map) : map_(map), row_of_voxel_(map.voxels(), kNone) {}

    /// Calls `add(voxel, cells of the far ends)` for every voxel with eye points, in the order of its first
    /// one: the voxel of the n-th call has row n.
    template <class Add>
    void make(const BlockAsk& ask, Add add) {
        for (const uint32_t voxel : voxels_) row_of_voxel_[voxel] = kNone;
        voxels_.clear();
        const FarEnds& lights = ask.lights;
        far_.resize(lights.count);
        for (size_t k = 0; k < far_.size(); ++k)
            far_[k] = map_.far_cell(lights.semantic, {lights.x[k], lights.y[k], lights.z[k]});
        row_of_eye_.clear();
        for (const Vec3 position : ask.eyes.position) {
            const uint32_t voxel = map_.voxel(position);
            if (row_of_voxel_[voxel] == kNone) {
                row_of_voxel_[voxel] = uint32_t(voxels_.size());
                voxels_.push_back(voxel);
                add(voxel, std::span<const uint32_t>(far_));
            }
            row_of_eye_.push_back(row_of_voxel_[voxel]);
        }
    }
    std::span<const uint32_t> of_eyes() const { return row_of_eye_; }

private:
    static constexpr uint32_t kNone = ~uint32_t{0};

    const VoxelVisibility& map_;
    std::vector<uint32_t> row_of_voxel_, voxels_, row_of_eye_, far_;
};

}  // namespace viscache
