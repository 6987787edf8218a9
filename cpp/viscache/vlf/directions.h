#pragma once
// The directions of the parallel subfields: unsigned axes distributed over the hemisphere.
#include <cstdint>
#include <span>
#include <vector>

#include "viscache/math/frame.h"
#include "viscache/math/vec.h"

namespace viscache {

/// Number of subdivisions N of each edge of the half octahedron; l = 2N² + 1.
constexpr uint32_t kMostSubdivisions = 64;

/// True for l = 1 and for l = 2·4^k + 1 up to 8193.
bool is_direction_count(uint64_t n_directions);

/// [VLF Sec. 3.1] The set Ω_l. The triangles of a half octahedron are subdivided repeatedly, and each new
/// vertex is moved onto the sphere. Axes have no sign, so only one of a vertex on the equator and its
/// antipode is kept. The axes are in the order of the lattice (i, j), |i| + |j| <= N, by i, then by j. l = 1
/// is the z axis alone.
// Differs (V2): the paper says "regular tetrahedron"; its 513 directions are those of a half octahedron
// (2·16² + 1).
class Directions {
public:
    /// Throws std::invalid_argument unless is_direction_count(n_directions).
    explicit Directions(uint32_t n_directions);

    uint32_t size() const { return uint32_t(axes_.size()); }
    /// Unit vectors with z >= 0.
    std::span<const Vec3> axes() const { return axes_; }
    /// Right-handed orthonormal frames (u, v, w), where w is the axis. to_local gives canonical coordinates.
    std::span<const Frame3> frames() const { return frames_; }
    /// Solid angle of the directions (of one sign) that are nearest to each axis; the sum is 2π.
    // Differs (V3): the paper weights all directions equally; the solid angles of their cells vary by a
    // factor of two.
    std::span<const float> weights() const { return weights_; }
    /// The axis with the largest |cos| to d; of equal ones, the lowest index. d is finite and of any length
    /// except 0. Exact, in constant time: each cell of an octahedral map lists all axes that are nearest to
    /// some direction in it.
    // Differs (V10): Slater's map of colour-coded cells is exact only away from the borders of the cells.
    uint32_t nearest(Vec3 d) const;

private:
    std::vector<Vec3> axes_;
    std::vector<Frame3> frames_;
    std::vector<float> weights_;
    uint32_t map_size_ = 1;             ///< K: cells along an edge of the map
    std::vector<uint32_t> first_;       ///< (K² + 1) ends of lists
    std::vector<uint16_t> candidates_;  ///< axes by cell, ascending
};

/// The directions for a given count, created on first use and kept.
const Directions& directions_of(uint32_t n_directions);

}  // namespace viscache
