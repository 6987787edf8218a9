// Samples of area lights: points on lights, and at glossy points also directions by the BRDF.
#include <algorithm>
#include <array>

#include "viscache/render/emitter_rays.h"
#include "viscache/render/eye_samples.h"
#include "viscache/render/light_choice.h"
#include "viscache/render/light_sampling.h"
#include "viscache/render/local_samples.h"
#include "viscache/scene/lobes.h"

namespace viscache {

namespace {

/// Samples of one eye point, weighted by the balance heuristic: f·cos·L / Σ_t n_t p_t. All densities are per
/// area of the light.
class AreaSampler {
public:
    AreaSampler(const Scene& scene, const EyeTile& eyes, uint32_t eye, const IntegratorSettings& settings,
                WeightedSamples& out, Counters& counters)
        : scene_(scene),
          sp_(eyes.shading[eye]),
          x_(eyes.block.position[eye]),
          origin_(eyes.block.origin[eye]),
          throughput_(eyes.throughput[eye]),
          // One choice serves both techniques: the density of a light that the BRDF found is that
          // with which light sampling would have chosen it
          lights_(scene, choice_way(scene.area_lights(), settings.n_area), {x_, sp_.ns}),
          n_light_(settings.n_area),
          n_brdf_(sp_.kind == MaterialKind::kGlossy ? settings.n_brdf : 0),
          out_(out),
          counters_(counters) {}

    void add_light_samples(const EyeSamples& numbers) {
        // Choices are made in blocks, because the light tree walks down once for all sorted numbers
        // of a block
        constexpr int kBlock = int(LightsAt::kMostPicks);
        std::array<double, size_t(kBlock)> u;
        std::array<LightPick, size_t(kBlock)> picks;
        for (int first = 0; first < n_light_; first += kBlock) {
            const int count = std::min(kBlock, n_light_ - first);
            for (int i = 0; i < count; ++i)
                u[size_t(i)] =
                    lights_.is_fine() ? numbers.fine_choice(first + i) : double(numbers.choice(first + i));
            lights_.pick({u.data(), size_t(count)}, picks);
            for (int i = 0; i < count; ++i) add_light_sample(picks[size_t(i)], numbers.position(first + i));
        }
        flush();
    }

    bool draws_by_brdf() const { return n_brdf_ > 0; }

    void add_brdf_samples(const EyeSamples& numbers) {
        for (int i = 0; i < n_brdf_; ++i) {
            const auto s = sample_bsdf(sp_, numbers.choice(i), numbers.position(i));
            if (!s) continue;
            // Against the lights alone: whether something else lies in front is the query that the
            // oracle gets
            const auto hit = nearest_emitter(scene_, {origin_, 0, s->wi, kInfinity});
            if (!hit) continue;
            const float cos_y = -dot(hit->normal, s->wi), d2 = length2(hit->point - x_);
            // The back of a light hides what is behind it and shines nothing
            if (!(cos_y > 0)) continue;
            const AreaSample y = area_sample_at(lights_, hit->light, hit->point, hit->normal, hit->weights);
            // From per steradian at the eye point to per area at the light
            const float geometry = cos_y / d2;
            // Σ_t n_t p_t: the denominator of the balance heuristic, the same whichever technique
            // drew the point
            const float density = float(n_light_) * y.pdf_area + float(n_brdf_) * s->pdf * geometry;
            const Rgb reflected = s->weight * s->pdf;  // f·cos
            keep(y, throughput_ * reflected * y.radiance * (geometry / density), density);
        }
    }

private:
    static constexpr size_t kBatch = 16;

    void add_light_sample(const LightPick& pick, Vec2 u) {
        const auto y = sample_area_light(lights_, pick, u);
        if (!y) return;
        const Vec3 d = y->point - x_;
        const float d2 = length2(d);
        const Vec3 wi = d / std::sqrt(d2);
        const float cos_x = dot(sp_.ns, wi), cos_y = -dot(y->normal, wi);
        // Light from below the true surface would leak through it where the shading normal leans
        // away
        if (!(cos_x > 0 && dot(sp_.ng, wi) > 0 && cos_y > 0)) return;
        // Only glossy points need the density of the BRDF, whose lobe is evaluated sixteen
        // directions at a time
        if (n_brdf_ > 0) return gather(*y, wi, cos_y / d2);
        // One technique: its weight is one
        const Rgb value = throughput_ * eval_bsdf(sp_, wi) * y->radiance *
                          (cos_x * cos_y / (d2 * y->pdf_area * float(n_light_)));
        keep(*y, value, float(n_light_) * y->pdf_area);
    }

    /// Stores a light sample until the reflection of a batch is computed.
    void gather(const AreaSample& y, Vec3 wi, float geometry) {
        wx_[gathered_] = wi.x;
        wy_[gathered_] = wi.y;
        wz_[gathered_] = wi.z;
        geometry_[gathered_] = geometry;
        points_[gathered_] = y;
        if (++gathered_ == kBatch) flush();
    }

    void flush() {
        // Also called after the last sample, for what is left of a batch
        if (gathered_ == 0) return;
        // Lanes without a sample get a direction that is valid, so that none traps or slows down
        for (size_t i = gathered_; i < kBatch; ++i) {
            wx_[i] = wx_[0];
            wy_[i] = wy_[0];
            wz_[i] = wz_[0];
        }
        // Made when it is first needed: many points see no light at all
        if (!lobe_) lobe_ = lobe_constants(sp_);
        reflect_directions(*lobe_, {wx_, wy_, wz_, r_, g_, b_, pdf_}, kBatch);
        for (size_t i = 0; i < gathered_; ++i) {
            const AreaSample& y = points_[i];
            // A light that the BRDF's rays cannot find has no second technique to share the weight
            // with
            const float found = can_be_hit(lights_.lights(), y.light) ? float(n_brdf_) * pdf_[i] : 0.f;
            const float density = float(n_light_) * y.pdf_area + found * geometry_[i];
            const Rgb reflected{r_[i], g_[i], b_[i]};
            keep(y, throughput_ * reflected * y.radiance * (geometry_[i] / density), density);
        }
        gathered_ = 0;
    }

    void keep(const AreaSample& y, Rgb value, float density) {
        // Cells of a cache must be equal at all eye points, so they take the density of the even
        // choice
        if (!out_.add(y.point, value, density, float(n_light_) * y.pdf_even, counters_)) return;
        out_.at.normal.push_back(y.normal);
        out_.at.ray_end.push_back(y.ray_end);
    }

    const Scene& scene_;
    const ShadingPoint& sp_;
    const Vec3 x_, origin_;
    const Rgb throughput_;
    const LightsAt lights_;
    const int n_light_, n_brdf_;
    WeightedSamples& out_;
    Counters& counters_;

    size_t gathered_ = 0;
    std::optional<LobeConstants> lobe_;
    alignas(64) float wx_[kBatch], wy_[kBatch], wz_[kBatch];
    alignas(64) float r_[kBatch], g_[kBatch], b_[kBatch], pdf_[kBatch];
    float geometry_[kBatch];
    std::array<AreaSample, kBatch> points_;
};

}  // namespace

int most_area_samples(const Scene& scene, const IntegratorSettings& settings) {
    // Bounds the queries of a batch: of scenes without glossy materials no BRDF samples count
    const auto glossy = [](const Material& m) { return m.kind == MaterialKind::kGlossy; };
    const bool any = std::any_of(scene.materials().begin(), scene.materials().end(), glossy);
    return settings.n_area + (any ? settings.n_brdf : 0);
}

void add_area_samples(const EyePathTracer& frame, const EyeTile& eyes, uint32_t eye, WeightedSamples& out,
                      Counters& counters) {
    if (is_black(eyes.shading[eye])) return;
    const IntegratorSettings& settings = frame.integrator;
    const uint64_t seed = frame.frame.seed;
    // Each technique has random numbers of its own purpose, so that neither follows the other
    AreaSampler sampler(frame.scene, eyes, eye, settings, out, counters);
    sampler.add_light_samples(EyeSamples(seed, Purpose::kAreaLight, eyes, eye, settings.n_area));
    if (sampler.draws_by_brdf())
        sampler.add_brdf_samples(EyeSamples(seed, Purpose::kAreaBrdf, eyes, eye, settings.n_brdf));
    out.at.close(eye);
}

}  // namespace viscache
