#pragma once
// Axis-aligned bounding boxes.
#include "viscache/math/vec.h"

namespace viscache {

struct Bounds {
    Vec3 lo{kInfinity, kInfinity, kInfinity};
    Vec3 hi{-kInfinity, -kInfinity, -kInfinity};

    bool empty() const { return lo.x > hi.x; }
    void add(Vec3 p) {
        lo = min(lo, p);
        hi = max(hi, p);
    }
    void add(const Bounds& b) {
        lo = min(lo, b.lo);
        hi = max(hi, b.hi);
    }
    Vec3 center() const { return (lo + hi) * 0.5f; }
    float diagonal() const { return empty() ? 0.f : length(hi - lo); }
    float half_area() const {
        if (empty()) return 0;
        const Vec3 e = hi - lo;
        return e.x * e.y + e.y * e.z + e.z * e.x;
    }
    /// Largest absolute coordinate; the rounding error of points in the box is proportional to it.
    float magnitude() const {
        return empty() ? 0.f : std::max(max_component(max(lo, -lo)), max_component(max(hi, -hi)));
    }
};

}  // namespace viscache
