#pragma once
// Control variates (VisMap Sec. 3): estimators, their variance, and coefficients α that keep them unbiased.
#include <algorithm>
#include <array>
#include <cmath>

namespace viscache {

using Rgbd = std::array<double, 3>;

/// [VisMap Eq. 2] One channel of the estimate from N samples. sum_f is the sum of f = L·B·V/p, sum_g that of
/// g = L·B̃·Ṽ/p, and J = ∫ L·B̃·Ṽ. Unbiased for every α that does not depend on these samples.
inline double control_variate_estimate(double sum_f, double sum_g, double j, double alpha, double n) {
    return (sum_f - alpha * sum_g) / n + alpha * j;
}

/// The two random variables; their difference is averaged.
struct ProductTerms {
    double z, w;
};
/// [VisMap Eq. 3] Under p = (L·B̃/L_ns)·D the light of the sample cancels: Z = (B/B̃)·V/D and W = Ṽ/D, and
/// the estimate is (L_ns/N) Σ (Z − αW) + αJ. D = 1 is the product sampling of the paper.
inline ProductTerms product_terms(double b_over_b_tilde, double visible, double approximate, double d) {
    return {b_over_b_tilde * visible / d, approximate / d};
}

/// [VisMap Eq. 4] Variance of Y = Z − αW.
// Differs (M1): the paper writes σ²_ZW for the covariance, which is not squared.
inline double residual_variance(double var_z, double var_w, double covariance, double alpha) {
    return var_z + alpha * alpha * var_w - 2 * alpha * covariance;
}
/// The α of least variance; 0 if W is constant.
inline double best_alpha(double var_w, double covariance) { return var_w > 0 ? covariance / var_w : 0; }
/// [VisMap Eq. 5] Variance of Y at the best α.
// Differs (M2): the paper says that the variance falls "by up to" the factor 1 − ρ²; it falls to that
// fraction.
inline double least_residual_variance(double var_z, double rho) { return var_z * (1 - rho * rho); }
/// [VisMap Eq. 6] Correlation of Z and W; 0 if one of them is constant.
inline double correlation(double var_z, double var_w, double covariance) {
    return var_z > 0 && var_w > 0 ? covariance / (std::sqrt(var_z) * std::sqrt(var_w)) : 0;
}

/// If the variance of W is below this, α = 0.
constexpr double kLeastVariance = 1e-12;
constexpr double kMostAlpha = 1.5;
/// Weight, in samples, of the prior that combines the exact variance of W with α = 1.
constexpr double kPriorSamples = 4;

/// Sums over samples of (z, w), both minus μ_W, for the regression of Z on W.
// Minus μ_W, which is known exactly: differences of nearly equal sums of squares would lose their digits.
struct AlphaSums {
    double n = 0, z = 0, w = 0, zw = 0, ww = 0;

    void add(double zc, double wc) {
        ++n;
        z += zc;
        w += wc;
        zw += zc * wc;
        ww += wc * wc;
    }
    void merge(const AlphaSums& b) {
        n += b.n;
        z += b.z;
        w += b.w;
        zw += b.zw;
        ww += b.ww;
    }
    /// The sums without one sample, for an α that does not depend on it (leave one out).
    AlphaSums without(double zc, double wc) const {
        return {n - 1, z - zc, w - wc, zw - zc * wc, ww - wc * wc};
    }
};

/// α by regression on samples other than those it is applied to. `var_w` is the exact variance of W; it
/// pulls α towards one while there are few samples.
inline double regressed_alpha(const AlphaSums& s, double var_w) {
    if (!(var_w > kLeastVariance)) return 0;
    // Regression over n samples, plus a prior of kPriorSamples samples in which Z = W. The exact Var(W) keeps
    // the quotient finite when the samples agree by chance.
    const double prior = kPriorSamples * var_w, mean = s.n > 0 ? 1 / s.n : 0;
    const double c = s.zw - s.z * s.w * mean, q = std::max(0.0, s.ww - s.w * s.w * mean);
    return std::clamp((c + prior) / (q + prior), 0.0, kMostAlpha);
}

}  // namespace viscache
