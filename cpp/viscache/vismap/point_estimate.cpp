#include "viscache/vismap/point_estimate.h"

namespace viscache {

namespace {

/// Rec. 709, in double: `luminance_in_double` for channels that are already doubles.
double luminance_of(const Rgbd& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

/// With fewer samples, regression without one of them means nothing, and α is 1.
constexpr size_t kLeastForLeaveOneOut = 4;

}  // namespace

void PointEstimate::begin(const EnvironmentPyramid& light, const Reflection& reflection, int m) {
    light_ = &light;
    has_maps_ = false;
    integrals_ = {};
    tree_.build(light, reflection, m);
    measure(0);
}

void PointEstimate::look(const BlendedMaps& maps, bool with_dilated) {
    // A density belongs to the maps that have shaped it.
    tree_.unguide();
    has_maps_ = maps.count > 0 && !dark();
    integrals_ = has_maps_ ? integrate_maps(tree_, maps, with_dilated, cells_) : MapIntegrals{};
    measure(integrals_.w2);
}

bool PointEstimate::guide(double eta, bool apply) {
    if (!has_maps_ || !shape_density(tree_, integrals_, cells_, eta, guide_)) return false;
    if (apply) {
        tree_.guide(guide_.d);
        measure(guide_.w2);
    }
    return true;
}

void PointEstimate::measure(double w2) {
    moments_ = {.l_ns = tree_.total(), .j = integrals_.j_colour};
    if (!has_maps_) return;
    // Samples take W as a luminance of colours (`complete`), and so must its mean. The second moment uses the
    // masses of luminance, as the density does; both agree where light and reflection each have one colour.
    moments_.mean_w = luminance_of(integrals_.j_colour) / moments_.l_ns;
    // Var W = E[W²] − μ_W², exact over the cells. Rounding may make it slightly negative.
    const double mean = integrals_.j / moments_.l_ns;
    moments_.variance_w = std::max(0.0, w2 / moments_.l_ns - mean * mean);
}

/// Eq. 3 per channel. With λ = Y · Δω, luminance times solid angle, a texel has the probability λ·b·D/L_ns;
/// so f = L·B·Δω / probability = L_ns · (L_c / Y) · (B_c / b) / D.
DirectionSample PointEstimate::complete(const ProductTree::Sample& s, Rgb b) const {
    DirectionSample out;
    out.wi = s.wi;
    out.texel = s.texel;
    // D, B̃ and Ṽ come from the tables that made the density. Unbiasedness needs exactly the same numbers
    // here.
    out.d = density(s.texel);
    const Rgb light = light_->radiance(s.texel);
    // Light and B̃ cancel in luminance; their chromaticity remains
    const double l_ns = moments_.l_ns, scale = l_ns / (luminance_in_double(light) * double(s.b));
    const double v = visible(s.texel);
    for (int c = 0; c < 3; ++c) {
        const double colour = scale * double(light[c]);
        const ProductTerms t =
            product_terms(colour * double(b[c]), 1, colour * double(s.colour[c]) * v, out.d);
        out.f[size_t(c)] = t.z;
        out.g[size_t(c)] = t.w;
    }
    out.z = luminance_of(out.f) / l_ns;
    out.w = luminance_of(out.g) / l_ns;
    // If no channel of f is positive, the ray is not needed: visible or not, the contribution is 0.
    out.matters = out.f[0] != 0 || out.f[1] != 0 || out.f[2] != 0;
    return out;
}

std::optional<double> alpha_of_pass(const PointMoments& point, const AlphaChoice& choice,
                                    const AlphaSums& earlier) {
    // W is constant over the cells, and so cannot explain any variance.
    if (!(point.variance_w > kLeastVariance)) return 0;
    switch (choice.mode) {
        case AlphaMode::kFixed: return choice.value;
        case AlphaMode::kPreviousPass:
            // The first pass has no past.
            return earlier.n > 0 ? regressed_alpha(earlier, point.variance_w) : choice.value;
        case AlphaMode::kLeaveOneOut: return std::nullopt;
    }
    return 0;
}

namespace {

/// Uses for every sample the α of the other samples (`all` holds only this pass).
Rgbd leave_one_out(const PointMoments& point, std::span<const DirectionSample> samples,
                   std::span<const uint8_t> visible, const AlphaSums& all) {
    const double n = double(samples.size());
    Rgbd sum{};
    for (size_t i = 0; i < samples.size(); ++i) {
        // n = 1: every sample has its own α, and the estimates of single samples are averaged.
        const DirectionSample& s = samples[i];
        const double z = visible[i] ? s.z : 0,
                     alpha = samples.size() < kLeastForLeaveOneOut
                                 ? 1
                                 : regressed_alpha(all.without(z - point.mean_w, s.w - point.mean_w),
                                                   point.variance_w);
        for (size_t c = 0; c < 3; ++c)
            sum[c] += control_variate_estimate(visible[i] ? s.f[c] : 0, s.g[c], point.j[c], alpha, 1) / n;
    }
    return sum;
}

}  // namespace

///
///     α from earlier passes  ->  estimate of this pass  ->  this pass joins the earlier ones
///
/// In this order α never depends on the samples to which it is applied, and the estimate stays unbiased.
Rgbd finish_pass(const PointMoments& point, std::span<const DirectionSample> samples,
                 std::span<const uint8_t> visible, const AlphaChoice& choice, AlphaSums& earlier) {
    AlphaSums now;
    Rgbd f{}, g{};
    for (size_t i = 0; i < samples.size(); ++i) {
        const DirectionSample& s = samples[i];
        for (size_t c = 0; c < 3; ++c) {
            f[c] += visible[i] ? s.f[c] : 0;
            g[c] += s.g[c];
        }
        // Regression is of luminances: one α for all channels.
        now.add((visible[i] ? s.z : 0) - point.mean_w, s.w - point.mean_w);
    }
    Rgbd estimate{};
    if (const std::optional<double> alpha = alpha_of_pass(point, choice, earlier)) {
        for (size_t c = 0; c < 3; ++c)
            estimate[c] = control_variate_estimate(f[c], g[c], point.j[c], *alpha, double(samples.size()));
    } else {
        estimate = leave_one_out(point, samples, visible, now);
    }
    earlier.merge(now);
    return estimate;
}

}  // namespace viscache
