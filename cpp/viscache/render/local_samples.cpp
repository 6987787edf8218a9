#include "viscache/render/local_samples.h"

#include "viscache/render/eye_samples.h"
#include "viscache/sampling/hemisphere_batch.h"
#include "viscache/sampling/sphere_batch.h"
#include "viscache/scene/lobes.h"

namespace viscache {

bool WeightedSamples::add(Vec3 to, Rgb value, float density, float light_density, Counters& counters) {
    if (!is_finite(value)) {
        ++counters.non_finite;
        return false;
    }
    if (!(max_component(value) > 0)) return false;
    at.add(to, density, light_density);
    contribution.push_back(value);
    return true;
}

ShadowQuery query_towards(uint32_t eye, Vec3 direction, LightGroup group, float density, float t_max) {
    ShadowQuery q;
    q.eye = eye;
    q.semantic = Semantic::kSolidAngle;
    q.group = uint8_t(group);
    q.far = direction;
    q.density = density;
    q.t_max = t_max;
    return q;
}

namespace {

/// Directions of one eye point and their data, as arrays for SIMD.
struct SkyBatch {
    static constexpr size_t kSize = HemisphereBatch::kSize;
    alignas(64) float x[kSize], y[kSize], z[kSize];
    alignas(64) float r[kSize], g[kSize], b[kSize], pdf_brdf[kSize];  ///< f·cos, and the density of the BRDF
    Rgb radiance[kSize];
    float pdf_light[kSize];
};

/// Samples of both techniques have the value f·cos·L / Σ_t n_t p_t (balance heuristic).
struct SkySampler {
    const EnvironmentMap& env;
    const LobeConstants lobe;
    Rgb throughput;
    float n_light, n_brdf;

    /// Adds those of the first n samples of the batch that contribute. Their directions and light must be
    /// set.
    void add(SkyBatch& s, size_t n, WeightedSamples& out, Counters& counters) const {
        const size_t whole = (n + 15) / 16 * 16;
        for (size_t i = n; i < whole; ++i) {
            s.x[i] = s.x[0];
            s.y[i] = s.y[0];
            s.z[i] = s.z[0];
        }
        reflect_directions(lobe, {s.x, s.y, s.z, s.r, s.g, s.b, s.pdf_brdf}, whole);
        const float n_cells = n_light > 0 ? n_light : n_brdf;
        out.at.make_room(n);
        out.contribution.resize(out.at.room());
        for (size_t i = 0; i < n; ++i) {
            const float density = n_light * s.pdf_light[i] + n_brdf * s.pdf_brdf[i];
            const Rgb value = throughput * Rgb{s.r[i], s.g[i], s.b[i]} * s.radiance[i] * (1 / density);
            const float sum = value.x + value.y + value.z;
            out.contribution[out.at.next()] = value;
            const bool lit = s.r[i] + s.g[i] + s.b[i] > 0 && density > 0, finite = sum - sum == 0;
            out.at.put({s.x[i], s.y[i], s.z[i]}, density, n_cells * s.pdf_light[i], lit && finite && sum > 0);
            counters.non_finite += lit && !finite;
        }
        out.at.trim();
        out.contribution.resize(out.at.size());
    }
};

/// Adds directions drawn by the radiance of the environment.
void add_light_samples(const SkySampler& sampler, const EyeSamples& numbers, int n, SkyBatch& batch,
                       WeightedSamples& out, Counters& counters) {
    Vec2 points[SkyBatch::kSize];
    EnvironmentMap::Sample drawn[SkyBatch::kSize];
    for (int first = 0; first < n; first += int(SkyBatch::kSize)) {
        const size_t count = std::min(SkyBatch::kSize, size_t(n - first));
        if (sampler.env.is_constant()) {
            sphere_batch(numbers.sx, numbers.sy, numbers.first + uint32_t(first), SkyBatch::kSize, batch.x,
                         batch.y, batch.z);
            std::fill_n(batch.radiance, count, sampler.env.eval({}));
            std::fill_n(batch.pdf_light, count, sampler.env.pdf({}));
        } else {
            for (size_t i = 0; i < count; ++i) points[i] = numbers.position(first + int(i));
            sampler.env.sample({points, count}, {drawn, count});
            for (size_t i = 0; i < count; ++i) {
                batch.x[i] = drawn[i].wi.x;
                batch.y[i] = drawn[i].wi.y;
                batch.z[i] = drawn[i].wi.z;
                batch.radiance[i] = drawn[i].radiance;
                batch.pdf_light[i] = drawn[i].pdf;
            }
        }
        sampler.add(batch, count, out, counters);
    }
}

/// Adds directions drawn by the BRDF.
void add_brdf_samples(const SkySampler& sampler, const ShadingPoint& sp, const EyeSamples& numbers, int n,
                      SkyBatch& batch, WeightedSamples& out, Counters& counters) {
    const HemisphereSequence cosines{numbers.sx, numbers.sy, frame_around(sp.ns), true};
    HemisphereBatch drawn;
    Vec3 wi[SkyBatch::kSize];
    EnvironmentMap::Sample light[SkyBatch::kSize];
    for (int first = 0; first < n; first += int(SkyBatch::kSize)) {
        const int last = std::min(n, first + int(SkyBatch::kSize));
        size_t count = 0;
        if (!sampler.lobe.glossy) {
            hemisphere_batch(cosines, numbers.first + uint32_t(first), drawn);
            for (; count < size_t(last - first); ++count)
                wi[count] = {drawn.x[count], drawn.y[count], drawn.z[count]};
        } else {
            for (int i = first; i < last; ++i)
                if (const auto s = sample_bsdf(sp, numbers.choice(i), numbers.position(i)))
                    wi[count++] = s->wi;
        }
        if (count == 0) continue;
        sampler.env.look_up({wi, count}, {light, count});
        for (size_t i = 0; i < count; ++i) {
            batch.x[i] = wi[i].x;
            batch.y[i] = wi[i].y;
            batch.z[i] = wi[i].z;
            batch.radiance[i] = light[i].radiance;
            batch.pdf_light[i] = light[i].pdf;
        }
        sampler.add(batch, count, out, counters);
    }
}

}  // namespace

void add_environment_samples(const Scene& scene, const EyeTile& eyes, uint32_t eye,
                             const IntegratorSettings& settings, uint64_t seed, WeightedSamples& out,
                             Counters& counters) {
    const EnvironmentMap& env = *scene.environment();
    const ShadingPoint& sp = eyes.shading[eye];
    const SkySampler sampler{env, lobe_constants(sp), eyes.throughput[eye], float(settings.n_environment),
                             float(settings.n_brdf)};
    if (!sampler.lobe.black) {
        SkyBatch batch;
        add_light_samples(sampler,
                          EyeSamples(seed, Purpose::kEnvironmentLight, eyes, eye, settings.n_environment),
                          settings.n_environment, batch, out, counters);
        add_brdf_samples(sampler, sp, EyeSamples(seed, Purpose::kBrdf, eyes, eye, settings.n_brdf),
                         settings.n_brdf, batch, out, counters);
    }
    out.at.close(eye);
}

void add_ambient_samples(const EyeTile& eyes, uint32_t eye, const IntegratorSettings& settings, uint64_t seed,
                         WeightedSamples& out) {
    const EyeSamples samples(seed, Purpose::kAmbient, eyes, eye, settings.n_ambient);
    const HemisphereSequence sequence{samples.sx, samples.sy, frame_around(eyes.block.normal[eye]),
                                      settings.ambient_cosine};
    const float n = float(settings.n_ambient);
    out.at.t_max = settings.ambient_max_distance > 0 ? settings.ambient_max_distance : kInfinity;
    HemisphereBatch batch;
    for (uint32_t i = 0; i < uint32_t(settings.n_ambient); ++i) {
        const uint32_t k = i % HemisphereBatch::kSize;
        if (k == 0) hemisphere_batch(sequence, samples.first + i, batch);
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
