#pragma once
// Weight of a record at a point.
#include "viscache/math/vec.h"

namespace viscache {

/// Angle θ between two unit normals; accurate where the acos of their dot product is not.
inline float normal_angle(Vec3 a, Vec3 b) {
    if (a == b) return 0;  // a shortcut; the code below gives the same
    return 2 * std::atan2(length(a - b), length(a + b));
}

/// [VisMap Eq. 9] w(d, θ) with t = d / d_max. Its slope over t is −1 at first and flattens towards the end.
/// (1 − θ/π) is 0 for opposite normals; the second factor falls from 1 to λ/(1 + λ) at t = 1.
inline float record_weight(float t, float theta, float lambda) {
    return (1 - theta / kPi) * (1 - t / (1 + lambda * t));
}

/// ŵ: Eq. 9 rescaled from [w(d_max, θ_max), 1] to [0, 1].
class NormalizedWeight {
public:
    NormalizedWeight(float theta_max_rad, float lambda)
        : lambda_(lambda), least_(record_weight(1, theta_max_rad, lambda)) {}
    float least() const { return least_; }
    // At the limits, rounding could give less than 0.
    float operator()(float weight) const { return std::max(0.f, (weight - least_) / (1 - least_)); }
    float operator()(float t, float theta) const { return (*this)(record_weight(t, theta, lambda_)); }

private:
    float lambda_, least_;
};

/// w_g = 1 − |n·v|: records in front of or behind the tangent plane of the point weigh less. v points to the
/// record. If the two points coincide, nearer than this fraction of d_max, v has no direction and w_g is 1.
constexpr float kCoincident = 1e-6f;
inline float geometric_weight(Vec3 normal, Vec3 to_record, float distance, float d_max) {
    if (distance < kCoincident * d_max) return 1;
    // 0 for a record straight above the point, 1 for one in its tangent plane.
    return std::max(0.f, 1 - std::fabs(dot(normal, to_record)) / distance);
}

}  // namespace viscache
