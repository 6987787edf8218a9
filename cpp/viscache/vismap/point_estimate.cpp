#include "viscache/vismap/point_estimate.h"

namespace viscache {

namespace {

double luminance_of(const Rgbd& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

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
    moments_.mean_w = luminance_of(integrals_.j_colour) / moments_.l_ns;
    const double mean = integrals_.j / moments_.l_ns;
    moments_.variance_w = std::max(0.0, w2 / moments_.l_ns - mean * mean);
}

DirectionSample PointEstimate::complete(const ProductTree::Sample& s, Rgb b) const {
    DirectionSample out;
    out.wi = s.wi;
    out.texel = s.texel;
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
    out.matters = out.f[0] != 0 || out.f[1] != 0 || out.f[2] != 0;
    return out;
}

std::optional<double> alpha_of_pass(const PointMoments& point, const AlphaChoice& choice,
                                    const AlphaSums& earlier) {
    if (!(point.variance_w > kLeastVariance)) return 0;
    switch (choice.mode) {
        case AlphaMode::kFixed: return choice.value;
        case AlphaMode::kPreviousPass:
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
