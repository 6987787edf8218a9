#include "viscache/scene/coat.h"

#include <map>
#include <memory>
#include <mutex>
#include <tuple>
#include <vector>

#include "viscache/sampling/warp.h"

namespace viscache {

namespace {

constexpr int kNodes = 32;

struct Node {
    double x, weight;
};

/// Gauss–Legendre quadrature on [0, 1]: the zeros of the Legendre polynomial, by Newton's method.
std::vector<Node> gauss_legendre(int n) {
    std::vector<Node> nodes;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 8; ++step) {
            double below = 1, value = x;
            for (int k = 2; k <= n; ++k) {
                const double next = ((2 * k - 1) * x * value - (k - 1) * below) / k;
                below = value;
                value = next;
            }
            slope = n * (x * value - below) / (x * x - 1);
            x -= value / slope;
        }
        nodes.push_back({0.5 * (x + 1), 1 / ((1 - x * x) * slope * slope)});
    }
    return nodes;
}

float cosine_of(int step) { return std::max(1e-6f, float(step) / Coat::kSteps); }

/// Microfacets of a rough coat.
struct Microfacets {
    bool beckmann = false;
    float alpha = 0.1f;

    /// Smith's G1.
    float visible(float cos) const { return beckmann ? beckmann_g1(cos, alpha) : smith_g1(cos, alpha); }
};

/// The share of light from a direction that rough microfacets reflect or transmit once: the mean of `share`
/// over the normals that the direction sees.
template <class Share>
double over_normals(float cos, Microfacets m, const Share& share) {
    static const std::vector<Node> nodes = gauss_legendre(kNodes);
    const Vec3 wo{std::sqrt(1 - cos * cos), 0, cos};
    double sum = 0, total = 0;
    for (const Node& node : nodes)
        for (int j = 0; j < kNodes; ++j) {
            const float u = (float(j) + 0.5f) / kNodes;
            Vec3 h = sample_ggx_vndf(wo, m.alpha, {float(node.x), u});
            double weight = node.weight;
            if (m.beckmann) {
                // D cos is sampled; the normals are seen in proportion to D (wo · h)
                h = sample_beckmann(m.alpha, {float(node.x), u});
                weight *= double(std::max(0.f, dot(wo, h)) / h.z);
            }
            total += weight;
            if (dot(wo, h) > 0) sum += weight * share(wo, h);
        }
    return sum / total;
}

double rough_transmittance(float cos, float eta, Microfacets m) {
    return over_normals(cos, m, [&](Vec3 wo, Vec3 h) -> double {
        const auto through = refract(wo, h, 1 / eta);
        return through ? (1 - fresnel_dielectric(dot(wo, h), eta)) * m.visible(-through->z) : 0.f;
    });
}

double rough_reflectance(float cos, float eta, Microfacets m) {
    return over_normals(cos, m, [&](Vec3 wo, Vec3 h) -> double {
        return fresnel_dielectric(dot(wo, h), eta) * m.visible(2 * dot(wo, h) * h.z - wo.z);
    });
}

/// Diffuse reflectance of a smooth interface: fits of Egan and Hilgeman 1973 (index < 1) and of d'Eon and
/// Irving 2011, which Mitsuba uses.
double diffuse_fresnel(double eta) {
    if (eta < 1) return -1.4399 * eta * eta + 0.7099 * eta + 0.6681 + 0.0636 / eta;
    const double r = 1 / eta;
    return 0.919317 + r * (-3.4793 + r * (6.75335 + r * (-7.80989 + r * (4.98554 - r * 1.36881))));
}

/// Mitsuba's mean over the steps.
double rough_internal(float eta, Microfacets m) {
    double sum = 0;
    for (int i = 0; i <= Coat::kSteps; ++i)
        sum += rough_reflectance(cosine_of(i), 1 / eta, m) * double(cosine_of(i));
    return 2 * sum / (Coat::kSteps + 1);
}

/// 2 ∫ T(c) c dc of the function that is linear between the steps.
double mean_transmittance(const Coat& coat) {
    double sum = 0;
    for (int i = 0; i < Coat::kSteps; ++i) {
        const double a = double(coat.transmittance[i]), b = double(coat.transmittance[i + 1]);
        sum += (a * (3 * i + 1) + b * (3 * i + 2)) / 3;
    }
    return sum / (double(Coat::kSteps) * Coat::kSteps);
}

Coat make_coat(CoatKind kind, float eta, float roughness, bool nonlinear) {
    const bool rough = kind != CoatKind::kSmooth;
    const Microfacets m{kind == CoatKind::kBeckmann, roughness};
    Coat coat{.eta = eta, .nonlinear = nonlinear};
    for (int i = 0; i <= Coat::kSteps; ++i)
        coat.transmittance[i] = rough ? float(rough_transmittance(cosine_of(i), eta, m))
                                      : 1 - fresnel_dielectric(float(i) / Coat::kSteps, eta);
    const double mean = mean_transmittance(coat);
    const double internal = rough ? rough_internal(eta, m) : diffuse_fresnel(1 / double(eta));
    // A white base reflects what passes the coat, and no more: 0.1 % less than Mitsuba's fit at an index of
    // 1.5, a fifth less at 3, where the fit is poor
    coat.internal = float(std::min(internal, 1 - mean / (double(eta) * eta)));
    coat.mean = float(mean);
    return coat;
}

}  // namespace

Rgb coated_base(const Coat& coat, Rgb base) {
    const float scale = 1 / (coat.eta * coat.eta);
    const auto one = [&](float x) {
        return scale * x / (1 - coat.internal * (coat.nonlinear ? std::min(x, 1.f) : 1.f));
    };
    return {one(base.x), one(base.y), one(base.z)};
}

const Coat& coat_of(CoatKind kind, float eta, float roughness, bool nonlinear) {
    static std::mutex mutex;
    static std::map<std::tuple<CoatKind, float, float, bool>, std::unique_ptr<const Coat>> coats;
    const std::lock_guard lock(mutex);
    auto& coat = coats[{kind, eta, kind == CoatKind::kSmooth ? 0 : roughness, nonlinear}];
    if (!coat) coat = std::make_unique<const Coat>(make_coat(kind, eta, roughness, nonlinear));
    return *coat;
}

}  // namespace viscache
