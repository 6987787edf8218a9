#include "viscache/scene/spot_cone.h"

#include <cmath>

namespace viscache {

float spot_factor(const SpotCone& c, Vec3 away) {
    if (c.falloff == Falloff::kNone) return 1;
    const float cosine = dot(c.axis, away);
    if (cosine >= c.cos_inner) return 1;
    if (!(cosine > c.cos_outer)) return 0;
    const float t = (cosine - c.cos_outer) / (c.cos_inner - c.cos_outer);
    switch (c.falloff) {
        case Falloff::kAngle: {
            const float outer = std::acos(c.cos_outer);
            return (outer - std::acos(cosine)) / (outer - std::acos(c.cos_inner));
        }
        case Falloff::kQuadratic: return t * t;
        case Falloff::kQuartic: return t * t * (t * t);
        case Falloff::kSmooth: return t * t * (3 - 2 * t);
        case Falloff::kNone: break;
    }
    return 1;
}

double spot_integral(const SpotCone& c) {
    if (c.falloff == Falloff::kNone) return 4 * M_PI;
    const double inner = c.cos_inner, outer = c.cos_outer, between = inner - outer;
    double mean = 0;  // of the factor, over the solid angle between the two angles
    switch (c.falloff) {
        case Falloff::kAngle: {
            const double a = std::acos(inner), b = std::acos(outer);
            if (b > a) mean = (inner - (std::sin(b) - std::sin(a)) / (b - a)) / std::max(between, 1e-30);
            break;
        }
        case Falloff::kQuadratic: mean = 1. / 3; break;
        case Falloff::kQuartic: mean = 1. / 5; break;
        case Falloff::kSmooth: mean = 1. / 2; break;
        case Falloff::kNone: break;
    }
    return 2 * M_PI * (1 - inner + between * mean);
}

}  // namespace viscache
