#include "viscache/render/local_samples.h"

#include "viscache/render/light_sampling.h"
#include "viscache/sampling/hemisphere_batch.h"
#include "viscache/sampling/low_discrepancy.h"
#include "viscache/sampling/rng.h"

namespace viscache {

bool WeightedSamples::add(Vec3 to, Rgb value, float density, float light_density, Counters& counters) {
    if (!is_finite(value)) {
        ++counters.non_finite;
        return false;
    }
    if (!(max_component(value) > 0)) return false;
    at.add(to, density, light_density), contribution.push_back(value);
    return true;
}

ShadowQuery query_towards(uint32_t eye, Vec3 direction, LightGroup group, float density, float t_max) {
    ShadowQuery q;
    q.eye = eye, q.semantic = Semantic::kSolidAngle, q.group = uint8_t(group);
    q.far = direction, q.density = density, q.t_max = t_max;
    return q;
}

namespace {

/// Randomised low-discrepancy samples keyed by one eye point and purpose: a (0,2)-sequence for positions, and
/// beside it one number each for choices, in a shuffled order: else choice and position would go hand in
/// hand.
struct EyeSamples {
    uint32_t sx, sy, choice_scramble, choice_shuffle;
    EyeSamples(uint64_t seed, Purpose purpose, uint64_t stream) {
        Rng rng(seed, purpose, stream, 0);
        sx = rng.next_u32(), sy = rng.next_u32(), choice_scramble = rng.next_u32(),
        choice_shuffle = rng.next_u32();
    }
    Vec2 position(int i) const { return sobol02(uint32_t(i), sx, sy); }
    float choice(int i) const {
        return sobol02(owen_scramble(uint32_t(i), choice_shuffle), choice_scramble, 0).x;
    }
};

}  // namespace

void add_area_samples(const Scene& scene, const EyeTile& eyes, uint32_t eye,
                      const IntegratorSettings& settings, uint64_t seed, WeightedSamples& out,
                      Counters& counters) {
    const EyeSamples samples(seed, Purpose::kAreaLight, eyes.stream[eye]);
    const ShadingPoint& sp = eyes.shading[eye];
    const Vec3 x = eyes.block.position[eye];
    const int n = settings.n_area;
    for (int i = 0; i < n; ++i) {
        const auto y = sample_area_light(scene, x, samples.choice(i), samples.position(i));
        if (!y) continue;
        const Vec3 d = y->point - x;
        const float d2 = length2(d);
        const Vec3 wi = d / std::sqrt(d2);
        const float cos_x = dot(sp.ns, wi), cos_y = -dot(y->normal, wi);
        if (!(cos_x > 0 && dot(sp.ng, wi) > 0 && cos_y > 0)) continue;
        const Rgb value = eyes.throughput[eye] * eval_bsdf(sp, wi) * y->radiance *
                          (cos_x * cos_y / (d2 * y->pdf_area * float(n)));
        if (out.add(y->point, value, float(n) * y->pdf_area, float(n) * y->pdf_even, counters))
            out.at.normal.push_back(y->normal), out.at.ray_end.push_back(y->ray_end);
    }
    out.at.close(eye);
}

void add_environment_samples(const Scene& scene, const EyeTile& eyes, uint32_t eye,
                             const IntegratorSettings& settings, uint64_t seed, WeightedSamples& out,
                             Counters& counters) {
    const EnvironmentMap& env = *scene.environment();
    const ShadingPoint& sp = eyes.shading[eye];
    const Rgb throughput = eyes.throughput[eye];
    const float n_light = float(settings.n_environment), n_brdf = float(settings.n_brdf);
    const float n_cells = n_light > 0 ? n_light : n_brdf;
    // Balance heuristic: both techniques share f·cos·L / Σ_t n_t p_t.
    auto add = [&](Vec3 wi, Rgb radiance, float pdf_light, float pdf_brdf, float p_even) {
        const float cos = dot(sp.ns, wi);
        if (!(cos > 0 && dot(sp.ng, wi) > 0)) return;
        const float density = n_light * pdf_light + n_brdf * pdf_brdf;
        out.add(wi, throughput * eval_bsdf(sp, wi) * radiance * (cos / density), density, n_cells * p_even,
                counters);
    };
    const EyeSamples light(seed, Purpose::kEnvironmentLight, eyes.stream[eye]);
    constexpr int kBatch = 32;
    Vec2 points[kBatch];
    EnvironmentMap::Sample drawn[kBatch];
    for (int first = 0; first < settings.n_environment; first += kBatch) {
        const size_t count = size_t(std::min(kBatch, settings.n_environment - first));
        for (size_t i = 0; i < count; ++i) points[i] = light.position(first + int(i));
        env.sample({points, count}, {drawn, count});
        for (const auto& s : std::span(drawn, count))
            if (s.pdf > 0) add(s.wi, s.radiance, s.pdf, n_brdf > 0 ? pdf_bsdf(sp, s.wi) : 0.f, s.pdf);
    }
    const EyeSamples brdf(seed, Purpose::kBrdf, eyes.stream[eye]);
    Vec3 wi[kBatch];
    float pdf[kBatch];
    for (int first = 0; first < settings.n_brdf; first += kBatch) {
        size_t count = 0;
        for (int i = first; i < std::min(settings.n_brdf, first + kBatch); ++i) {
            const auto s = sample_bsdf(sp, brdf.choice(i), brdf.position(i));
            if (s && s->pdf > 0) wi[count] = s->wi, pdf[count++] = s->pdf;
        }
        env.look_up({wi, count}, {drawn, count});
        for (size_t i = 0; i < count; ++i)
            add(wi[i], drawn[i].radiance, n_light > 0 ? drawn[i].pdf : 0.f, pdf[i], drawn[i].pdf);
    }
    out.at.close(eye);
}

void add_ambient_samples(const EyeTile& eyes, uint32_t eye, const IntegratorSettings& settings, uint64_t seed,
                         WeightedSamples& out) {
    const EyeSamples samples(seed, Purpose::kAmbient, eyes.stream[eye]);
    const HemisphereSequence sequence{samples.sx, samples.sy, frame_around(eyes.block.normal[eye]),
                                      settings.ambient_cosine};
    const float n = float(settings.n_ambient);
    out.at.t_max = settings.ambient_max_distance > 0 ? settings.ambient_max_distance : kInfinity;
    HemisphereBatch batch;
    for (uint32_t i = 0; i < uint32_t(settings.n_ambient); ++i) {
        const uint32_t k = i % HemisphereBatch::kSize;
        if (k == 0) hemisphere_batch(sequence, i, batch);
        const float cosine = batch.cosine[k];
        if (!(cosine > 0)) continue;
        const float pdf = settings.ambient_cosine ? cosine / kPi : 0.5f / kPi;
        const float weight = settings.ambient_cosine ? 1.f : 2 * cosine;
        const Vec3 wi{batch.x[k], batch.y[k], batch.z[k]};
        out.at.add(wi, n * pdf, n * (0.5f / kPi));
        out.contribution.push_back(eyes.throughput[eye] * (weight / n));
    }
    out.at.close(eye);
}

}  // namespace viscache
