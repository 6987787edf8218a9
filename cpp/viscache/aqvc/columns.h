#pragma once
// The far ends of a block as columns. Lights with equal keys share a column.
#include <map>
#include <vector>

#include "viscache/aqvc/cluster_key.h"
#include "viscache/aqvc/parameters.h"
#include "viscache/visibility/oracle.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

/// The semantic that the key of a connection in this group uses.
// A virtual point light is a surface with a density, yet in the default key it is a point of its own: no two
// VPLs share bits (A26).
inline Semantic key_semantic(Semantic s, int group, const AqvcParameters& p) {
    const bool vpl = s == Semantic::kSurface && LightGroup(group) == LightGroup::kVpl;
    return vpl && p.vpl_key == VplKey::kPoint ? Semantic::kPoint : s;
}

/// R of the far end by Eq. 7 or 9; unused for points and directions.
// Differs (A46): a cell holds C_L × C_L light samples on average; the paper fixes C_L = 1. If the occluders
// of the sky are finer than such cells, C_E alone cannot reduce the error.
inline double far_resolution(Semantic s, double density, double radius, const AqvcParameters& p) {
    if (s == Semantic::kSurface) return resolution_light(density, radius) / p.c_l;
    if (s == Semantic::kSolidAngle) return resolution_environment(density, p.env_rule) / p.c_l;
    return 1;
}

/// Matrix of eye points × columns of one block.
class Columns {
public:
    /// `usable[eye]` is true if the eye point has cells.
    void prepare(const FarEnds& lights, const BitMatrix& wanted, const CellGrid& grid,
                 const AqvcParameters& p, const std::vector<uint8_t>& usable, ClampCounts& clamps) {
        lights_ = &lights;
        wanted_ = &wanted;
        key_lights(grid, p, clamps);
        // Lights that share a key, or have none, make columns differ from lights. Otherwise both are the
        // same, and no table of numbers is needed.
        merged_ = count_ != lights.count;
        if (!merged_) return;
        own_.reset(wanted.rows(), count_);
        for (size_t i = 0; i < wanted.rows(); ++i)
            // A column is queried if any of its lights is wanted.
            if (usable[i])
                for_each_bit(wanted.row_span(i), [&](size_t k) {
                    if (of_light_[k] != kNone) own_.set(i, of_light_[k]);
                });
    }
    size_t count() const { return count_; }
    bool merged() const { return merged_; }
    const FarEnds& lights() const { return *lights_; }
    /// The queries to the cache: bits by eye point and column.
    const BitMatrix& queries() const { return merged_ ? own_ : *wanted_; }
    /// The light whose ray is traced for a column at an eye point: the lowest that is wanted there.
    uint32_t light(uint32_t eye, uint32_t column) const {
        if (!merged_) return column;
        // One ray answers for all lights of a column; which one must not depend on anything but the query.
        for (uint32_t k : lights_of_[column])
            if (wanted_->get(eye, k)) return k;
        return lights_of_[column].front();
    }
    /// Calls visit(light) for each light of a column that is wanted at an eye point.
    template <class Visit>
    void for_each_light(uint32_t eye, uint32_t column, Visit visit) const {
        if (!merged_) return visit(column);
        for (uint32_t k : lights_of_[column])
            if (wanted_->get(eye, k)) visit(k);
    }
    /// True if the light has no key, so that its queries bypass the cache.
    bool bypasses(size_t light) const { return of_light_[light] == kNone; }
    /// Copies the answers of columns to their lights.
    void spread(const BitMatrix& by_column, BitMatrix& by_light) const {
        for (size_t i = 0; i < wanted_->rows(); ++i)
            for_each_bit(wanted_->row_span(i), [&](size_t k) {
                if (of_light_[k] != kNone && by_column.get(i, of_light_[k])) by_light.set(i, k);
            });
    }

private:
    static constexpr uint32_t kNone = 0xffffffffu;

    void key_lights(const CellGrid& grid, const AqvcParameters& p, ClampCounts& clamps) {
        const FarEnds& l = *lights_;
        const Semantic s = key_semantic(l.semantic, l.group, p);
        of_light_.assign(l.count, kNone);
        lights_of_.clear();
        // A map and first-come numbers: the order of columns is that of their first lights.
        std::map<std::array<int32_t, 7>, uint32_t> column_of;
        for (size_t k = 0; k < l.count; ++k) {
            const Vec3 far{l.x[k], l.y[k], l.z[k]}, end{l.tx[k], l.ty[k], l.tz[k]};
            const Vec3 normal = s == Semantic::kSurface ? Vec3{l.nx[k], l.ny[k], l.nz[k]} : Vec3{};
            FarKey key;
            // Points and directions have no cells, so their density does not matter.
            const double density = s == Semantic::kPoint || s == Semantic::kDirection ? 0 : l.density[k];
            if (!is_traceable(end) ||
                !grid.far_key(s, far, normal, far_resolution(s, density, grid.radius(), p), key, clamps))
                continue;
            const auto [found, fresh] = column_of.try_emplace(key.slots, uint32_t(lights_of_.size()));
            if (fresh) lights_of_.emplace_back();
            of_light_[k] = found->second;
            lights_of_[found->second].push_back(uint32_t(k));
        }
        count_ = lights_of_.size();
    }

    const FarEnds* lights_ = nullptr;
    const BitMatrix* wanted_ = nullptr;
    BitMatrix own_;
    std::vector<uint32_t> of_light_;
    std::vector<std::vector<uint32_t>> lights_of_;
    size_t count_ = 0;
    bool merged_ = false;
};

}  // namespace viscache
