#pragma once
// Maps points to cells and keys (AQVC Sec. 3.3, 3.5). Queries with equal keys share one bit.
//
// Key slots: 0 semantic index | 1–3 normal bin of X | 4–6 voxel of X | 7 R of X | 8–14 far end, zero padded.
// A surface takes 7 slots like X, a point or direction 3 float bit patterns, a solid angle i, j, R. All
// values are computed in double from float input; -ffp-contract=off makes them equal on every machine.
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "viscache/aqvc/normal_bins.h"
#include "viscache/aqvc/parameters.h"
#include "viscache/aqvc/resolution.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

using FullKey = std::array<int32_t, 15>;

/// A voxel of a virtual grid. The 64-bit coordinates stay exact at very large resolutions.
struct Cell {
    int32_t bin = 0;   ///< number of the normal bin
    int32_t slot = 0;  ///< rung of the ladder
    int64_t x = 0, y = 0, z = 0;
    bool operator==(const Cell&) const = default;
};

/// A point in the coordinates of the grid of its normal, from which its cells of any size follow.
struct Anchor {
    double x = 0, y = 0, z = 0;       ///< q·e + B_R along the axes of the grid
    double slope_x = 0, slope_y = 0;  ///< rise of the tangent plane: cells of z per cell of x and y
    int32_t bin = 0;
    bool valid = false;  ///< true if the point is finite and has a normal
};

/// A cell and the position of the point in it.
struct PlacedCell {
    Cell cell;
    double fx = 0, fy = 0, fz = 0;  ///< continuous coordinates; the cell is their floor
};

/// Squared distance of a point to the centre of its cell in the two tangent coordinates, in cells.
// In cells, so that distances compare between levels. Across the surface only: z says how thick a slab is.
inline double distance2_to_center(const PlacedCell& p) {
    const double ax = p.fx - double(p.cell.x) - 0.5, ay = p.fy - double(p.cell.y) - 0.5;
    return ax * ax + ay * ay;
}

/// Finaliser of MurmurHash3.
inline uint64_t murmur64(uint64_t h) {
    h ^= h >> 33;
    h *= 0xff51afd7ed558ccdull;
    h ^= h >> 33;
    h *= 0xc4ceb9fe1a85ec53ull;
    return h ^ h >> 33;
}

/// A 64-bit coordinate as one slot of a key: the value itself if it fits and is not folded, otherwise a hash.
inline int32_t fold_coordinate(int64_t v, bool folded) {
    // Very fine grids have more cells than 32 bits count. A hash of the coordinate is as good in a key: equal
    // cells have equal keys, and different ones collide with a chance of 2^−32.
    const bool fits = v >= INT32_MIN && v <= INT32_MAX;
    return fits && !folded ? int32_t(v) : int32_t(uint32_t(murmur64(uint64_t(v))));
}

/// Bit pattern of a coordinate; −0 counts as 0.
// Adding +0 turns −0 into +0 and leaves all other numbers as they are.
inline int32_t float_bits(float f) { return std::bit_cast<int32_t>(f + 0.0f); }

/// The part of a key that describes the far end.
struct FarKey {
    Semantic semantic = Semantic::kPoint;
    std::array<int32_t, 7> slots{};
    bool operator==(const FarKey&) const = default;
};

// Only in the tangent plane: across it, a neighbour would lie beside the surface.
constexpr std::array<std::array<int, 2>, 4> kNeighbourOffsets = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

/// The virtual multi-resolution grids of one scene.
class CellGrid {
public:
    CellGrid(const AqvcParameters& p, Vec3 center, double radius)
        : ladder(p.c_r, p.c_z, p.scale_free),
          direction_ladder(p.c_r, p.c_z),
          parameters_(p),
          bins_(p.normal_mode, p.c_n),
          center_(p.scale_free ? Vec3{} : center),
          // With 2 B_R = 1, resolutions are cells per unit of length
          radius_(p.scale_free ? 0.5 : radius),
          // A single grid for all normals has no direction in which cells could be thinner
          c_z_(p.normal_mode == NormalMode::kSingle ? 1 : p.c_z) {
        if (!p.grid_offset) return;
        // Without an offset, walls at round coordinates lie on the borders of cells, and rounding scatters
        // their points over both sides. Fractions without a simple ratio keep all borders off such places
        // (A7).
        offset_ = {0.7549, 0.5698, 0.4263};
        // Seeds shift the grid further, for estimates of the error by repetition.
        if (p.grid_seed)
            for (size_t a = 0; a < 3; ++a)
                offset_[a] += double(murmur64(uint64_t{3} * p.grid_seed + a) >> 11) * 0x1p-53;
    }
    const Ladder ladder;
    const Ladder direction_ladder;  ///< for solid angles, which have no length
    /// B_R for the resolution equations; ½ if grids are scale-free.
    double radius() const { return radius_; }
    double c_z() const { return c_z_; }
    const std::array<double, 3>& offset() const { return offset_; }
    /// Cells per unit length.
    double scale(const Rung& r) const { return r.resolution / (2 * radius_); }

    Anchor anchor(Vec3 p, Vec3 n) const;
    PlacedCell cell(const Anchor& a, const Rung& r) const;
    /// The neighbour at (dx, dy). It follows the tangent plane. With `level`, or with the option off, it
    /// keeps z.
    // Differs (A14): AQVC keeps z, so neighbours of tilted cells leave the surface. Here v_z' follows the
    // plane: v_z' = ⌊z − C_Z (N·e)/(N·e_z)·(±1)⌋.
    Cell neighbour(const Anchor& a, const PlacedCell& p, int dx, int dy, bool level = false) const {
        Cell c = p.cell;
        c.x += dx;
        c.y += dy;
        if (parameters_.tangent_neighbours && !level)
            c.z = floor_to_int(p.fz - (dx * a.slope_x + dy * a.slope_y));
        return c;
    }
    void write_cell(const Cell& c, int32_t* slots) const;
    /// Computes the key of the far end. Returns false if there is none: not finite, or without a normal.
    bool far_key(Semantic s, Vec3 far, Vec3 normal, double resolution, FarKey& key,
                 ClampCounts& clamps) const;
    /// Slots 0–7 of a key.
    std::array<int32_t, 8> head_slots(Semantic s, const Cell& eye) const {
        std::array<int32_t, 8> head{int32_t(s)};
        write_cell(eye, &head[1]);
        return head;
    }
    static FullKey full_key(const std::array<int32_t, 8>& head, const FarKey& far) {
        FullKey k;
        for (size_t i = 0; i < 8; ++i) k[i] = head[i];
        for (size_t i = 0; i < 7; ++i) k[8 + i] = far.slots[i];
        return k;
    }
    FullKey full_key(const Cell& eye, const FarKey& far) const {
        return full_key(head_slots(far.semantic, eye), far);
    }

private:
    static double along(const std::array<double, 3>& e, double x, double y, double z) {
        return e[0] * x + e[1] * y + e[2] * z;
    }
    AqvcParameters parameters_;
    NormalBins bins_;
    Vec3 center_;
    double radius_;
    double c_z_;
    std::array<double, 3> offset_{};
};

inline Anchor CellGrid::anchor(Vec3 p, Vec3 n) const {
    Anchor a;
    a.valid = is_finite(p) && is_finite(n) && (n.x != 0 || n.y != 0 || n.z != 0);
    if (!a.valid) return a;
    a.bin = bins_.of(n);
    const GridAxes& f = bins_.axes(a.bin);
    const double qx = double(p.x) - center_.x, qy = double(p.y) - center_.y, qz = double(p.z) - center_.z;
    // Coordinates of points inside the bounding sphere run from 0 to 2 B_R.
    a.x = along(f.x, qx, qy, qz) + radius_;
    a.y = along(f.y, qx, qy, qz) + radius_;
    a.z = along(f.z, qx, qy, qz) + radius_;
    // The tangent plane N·(q − p) = 0 rises by −(N·e_x)/(N·e_z) along e_x. In cells, which are C_Z times
    // thinner along e_z, that is `slope_x` per cell. A plane that is nearly parallel to e_z has no useful
    // slope.
    const double nz = along(f.z, n.x, n.y, n.z);
    if (std::fabs(nz) > 0.01) {
        a.slope_x = c_z_ * along(f.x, n.x, n.y, n.z) / nz;
        a.slope_y = c_z_ * along(f.y, n.x, n.y, n.z) / nz;
    }
    return a;
}

inline PlacedCell CellGrid::cell(const Anchor& a, const Rung& r) const {
    const double s = scale(r);
    PlacedCell p;
    // R/(2 B_R) cells per unit; slabs along the normal are C_Z times thinner.
    p.fx = a.x * s + offset_[0];
    p.fy = a.y * s + offset_[1];
    p.fz = a.z * s * c_z_ + offset_[2];
    p.cell = {a.bin, r.slot, floor_to_int(p.fx), floor_to_int(p.fy), floor_to_int(p.fz)};
    return p;
}

inline void CellGrid::write_cell(const Cell& c, int32_t* slots) const {
    // Rungs below 0 are beyond the range of exact coordinates.
    const bool folded = c.slot < 0 && !parameters_.scale_free;
    const auto [i, j, k] = bins_.slots(c.bin);
    slots[0] = i;
    slots[1] = j;
    slots[2] = k;
    slots[3] = fold_coordinate(c.x, folded);
    slots[4] = fold_coordinate(c.y, folded);
    slots[5] = fold_coordinate(c.z, folded);
    slots[6] = c.slot;
}

inline bool CellGrid::far_key(Semantic s, Vec3 far, Vec3 normal, double resolution, FarKey& key,
                              ClampCounts& clamps) const {
    key = {s, {}};
    if (!is_finite(far)) return false;
    switch (s) {
        case Semantic::kPoint:
        case Semantic::kDirection:
            // Exact bits: shared lights stay distinct however close they are.
            key.slots = {float_bits(far.x), float_bits(far.y), float_bits(far.z)};
            return true;
        case Semantic::kSurface: {
            const Anchor a = anchor(far, normal);
            if (a.valid) write_cell(cell(a, ladder.rung(resolution, clamps)).cell, key.slots.data());
            return a.valid;
        }
        case Semantic::kSolidAngle: {
            if (far == Vec3{}) return false;
            const Rung& r = direction_ladder.rung(resolution, clamps);
            const auto [u, v] = octahedral_square<double>(far);
            // u = 1 belongs to the last cell.
            const double last = r.resolution - 1;
            key.slots = {fold_coordinate(int64_t(std::min(last, std::floor(u * r.resolution))), r.folded),
                         fold_coordinate(int64_t(std::min(last, std::floor(v * r.resolution))), r.folded),
                         r.slot};
            return true;
        }
    }
    return false;
}

}  // namespace viscache
