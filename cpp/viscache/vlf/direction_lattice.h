#pragma once
// The lattice of a subdivided octahedron, with its positions on the sphere in double.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace viscache {

using Double3 = std::array<double, 3>;

inline double dot(const Double3& a, const Double3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Double3 cross(const Double3& a, const Double3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Double3 unit(const Double3& a) {
    const double l = std::sqrt(dot(a, a));
    return {a[0] / l, a[1] / l, a[2] / l};
}

/// Vertices (a, b, c), |a| + |b| + |c| = N, of an octahedron. Opposite vertices form one axis, represented
/// by its vertex in the upper half.
class DirectionLattice {
public:
    explicit DirectionLattice(int subdivisions);

    uint32_t size() const { return uint32_t(places_.size()); }
    /// Position of an axis, z >= 0.
    const Double3& axis(uint32_t index) const { return axes_[index]; }
    /// Calls visit(axis, sign) for the vertices whose coordinates differ from those of the axis by at most
    /// `reach`, including its own vertex and vertices of the lower half. Such a vertex lies at sign · axis.
    template <class Visit>
    void around(uint32_t index, int reach, Visit visit) const {
        const auto [i, j] = places_[index];
        // Height of the axis's vertex. It is a coordinate like i and j: neighbours are near in all three.
        const int k = n_ - std::abs(i) - std::abs(j);
        for (int a = i - reach; a <= i + reach; ++a)
            for (int b = j - reach; b <= j + reach; ++b) {
                const int c = n_ - std::abs(a) - std::abs(b);
                if (c >= 0 && std::abs(c - k) <= reach) visit(axis_at(a, b), kept(a, b) ? 1.0 : -1.0);
                // (a, b, −c), in the lower half, is the antipode of (−a, −b, c).
                if (c > 0 && std::abs(c + k) <= reach) visit(axis_at(-a, -b), -1.0);
            }
    }

private:
    struct Place {
        int i, j;
    };
    /// Of a vertex on the equator and its antipode, only one represents the axis.
    bool kept(int i, int j) const { return std::abs(i) + std::abs(j) < n_ || j > 0 || (j == 0 && i >= 0); }
    /// Axis of a vertex of the upper half, including the equator.
    uint32_t axis_at(int i, int j) const { return index_[cell(i, j)]; }
    size_t cell(int i, int j) const { return size_t(i + n_) * size_t(2 * n_ + 1) + size_t(j + n_); }
    void subdivide(std::vector<Double3>& position, int half) const;

    int n_;
    std::vector<Place> places_;
    std::vector<Double3> axes_;
    std::vector<uint32_t> index_;
};

}  // namespace viscache
