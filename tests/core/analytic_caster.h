#pragma once
// A ray caster for spheres and boxes. It gives tests of oracles a ground truth that needs no scene.
#include <cmath>
#include <vector>

#include "viscache/visibility/ray_caster.h"

namespace viscache::bindings {

class AnalyticCaster final : public RayCaster {
public:
    struct Box {
        Vec3 lo, hi;
    };
    struct Sphere {
        Vec3 center;
        float radius;
    };
    AnalyticCaster(std::vector<Box> boxes, std::vector<Sphere> spheres)
        : boxes_(std::move(boxes)), spheres_(std::move(spheres)) {}

    void intersect(std::span<const Ray> rays, std::span<Hit> hits, Coherence) const override {
        for (size_t i = 0; i < rays.size(); ++i) {
            hits[i] = {};
            for (uint32_t k = 0; k < boxes_.size() + spheres_.size(); ++k) {
                const double t = hit(k, rays[i]);
                if (t < hits[i].t) {
                    hits[i].t = float(t);
                    hits[i].mesh = k;
                    hits[i].triangle = 0;
                }
            }
        }
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded) const override {
        for (size_t i = 0; i < rays.size(); ++i) occluded[i] = blocked(rays[i]);
    }
    uint16_t occluded16(uint16_t mask, RayPacket16& p, Coherence) const override {
        uint16_t answer = 0;
        for (int i = 0; i < 16; ++i)
            if (mask >> i & 1)
                answer |=
                    uint16_t(blocked(
                        {{p.ox[i], p.oy[i], p.oz[i]}, p.t_min[i], {p.dx[i], p.dy[i], p.dz[i]}, p.t_max[i]}))
                    << i;
        return answer;
    }

private:
    bool blocked(const Ray& r) const {
        for (uint32_t k = 0; k < boxes_.size() + spheres_.size(); ++k)
            if (hit(k, r) < kInfinity) return true;
        return false;
    }
    double hit(uint32_t k, const Ray& r) const {
        return k < boxes_.size() ? hit_box(boxes_[k], r) : hit_sphere(spheres_[k - boxes_.size()], r);
    }
    static double hit_box(const Box& b, const Ray& r) {
        double enter = -kInfinity, leave = kInfinity;
        for (int a = 0; a < 3; ++a) {
            const double o = r.o[a], d = r.d[a], lo = b.lo[a], hi = b.hi[a];
            if (d == 0) {
                if (o < lo || o > hi) return kInfinity;
                continue;
            }
            const double t0 = (lo - o) / d, t1 = (hi - o) / d;
            enter = std::max(enter, std::min(t0, t1));
            leave = std::min(leave, std::max(t0, t1));
        }
        if (enter > leave) return kInfinity;
        for (double t : {enter, leave})
            if (t >= r.t_min && t <= r.t_max) return t;
        return kInfinity;
    }
    static double hit_sphere(const Sphere& s, const Ray& r) {
        const double x = double(r.o.x) - s.center.x, y = double(r.o.y) - s.center.y,
                     z = double(r.o.z) - s.center.z;
        const double dx = r.d.x, dy = r.d.y, dz = r.d.z, a = dx * dx + dy * dy + dz * dz;
        const double b = x * dx + y * dy + z * dz, c = x * x + y * y + z * z - double(s.radius) * s.radius;
        const double disc = b * b - a * c;
        if (disc < 0) return kInfinity;
        for (double root : {-std::sqrt(disc), std::sqrt(disc)}) {
            const double t = (-b + root) / a;
            if (t >= r.t_min && t <= r.t_max) return t;
        }
        return kInfinity;
    }

    std::vector<Box> boxes_;
    std::vector<Sphere> spheres_;
};

}  // namespace viscache::bindings
