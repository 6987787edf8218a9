#include "viscache/render/local_samples.h"

#include "viscache/render/eye_samples.h"
#include "viscache/render/shared_sky.h"
#include "viscache/sampling/hemisphere_batch.h"
#include "viscache/sampling/sphere_batch.h"
#include "viscache/scene/lobes.h"

namespace viscache {

bool WeightedSamples::add(Vec3 to, Rgb value, float density, float light_density, Counters& counters) {
    if (!is_finite(value)) {
        ++counters.non_finite;
        return false;
    }
    // A sample that brings nothing needs no ray, and counts as a sample all the same: its share is
    // in the divisor of the others
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

/// Samples of the environment from one eye point, of both techniques: f·cos·L / Σ_t n_t p_t (balance
/// heuristic). They wait until vectors are full.
class SkySamples {
public:
    // As many as a batch of directions has, a multiple of the sixteen of a vector
    static constexpr size_t kSize = HemisphereBatch::kSize;

    SkySamples(const EnvironmentMap& env, const ShadingPoint& point, const LobeConstants& lobe,
               Rgb throughput, float n_light, float n_brdf, WeightedSamples& out, Counters& counters)
        : env_(env),
          point_(point),
          lobe_(lobe),
          throughput_(throughput),
          n_light_(n_light),
          n_brdf_(n_brdf),
          out_(out),
          counters_(counters) {}

    bool black() const { return lobe_.black; }

    /// n directions drawn by the radiance of the environment.
    void add_light_samples(const EyeSamples& numbers, int n) {
        Vec2 points[kSize];
        EnvironmentMap::Sample drawn[kSize];
        alignas(64) float x[kSize], y[kSize], z[kSize];
        for (int first = 0; first < n; first += int(kSize)) {
            const size_t count = std::min(kSize, size_t(n - first));
            // A constant sky needs no table: even directions of the sphere, made in SIMD
            if (env_.is_constant()) {
                sphere_batch(numbers.sx, numbers.sy, numbers.first + uint32_t(first), whole(count), x, y, z);
                for (size_t i = 0; i < count; ++i) put({{x[i], y[i], z[i]}, env_.eval({}), env_.pdf({})});
            } else {
                // The map's tables are walked for many points at once
                for (size_t i = 0; i < count; ++i) points[i] = numbers.position(first + int(i));
                env_.sample({points, count}, {drawn, count});
                for (size_t i = 0; i < count; ++i) put(drawn[i]);
            }
        }
    }

    /// n directions drawn by the BRDF.
    void add_brdf_samples(const EyeSamples& numbers, int n) {
        // A diffuse surface: its BRDF is constant, so the cosine is the whole density, and
        // directions come in SIMD
        const HemisphereSequence cosines{numbers.sx, numbers.sy, frame_around(point_.ns), true};
        HemisphereBatch drawn;
        Vec3 wi[kSize];
        EnvironmentMap::Sample light[kSize];
        for (int first = 0; first < n; first += int(kSize)) {
            const int last = std::min(n, first + int(kSize));
            size_t count = 0;
            if (!lobe_.glossy) {
                hemisphere_batch(cosines, numbers.first + uint32_t(first), uint32_t(last - first), drawn);
                for (; count < size_t(last - first); ++count)
                    wi[count] = {drawn.x[count], drawn.y[count], drawn.z[count]};
            } else {
                for (int i = first; i < last; ++i) {
                    // A sharp lobe beside shared directions (`sharp_lobe`) has a share of 1:
                    // nothing to choose
                    const float u_lobe = lobe_.share < 1 ? numbers.choice(i) : 0;  // 0 chooses the lobe
                    if (const auto s = sample_bsdf(point_, u_lobe, numbers.position(i))) wi[count++] = s->wi;
                }
            }
            // Radiance and the density of light sampling of these directions, for the balance
            // heuristic
            env_.look_up({wi, count}, {light, count});
            for (size_t i = 0; i < count; ++i) put(light[i]);
        }
    }

    /// Adds the samples that wait, if they contribute.
    void flush() {
        if (size_ == 0) return;
        reflect_directions(lobe_, {x_, y_, z_, r_, g_, b_, pdf_brdf_}, whole(size_));
        // Without light samples there is still a density of cells: as if the directions of the BRDF
        // had been drawn by light
        const float n_cells = n_light_ > 0 ? n_light_ : n_brdf_;
        // Room for all, then each is put or skipped without a branch: which ones count is hard to
        // predict
        out_.at.make_room(size_);
        out_.contribution.resize(out_.at.room());
        for (size_t i = 0; i < size_; ++i) {
            // Balance heuristic: Σ_t n_t p_t, whichever technique drew it
            const float density = n_light_ * pdf_light_[i] + n_brdf_ * pdf_brdf_[i];
            const Rgb value = throughput_ * Rgb{r_[i], g_[i], b_[i]} * radiance_[i] * (1 / density);
            const float sum = value.x + value.y + value.z;
            out_.contribution[out_.at.next()] = value;
            // `sum − sum` is 0 for finite numbers alone. Unlit samples are dropped without being
            // counted as not finite: 0/0 where both densities vanish is no error
            const bool lit = r_[i] + g_[i] + b_[i] > 0 && density > 0, finite = sum - sum == 0;
            out_.at.put({x_[i], y_[i], z_[i]}, density, n_cells * pdf_light_[i], lit && finite && sum > 0);
            counters_.non_finite += lit && !finite;
        }
        out_.at.trim();
        out_.contribution.resize(out_.at.size());
        size_ = 0;
    }

private:
    static constexpr size_t whole(size_t n) { return (n + 15) / 16 * 16; }

    void put(const EnvironmentMap::Sample& s) {
        // Samples of both techniques fill the same vectors, so the last one of a technique is not
        // half empty
        if (size_ == kSize) flush();
        x_[size_] = s.wi.x;
        y_[size_] = s.wi.y;
        z_[size_] = s.wi.z;
        radiance_[size_] = s.radiance;
        pdf_light_[size_] = s.pdf;
        ++size_;
    }

    const EnvironmentMap& env_;
    const ShadingPoint& point_;
    const LobeConstants lobe_;
    const Rgb throughput_;
    const float n_light_, n_brdf_;
    WeightedSamples& out_;
    Counters& counters_;

    size_t size_ = 0;
    // Lanes without a sample are zero or old
    alignas(64) float x_[kSize] = {}, y_[kSize] = {}, z_[kSize] = {};
    alignas(64) float r_[kSize], g_[kSize], b_[kSize], pdf_brdf_[kSize];  ///< f·cos, and the BRDF's density
    Rgb radiance_[kSize];
    float pdf_light_[kSize];
};

}  // namespace

void add_environment_samples(const EyePathTracer& frame, const EyeTile& eyes, uint32_t eye,
                             WeightedSamples& out, Counters& counters) {
    const ShadingPoint& point = eyes.shading[eye];
    if (is_black(point)) return;
    const int n_light = frame.integrator.n_environment, n_brdf = frame.integrator.n_brdf;
    const uint64_t seed = frame.frame.seed;
    // Both techniques go through one buffer; their random numbers have purposes of their own
    SkySamples samples(*frame.scene.environment(), point, lobe_constants(point), eyes.throughput[eye],
                       float(n_light), float(n_brdf), out, counters);
    if (!samples.black()) {
        samples.add_light_samples(EyeSamples(seed, Purpose::kEnvironmentLight, eyes, eye, n_light), n_light);
        samples.add_brdf_samples(EyeSamples(seed, Purpose::kBrdf, eyes, eye, n_brdf), n_brdf);
        samples.flush();
    }
    out.at.close(eye);
}

void add_lobe_samples(const EyePathTracer& frame, const EyeTile& eyes, uint32_t eye, WeightedSamples& out,
                      Counters& counters) {
    if (!has_lobe(eyes.shading[eye])) return;
    const IntegratorSettings& settings = frame.integrator;
    const int sets = settings.interleave;
    // The set that this eye point asks of the shared directions decides how many samples of the
    // lobe stand beside it
    const size_t set = sets > 1 ? eyes.block.turn[eye] % size_t(sets) : 0;
    const int n_light = set_size(settings.n_environment, sets, set), n = set_size(settings.n_brdf, sets, set);
    const LobeConstants lobe = sharp_lobe(eyes.shading[eye]);
    // Broad lobes are served well by the shared directions alone
    if (lobe.share > 0 && n > 0) {
        SkySamples samples(*frame.scene.environment(), eyes.shading[eye], lobe, eyes.throughput[eye],
                           float(n_light), float(n), out, counters);
        // Blocks of the sequence have the largest size of a set, so that those of a pixel never
        // overlap
        const EyeSamples numbers(frame.frame.seed, Purpose::kBrdf, eyes, eye, most_lobe_samples(settings));
        samples.add_brdf_samples(numbers, n);
        samples.flush();
    }
    out.at.close(eye);
}

void add_ambient_samples(const EyePathTracer& frame, const EyeTile& eyes, uint32_t eye, WeightedSamples& out,
                         Counters&) {
    const IntegratorSettings& settings = frame.integrator;
    const EyeSamples samples(frame.frame.seed, Purpose::kAmbient, eyes, eye, settings.n_ambient);
    const bool by_cosine = settings.ambient_distribution == AmbientDistribution::kCosine;
    // Around the geometric normal: ambient occlusion shows geometry, not shading
    const HemisphereSequence sequence{samples.sx, samples.sy, frame_around(eyes.block.normal[eye]),
                                      by_cosine};
    const float n = float(settings.n_ambient);
    out.at.t_max = settings.ambient_reach.distance > 0 ? float(settings.ambient_reach.distance) : kInfinity;
    HemisphereBatch batch;
    for (uint32_t i = 0; i < uint32_t(settings.n_ambient); ++i) {
        const uint32_t k = i % HemisphereBatch::kSize;
        if (k == 0)
            hemisphere_batch(sequence, samples.first + i,
                             std::min(uint32_t(settings.n_ambient) - i, HemisphereBatch::kSize), batch);
        // Directions in the horizon by rounding have no density
        const float cosine = batch.cosine[k];
        if (!(cosine > 0)) continue;
        const float pdf = by_cosine ? cosine / kPi : 0.5f / kPi;
        // cosθ/π over the density: the estimate of 1/π ∫ V cosθ
        const float weight = by_cosine ? 1.f : 2 * cosine;
        const Vec3 wi{batch.x[k], batch.y[k], batch.z[k]};
        // Cells have even density over the hemisphere, whatever the distribution: a density with
        // the cosine would depend on the normal
        out.at.add(wi, n * pdf, n * (0.5f / kPi));
        out.contribution.push_back(eyes.throughput[eye] * (weight / n));
    }
    out.at.close(eye);
}

}  // namespace viscache
