#pragma once
// Walks a ray over the tiles of a parallel subfield.
#include <algorithm>
#include <cmath>

#include "viscache/math/frame.h"
#include "viscache/visibility/query.h"
#include "viscache/vlf/rasterize.h"

namespace viscache {

/// Position and size of the unit ball of a field in the scene.
struct FieldSpace {
    double center[3] = {0, 0, 0};
    double radius = 1;
};

/// A ray in the unit ball of a field; t is that of the scene. In double: the walk must not deviate from the
/// true ray by the dilation of coverage.
struct FieldRay {
    double o[3], d[3];

    FieldRay(const Ray& ray, const FieldSpace& space) {
        // One division, then products: the direction keeps its length, so t is that of the scene.
        const double s = 1 / space.radius;
        const float from[3] = {ray.o.x, ray.o.y, ray.o.z}, along[3] = {ray.d.x, ray.d.y, ray.d.z};
        for (int i = 0; i < 3; ++i) {
            o[i] = (from[i] - space.center[i]) * s;
            d[i] = along[i] * s;
        }
    }
};

/// The same ray in the canonical space of one subfield, clipped to the cube [−1, 1]³.
struct CanonicalRay {
    double q[3], g[3];  ///< origin and direction
    double t0, t1;      ///< the part inside; empty if t0 > t1
    double length;      ///< length of g in the unit ball

    CanonicalRay(const FieldRay& ray, const Frame3& frame, double t_min, double t_max,
                 const TileFit& fit = {})
        : t0(t_min), t1(t_max) {
        const Vec3* rows[3] = {&frame.x, &frame.y, &frame.z};
        for (int i = 0; i < 3; ++i) {
            q[i] = ray.o[0] * rows[i]->x + ray.o[1] * rows[i]->y + ray.o[2] * rows[i]->z;
            g[i] = ray.d[0] * rows[i]->x + ray.d[1] * rows[i]->y + ray.d[2] * rows[i]->z;
        }
        length = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
        // Tiles of a box are scaled across the beams; depths are not. Scaling changes positions, never t.
        q[0] = (q[0] - fit.x) * fit.scale_x;
        g[0] *= fit.scale_x;
        q[1] = (q[1] - fit.y) * fit.scale_y;
        g[1] *= fit.scale_y;
        // Clips to the slabs of the cube, one axis after the other. A ray parallel to a slab is inside for
        // all t or for none.
        for (int i = 0; i < 3; ++i) {
            if (g[i] == 0) {
                if (std::fabs(q[i]) > 1) t1 = -kInfinity;
                continue;
            }
            const double inverse = 1 / g[i], a = (-1 - q[i]) * inverse, b = (1 - q[i]) * inverse;
            t0 = std::max(t0, std::min(a, b));
            t1 = std::min(t1, std::max(a, b));
        }
    }
};

/// [VLF Sec. 3.3] Calls visit(tile_x, tile_y, t_in, t_out) for the tiles that a ray crosses, front to back,
/// until it returns true [Amanatides, Woo 1987]. Each crossing is computed from its border, so that errors
/// do not accumulate.
template <class Visit>
void walk_tiles(const CanonicalRay& ray, int n, Visit visit) {
    if (!(ray.t0 <= ray.t1)) return;
    const double half = 0.5 * n, width = 2.0 / n;
    // Along an axis on which the ray hardly moves it stays in its tile: it moves less than the dilation of
    // coverage
    const double least = 3e-7 * ray.length;
    int tile[2], step[2];
    double inverse[2], next[2];
    for (int i = 0; i < 2; ++i) {
        // Clamped: rounding may put the entry point beyond the border.
        const double place = (ray.q[i] + ray.t0 * ray.g[i] + 1) * half;
        tile[i] = place > 0 ? int(std::min(place, double(n - 1))) : 0;
        step[i] = ray.g[i] > 0 ? 1 : -1;
        inverse[i] = std::fabs(ray.g[i]) > least ? 1 / ray.g[i] : 0;
    }
    const auto crossing = [&](int i) {
        // The border ahead: the upper one if the ray moves upwards.
        if (inverse[i] == 0) return double(kInfinity);
        return ((tile[i] + (step[i] > 0)) * width - 1 - ray.q[i]) * inverse[i];
    };
    next[0] = crossing(0);
    next[1] = crossing(1);
    double in = ray.t0;
    for (;;) {
        // Next is the nearer of the two borders ahead:
        //
        //      +------+------+
        //      |      |   __/|      in: entry into the tile
        //      +------+__/---+      out: exit, where the ray takes one step along x or y
        //      |   __/|      |
        //      +--/---+------+
        const int axis = next[0] < next[1] ? 0 : 1;
        // Never before `in`: two crossings at a corner may come in the wrong order by rounding.
        const double out = std::max(in, std::min(next[axis], ray.t1));
        if (visit(tile[0], tile[1], in, out) || next[axis] >= ray.t1) return;
        tile[axis] += step[axis];
        if (tile[axis] < 0 || tile[axis] >= n) return;
        next[axis] = crossing(axis);
        in = out;
    }
}

}  // namespace viscache
