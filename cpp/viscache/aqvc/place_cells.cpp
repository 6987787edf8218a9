#include "viscache/aqvc/place_cells.h"

#include "viscache/math/isa_variants.h"

namespace viscache {
namespace {

// One step of placement: 16 eye points, two vectors of eight doubles.
constexpr size_t kGroup = 16;
/// `floor_small` is exact below this bound: it adds and subtracts 1.5·2^52.
constexpr double kExact = 0x1p51;

typedef double Lanes __attribute__((vector_size(64), aligned(8), may_alias));
#define VISCACHE_INLINE inline __attribute__((always_inline))

struct Group {
    const double *x, *y, *z, *scale;
    double offset_x, offset_y, offset_z, c_z;
    double *cell_x, *cell_y, *cell_z, *distance2;
};

VISCACHE_INLINE Lanes load_lanes(const double* p) { return *reinterpret_cast<const Lanes*>(p); }
VISCACHE_INLINE void store_lanes(double* p, Lanes v) { *reinterpret_cast<Lanes*>(p) = v; }
/// Floor without an instruction for it: a double of 2^52 and more has no fraction, so adding 1.5 · 2^52
/// rounds to an integer and subtracting it gives this integer back. If that was rounded upwards, it is 1 too
/// high.
VISCACHE_INLINE Lanes floor_small(Lanes v) {
    const Lanes rounded = (v + 0x1.8p52) - 0x1.8p52;
    return rounded - (rounded > v ? Lanes{} + 1 : Lanes{});
}

/// CellGrid::cell and distance2_to_center with the same order of operations. False if a coordinate is NaN or
/// too large for `floor_small`.
VISCACHE_INLINE bool place_body(const Group& g) {
    bool small = true;
    for (size_t i = 0; i < kGroup; i += 8) {
        const Lanes s = load_lanes(g.scale + i);
        const Lanes fx = load_lanes(g.x + i) * s + g.offset_x, fy = load_lanes(g.y + i) * s + g.offset_y;
        const Lanes fz = load_lanes(g.z + i) * s * g.c_z + g.offset_z;
        const Lanes x = floor_small(fx), y = floor_small(fy), z = floor_small(fz);
        const Lanes ax = fx - x - 0.5, ay = fy - y - 0.5;
        store_lanes(g.cell_x + i, x);
        store_lanes(g.cell_y + i, y);
        store_lanes(g.cell_z + i, z);
        store_lanes(g.distance2 + i, ax * ax + ay * ay);
        // NaN fails both comparisons.
        for (const Lanes& v : {fx, fy, fz}) {
            const auto fits = (v > -kExact) & (v < kExact);
            small &= (fits[0] & fits[1] & fits[2] & fits[3] & fits[4] & fits[5] & fits[6] & fits[7]) != 0;
        }
    }
    return small;
}

#undef VISCACHE_INLINE

}  // namespace

void CellPlacer::begin(const TileAnchors& tile) {
    tile_ = &tile;
    // Padding lanes are placed as well, and never read.
    const size_t n = (tile.size() + kGroup - 1) / kGroup * kGroup;
    for (auto* v : {&x_, &y_, &z_, &root_}) v->assign(n, 0.0);
    for (size_t i = 0; i < tile.size(); ++i) {
        if (!tile.usable[i]) continue;
        const Anchor& a = tile.anchor[i];
        x_[i] = a.x;
        y_[i] = a.y;
        z_[i] = a.z;
        // C_E times R_e of Eq. 7. Levels only divide it by their C_E, so the root is taken once per eye
        // point.
        root_[i] = resolution_eye(tile.eyes->density[i], 1.0, tile.grid->radius());
    }
}

void CellPlacer::place(double c_e, PlacedLevel& out, ClampCounts& clamps, Isa isa) {
    const CellGrid& grid = *tile_->grid;
    const auto kernel = variant_of<place_body>(isa);
    const auto& o = grid.offset();
    out.resize(x_.size());
    for (size_t i = 0; i < x_.size(); i += kGroup) {
        const size_t end = std::min(i + kGroup, tile_->size());
        find_rungs(c_e, i, end, out.slot.data(), clamps);
        const Group g{&x_[i], &y_[i],     &z_[i],    scale_,    o[0],      o[1],
                      o[2],   grid.c_z(), &out.x[i], &out.y[i], &out.z[i], &out.distance2[i]};
        // `find_rungs` has counted the clamps of these points.
        ClampCounts counted_already;
        if (!kernel(g)) place_singly(c_e, i, end, out, counted_already);
    }
}

/// Finds slots and scales of up to 16 eye points.
void CellPlacer::find_rungs(double c_e, size_t first, size_t last, int32_t* slot, ClampCounts& clamps) {
    const CellGrid& grid = *tile_->grid;
    for (size_t i = first; i < last; ++i) {
        if (!tile_->usable[i]) {
            // Scale 0 puts an unusable point into a valid cell, which nobody reads.
            scale_[i - first] = 0;
            continue;
        }
        const Rung& rung = grid.ladder.rung_near(root_[i] / c_e, rung_, clamps);
        slot[i] = rung.slot;
        scale_[i - first] = grid.scale(rung);
    }
    // So that padding lanes never leave the range of `floor_small`
    for (size_t i = last; i < first + kGroup; ++i) scale_[i - first] = 0;
}

/// The scalar form, for coordinates that the kernel cannot handle.
void CellPlacer::place_singly(double c_e, size_t first, size_t last, PlacedLevel& out,
                              ClampCounts& clamps) const {
    for (size_t i = first; i < last; ++i) {
        if (!tile_->usable[i]) continue;
        const PlacedCell p = tile_->cell(i, c_e, clamps);
        out.slot[i] = p.cell.slot;
        out.x[i] = double(p.cell.x);
        out.y[i] = double(p.cell.y);
        out.z[i] = double(p.cell.z);
        out.distance2[i] = distance2_to_center(p);
    }
}

}  // namespace viscache
