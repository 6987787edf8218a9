#include "viscache/vlf/direction_lattice.h"

namespace viscache {

// Seen from above, with the apex in the middle and the equator as the border |i| + |j| = N:
//
//                (0, N)
//              .    |    .
//      (-N, 0) - (0, 0) - (N, 0)      j
//              .    |    .            ^
//                (0, -N)              +-> i
DirectionLattice::DirectionLattice(int subdivisions) : n_(subdivisions) {
    std::vector<Double3> position(size_t(2 * n_ + 1) * size_t(2 * n_ + 1));
    position[cell(0, 0)] = {0, 0, 1};
    if (n_ > 0) {
        position[cell(n_, 0)] = {1, 0, 0};
        position[cell(-n_, 0)] = {-1, 0, 0};
        position[cell(0, n_)] = {0, 1, 0};
        position[cell(0, -n_)] = {0, -1, 0};
    }
    // Recursive: each step halves all edges, and the new vertices move to the sphere before the next step.
    // Dividing the flat faces at once would crowd the axes near the corners of the octahedron.
    for (int step = n_; step > 1; step /= 2) subdivide(position, step / 2);
    index_.resize(position.size());
    for (int i = -n_; i <= n_; ++i)
        for (int j = -n_; j <= n_; ++j) {
            if (std::abs(i) + std::abs(j) > n_ || !kept(i, j)) continue;
            index_[cell(i, j)] = size();
            // On the equator, both ends of an axis are vertices of the upper half.
            if (std::abs(i) + std::abs(j) == n_) index_[cell(-i, -j)] = size();
            places_.push_back({i, j});
            axes_.push_back(position[cell(i, j)]);
        }
}

/// Adds a vertex above the middle of every edge between vertices at distance 2·half, and moves it onto the
/// sphere.
void DirectionLattice::subdivide(std::vector<Double3>& position, int half) const {
    // Vertices of the coarser lattice have even multiples of `half` as coordinates.
    const auto odd = [half](int i) { return i / half % 2 != 0; };
    for (int i = -n_; i <= n_; i += half)
        for (int j = -n_; j <= n_; j += half) {
            if (std::abs(i) + std::abs(j) > n_ || (!odd(i) && !odd(j))) continue;
            // The edge runs along i, along j, or diagonally between the two axes
            const int di = odd(i) ? half : 0;
            // Diagonals are parallel to the border of their quadrant: i + j is constant where i and j have
            // the same sign.
            const int dj = !odd(j) ? 0 : odd(i) && (i > 0) == (j > 0) ? -half : half;
            const Double3 &a = position[cell(i - di, j - dj)], &b = position[cell(i + di, j + dj)];
            position[cell(i, j)] = unit({a[0] + b[0], a[1] + b[1], a[2] + b[2]});
        }
}

}  // namespace viscache
