#include "viscache/math/equal_area_batch.h"

#include "viscache/math/isa_variants.h"
#include "viscache/math/octahedral.h"

namespace viscache {
namespace {

inline __attribute__((always_inline)) void to_directions(const float* __restrict u, const float* __restrict v,
                                                         size_t n, float* __restrict x, float* __restrict y,
                                                         float* __restrict z) {
    // Inner loops of a fixed length are vectorised.
    for (size_t first = 0; first < n; first += kEqualAreaLanes)
        for (size_t i = first; i < first + kEqualAreaLanes; ++i) {
            const Vec3 d = equal_area_to_direction({u[i], v[i]});
            x[i] = d.x;
            y[i] = d.y;
            z[i] = d.z;
        }
}

inline __attribute__((always_inline)) void to_points(const float* __restrict x, const float* __restrict y,
                                                     const float* __restrict z, size_t n, float* __restrict u,
                                                     float* __restrict v) {
    for (size_t first = 0; first < n; first += kEqualAreaLanes)
        for (size_t i = first; i < first + kEqualAreaLanes; ++i) {
            const Vec2 p = direction_to_equal_area({x[i], y[i], z[i]});
            u[i] = p.x;
            v[i] = p.y;
        }
}

}  // namespace

void equal_area_to_directions(const float* u, const float* v, size_t n, float* x, float* y, float* z,
                              Isa isa) {
    variant_of<to_directions>(isa)(u, v, n, x, y, z);
}

void directions_to_equal_area(const float* x, const float* y, const float* z, size_t n, float* u, float* v,
                              Isa isa) {
    variant_of<to_points>(isa)(x, y, z, n, u, v);
}

void equal_area_to_directions(std::span<const Vec2> points, std::span<Vec3> directions) {
    for (size_t i = 0; i < points.size(); ++i) directions[i] = equal_area_to_direction(points[i]);
}

void directions_to_equal_area(std::span<const Vec3> directions, std::span<Vec2> points) {
    for (size_t i = 0; i < directions.size(); ++i) points[i] = direction_to_equal_area(directions[i]);
}

}  // namespace viscache
