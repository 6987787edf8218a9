#pragma once
// The directions of the parallel subfields: unsigned axes spread over the half sphere.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/frame.h"
#include "viscache/math/vec.h"

namespace viscache {

/// Subdivisions N of each edge of the half octahedron; l = 2N² + 1.
constexpr uint32_t kMostSubdivisions = 64;

/// True for l = 1 and for l = 2·4^k + 1 up to 8193.
bool is_direction_count(uint64_t n_directions);

/// [VLF Sec. 3.1] The set Ω_l. A half octahedron whose triangles are halved again and again, each new vertex
/// moved onto the sphere; of a vertex of the equator and its antipode only one is kept, as axes have no
/// sign. Axes in the order of the lattice (i, j), |i| + |j| <= N, by i, then j; l = 1 is the z axis alone.
// Differs: the paper says "regular tetrahedron"; its 513 directions are a half octahedron's (2·16² + 1).
class Directions {
public:
    /// Throws std::invalid_argument unless is_direction_count(n_directions).
    explicit Directions(uint32_t n_directions);

    uint32_t size() const { return uint32_t(axes_.size()); }
    /// Unit, z >= 0.
    std::span<const Vec3> axes() const { return axes_; }
    /// Right-handed orthonormal frames (u, v, w) with w the axis: to_local gives canonical coordinates.
    std::span<const Frame3> frames() const { return frames_; }
    /// Solid angle of the directions (of one sign) nearest to each axis; they add up to 2π.
    // Differs: the paper weighs all directions alike; their cells' solid angles vary by a factor of two.
    std::span<const float> weights() const { return weights_; }
    /// The axis with the greatest |cos| to d, the lowest of equals; d of any length but 0, finite. Exact, in
    /// constant time: a cell of an octahedral map lists all axes that are nearest anywhere in it.
    // Differs: Slater's map of colour-coded cells is exact only away from the cells' borders.
    uint32_t nearest(Vec3 d) const;

private:
    std::vector<Vec3> axes_;
    std::vector<Frame3> frames_;
    std::vector<float> weights_;
    uint32_t map_size_ = 1;             ///< K: cells along an edge of the map
    std::vector<uint32_t> first_;       ///< (K² + 1) ends of lists
    std::vector<uint16_t> candidates_;  ///< axes by cell, ascending
};

/// The directions of one count, made on first use and kept.
const Directions& directions_of(uint32_t n_directions);

}  // namespace viscache
