#pragma once
// How much a record says about a point.
#include "viscache/math/vec.h"

namespace viscache {

/// θ of two unit normals; keeps its digits where acos of their product loses them.
inline float normal_angle(Vec3 a, Vec3 b) {
    if (a == b) return 0;  // what follows gives the same, slower
    return 2 * std::atan2(length(a - b), length(a + b));
}

/// [VisMap Eq. 9] w(d, θ) with t = d / d_max; falls at first with slope −1 over t, in the end slower.
inline float record_weight(float t, float theta, float lambda) {
    return (1 - theta / kPi) * (1 - t / (1 + lambda * t));
}

/// ŵ: Eq. 9 stretched from [w(d_max, θ_max), 1] to [0, 1].
class NormalizedWeight {
public:
    NormalizedWeight(float theta_max_rad, float lambda)
        : lambda_(lambda), least_(record_weight(1, theta_max_rad, lambda)) {}
    float least() const { return least_; }
    float operator()(float weight) const { return std::max(0.f, (weight - least_) / (1 - least_)); }
    float operator()(float t, float theta) const { return (*this)(record_weight(t, theta, lambda_)); }

private:
    float lambda_, least_;
};

/// w_g = 1 − |n·v|: records before or behind the plane of the point say less. v points to the record; it has
/// no direction where the two coincide, nearer than this share of d_max, and w_g is 1.
constexpr float kCoincident = 1e-6f;
inline float geometric_weight(Vec3 normal, Vec3 to_record, float distance, float d_max) {
    if (distance < kCoincident * d_max) return 1;
    return std::max(0.f, 1 - std::fabs(dot(normal, to_record)) / distance);
}

}  // namespace viscache
