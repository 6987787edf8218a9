#include "viscache/vlf/directions.h"

#include <map>
#include <mutex>
#include <stdexcept>
#include <string>

#include "viscache/vlf/direction_lattice.h"

namespace viscache {

namespace {

// Distance, in steps of the lattice, within which the Voronoi neighbours of an axis and the candidates of a
// cell lie. The tests compare with a search over all axes.
constexpr int kReach = 3;
constexpr int kCellsPerStep = 8;  // cells of the map per step of the lattice; lists have 1.75 axes on average

struct Place2 {
    double x, y;
};

/// Clips a convex polygon to the half plane a·x + b·y <= c.
std::vector<Place2> clipped(const std::vector<Place2>& polygon, double a, double b, double c) {
    std::vector<Place2> inside;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const Place2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
        const double dp = c - a * p.x - b * p.y, dq = c - a * q.x - b * q.y;
        // A corner on the border stays once; only proper crossings add one.
        if (dp >= 0) inside.push_back(p);
        if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) {
            const double t = dp / (dp - dq);
            inside.push_back({p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)});
        }
    }
    return inside;
}

/// Solid angle of a spherical triangle of unit vectors (Van Oosterom, Strackee 1983).
double triangle_solid_angle(const Double3& a, const Double3& b, const Double3& c) {
    return 2 * std::atan2(std::abs(dot(a, cross(b, c))), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

/// Solid angle of the directions that are nearer to an axis than to any other vertex. This cell is a convex
/// polygon in the tangent plane of the axis, bounded by the planes half way to its neighbours.
double cell_solid_angle(const DirectionLattice& lattice, uint32_t index) {
    const Double3 w = lattice.axis(index);
    // Any tangent will do: the one with the first axis that is not nearly parallel.
    const Double3 u = unit(cross(w, std::abs(w[0]) < 0.5 ? Double3{1, 0, 0} : Double3{0, 1, 0}));
    const Double3 v = cross(w, u);
    // Larger than any cell: the farthest corner of a cell is 55° from its axis (l = 3), and atan 2 is 63°.
    std::vector<Place2> cell{{-2, -2}, {2, -2}, {2, 2}, {-2, 2}};
    lattice.around(index, kReach, [&](uint32_t other, double sign) {
        if (other == index) return;
        const Double3& o = lattice.axis(other);
        // (w + x·u + y·v)·(o − w) <= 0
        cell = clipped(cell, sign * dot(u, o), sign * dot(v, o), 1 - sign * dot(w, o));
    });
    std::vector<Double3> corner;
    for (const Place2 p : cell) {
        Double3 d;
        for (size_t k = 0; k < 3; ++k) d[k] = w[k] + p.x * u[k] + p.y * v[k];
        corner.push_back(unit(d));
    }
    double sum = 0;
    // The cell is a fan of spherical triangles around its axis.
    for (size_t i = 0; i < corner.size(); ++i)
        sum += triangle_solid_angle(w, corner[i], corner[(i + 1) % corner.size()]);
    return sum;
}

/// Octahedral map of the upper hemisphere, rotated by 45° to fill [0, 1]².
Double3 upper_direction(double s, double t) {
    const double x = s + t - 1, y = s - t;
    return unit({x, y, std::max(0.0, 1 - std::abs(x) - std::abs(y))});
}

/// Unsigned, and accurate at small angles, where the arc cosine is not.
double angle_between_axes(const Double3& a, const Double3& b) {
    const Double3 n = cross(a, b);
    return std::atan2(std::sqrt(dot(n, n)), std::abs(dot(a, b)));
}

/// Axis nearest to d. Descending over Voronoi neighbours finds it from any start.
uint32_t nearest_from(const DirectionLattice& lattice, uint32_t start, const Double3& d) {
    // Strictly falling angles: the loop ends, and on Voronoi neighbours a local minimum is the global one.
    for (uint32_t at = start;;) {
        uint32_t best = at;
        double cos = std::abs(dot(d, lattice.axis(at)));
        lattice.around(at, kReach, [&](uint32_t other, double) {
            const double c = std::abs(dot(d, lattice.axis(other)));
            if (c > cos) {
                cos = c;
                best = other;
            }
        });
        if (best == at) return at;
        at = best;
    }
}

/// Axes that are nearest to some direction of a cell with this centre and angular radius, ascending. By the
/// triangle inequality, their distance from the centre exceeds that of the nearest axis by at most twice the
/// radius.
std::vector<uint16_t> candidates(const DirectionLattice& lattice, uint32_t nearest, const Double3& centre,
                                 double radius) {
    const double reach = angle_between_axes(centre, lattice.axis(nearest)) + 2 * radius;
    std::vector<uint16_t> found;
    // Within the reach of the lattice; the tests compare with all axes.
    lattice.around(nearest, kReach, [&](uint32_t other, double) {
        if (angle_between_axes(centre, lattice.axis(other)) <= reach) found.push_back(uint16_t(other));
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

}  // namespace

bool is_direction_count(uint64_t n_directions) {
    for (uint64_t n = 1; n <= kMostSubdivisions; n *= 2)
        if (n_directions == 2 * n * n + 1) return true;
    return n_directions == 1;
}

Directions::Directions(uint32_t n_directions) {
    if (!is_direction_count(n_directions))
        throw std::invalid_argument(
            "n_directions must be 1, 3, 9, 33, 129, 513, 2049 or 8193 (2·4^k + 1), got " +
            std::to_string(n_directions));
    // l = 2 N² + 1
    const int n = n_directions == 1 ? 0 : int(std::lround(std::sqrt((n_directions - 1) / 2)));
    const DirectionLattice lattice(n);
    for (uint32_t i = 0; i < lattice.size(); ++i) {
        const Double3& a = lattice.axis(i);
        axes_.push_back({float(a[0]), float(a[1]), float(a[2])});
        frames_.push_back(frame_around(axes_.back()));
        weights_.push_back(n == 0 ? 2 * kPi : float(cell_solid_angle(lattice, i)));
    }
    map_size_ = uint32_t(std::max(1, kCellsPerStep * n));
    first_ = {0};
    // Successive cells are neighbours, so that the search begins near its end.
    uint32_t nearest = 0;
    for (uint32_t y = 0; y < map_size_; ++y)
        for (uint32_t x = 0; x < map_size_; ++x) {
            const auto at = [&](double dx, double dy) {
                return upper_direction((x + dx) / map_size_, (y + dy) / map_size_);
            };
            const Double3 centre = at(0.5, 0.5);
            double radius = 0;  // a corner is the farthest point of a cell
            for (int corner = 0; corner < 4; ++corner)
                radius = std::max(radius, angle_between_axes(centre, at(corner & 1, corner >> 1)));
            nearest = nearest_from(lattice, nearest, centre);
            // 5 % larger, to allow for the rounding of directions and cells
            const auto list = candidates(lattice, nearest, centre, 1.05 * radius);
            candidates_.insert(candidates_.end(), list.begin(), list.end());
            first_.push_back(uint32_t(candidates_.size()));
        }
}

uint32_t Directions::nearest(Vec3 d) const {
    // Divided by the sum of absolute values, d lies on the octahedron. There, the map is linear.
    const float l = std::fabs(d.x) + std::fabs(d.y) + std::fabs(d.z);
    d = {d.x / l, d.y / l, d.z / l};  // multiplying by 1/l would overflow for the shortest vectors
    // An axis has no sign.
    if (d.z < 0) d = -d;
    // Rounding may leave the map by a cell.
    const auto place = [&](float p) {
        return std::min(map_size_ - 1, uint32_t(std::max(0.f, p * float(map_size_))));
    };
    // Inverse of `upper_direction`: t gives the row, s the column.
    const size_t cell = size_t(place((d.x - d.y + 1) * 0.5f)) * map_size_ + place((d.x + d.y + 1) * 0.5f);
    uint32_t best = candidates_[first_[cell]];
    if (first_[cell + 1] - first_[cell] == 1) return best;
    float cos = -1;
    // Candidates ascend and only larger cosines win: of equal ones, the lowest index.
    for (uint32_t k = first_[cell]; k < first_[cell + 1]; ++k) {
        const float c = std::fabs(dot(d, axes_[candidates_[k]]));
        if (c > cos) {
            cos = c;
            best = candidates_[k];
        }
    }
    return best;
}

const Directions& directions_of(uint32_t n_directions) {
    static std::mutex mutex;
    static std::map<uint32_t, Directions> made;
    // A map never moves its elements, so references stay valid while others are added.
    const std::lock_guard lock(mutex);
    const auto found = made.find(n_directions);
    return found != made.end() ? found->second : made.try_emplace(n_directions, n_directions).first->second;
}

}  // namespace viscache
