#include "viscache/vismap/point_estimate.h"

namespace viscache {

namespace {

double luminance_of(const Rgbd& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

constexpr size_t kLeastForLeaveOneOut = 4;

}  // namespace

void PointEstimate::begin(const EnvironmentPyramid& light, const Reflection& reflection,
                          const BlendedMaps& maps, double eta) {
    light_ = &light;
    tree_.build(light, reflection, maps.m);
    integrals_ = {}, has_maps_ = maps.count > 0 && !dark(), guided_ = false;
    if (has_maps_) integrals_ = integrate_maps(tree_, maps, eta < 1, cells_);
    measure(integrals_.w2);
    if (eta < 1) reshape(eta);
}

void PointEstimate::reshape(double eta) {
    guided_ = has_maps_ && eta < 1 && shape_density(tree_, integrals_, cells_, eta, guide_);
    if (guided_)
        tree_.guide(guide_.d);
    else
        tree_.unguide();
    measure(guided_ ? guide_.w2 : integrals_.w2);
}

void PointEstimate::measure(double w2) {
    mean_w_ = variance_w_ = 0;
    if (!has_maps_) return;
    mean_w_ = luminance_of(integrals_.j_colour) / l_ns();
    const double mean = integrals_.j / l_ns();
    variance_w_ = std::max(0.0, w2 / l_ns() - mean * mean);
}

DirectionSample PointEstimate::complete(const ProductTree::Sample& s, Rgb b) const {
    DirectionSample out;
    out.wi = s.wi, out.texel = s.texel, out.d = density(s.texel);
    const Rgb light = light_->radiance(s.texel);
    // Light and B̃ cancel in luminance, what is left is their colour
    const double scale = l_ns() / (luminance_in_double(light) * double(s.b));
    const double v = visible(s.texel);
    for (int c = 0; c < 3; ++c) {
        const double colour = scale * double(light[c]);
        const ProductTerms t =
            product_terms(colour * double(b[c]), 1, colour * double(s.colour[c]) * v, out.d);
        out.f[size_t(c)] = t.z, out.g[size_t(c)] = t.w;
    }
    out.z = luminance_of(out.f) / l_ns(), out.w = luminance_of(out.g) / l_ns();
    out.matters = out.f[0] != 0 || out.f[1] != 0 || out.f[2] != 0;
    return out;
}

std::optional<double> PointEstimate::alpha(const AlphaChoice& choice, const AlphaSums& earlier) const {
    if (!has_maps_ || !(variance_w_ > kLeastVariance)) return 0;
    switch (choice.mode) {
        case AlphaMode::kFixed: return choice.value;
        case AlphaMode::kPreviousPass:
            return earlier.n > 0 ? regressed_alpha(earlier, variance_w_) : choice.value;
        case AlphaMode::kLeaveOneOut: return std::nullopt;
    }
    return 0;
}

namespace {

/// Every sample with the α of the others (`all` holds this pass alone).
Rgbd leave_one_out(const PointEstimate& point, std::span<const DirectionSample> samples,
                   std::span<const uint8_t> visible, const AlphaSums& all) {
    const double n = double(samples.size());
    Rgbd sum{};
    for (size_t i = 0; i < samples.size(); ++i) {
        const DirectionSample& s = samples[i];
        const double z = visible[i] ? s.z : 0,
                     alpha = samples.size() < kLeastForLeaveOneOut
                                 ? 1
                                 : regressed_alpha(all.without(z - point.mean_w(), s.w - point.mean_w()),
                                                   point.variance_w());
        for (size_t c = 0; c < 3; ++c)
            sum[c] += control_variate_estimate(visible[i] ? s.f[c] : 0, s.g[c], point.j()[c], alpha, 1) / n;
    }
    return sum;
}

}  // namespace

Rgbd finish_pass(const PointEstimate& point, std::span<const DirectionSample> samples,
                 std::span<const uint8_t> visible, const AlphaChoice& choice, AlphaSums& earlier) {
    AlphaSums now;
    Rgbd f{}, g{};
    for (size_t i = 0; i < samples.size(); ++i) {
        const DirectionSample& s = samples[i];
        for (size_t c = 0; c < 3; ++c) f[c] += visible[i] ? s.f[c] : 0, g[c] += s.g[c];
        now.add((visible[i] ? s.z : 0) - point.mean_w(), s.w - point.mean_w());
    }
    Rgbd estimate{};
    if (const std::optional<double> alpha = point.alpha(choice, earlier)) {
        for (size_t c = 0; c < 3; ++c)
            estimate[c] = control_variate_estimate(f[c], g[c], point.j()[c], *alpha, double(samples.size()));
    } else {
        estimate = leave_one_out(point, samples, visible, now);
    }
    earlier.merge(now);
    return estimate;
}

}  // namespace viscache
