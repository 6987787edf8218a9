#include "viscache/render/vpl.h"

#include <array>

#include "viscache/render/light_sampling.h"
#include "viscache/render/scatter.h"
#include "viscache/sampling/rng.h"
#include "viscache/sampling/warp.h"

namespace viscache {

namespace {

// Chunks are the unit of work of threads, and candidates are joined in their order: the set is the
// same for any number of threads
constexpr size_t kPathsPerChunk = 256;
constexpr size_t kCandidatesPerChunk = 256;
constexpr size_t kPilotPaths = 4096;
// Where light hardly enters the scene, the number of paths must not grow without a bound
constexpr size_t kMaxPathsPerCandidate = 256;
constexpr double kFloor = 0.1;          // share of the probability that depends on flux only
constexpr float kCompatibleCos = 0.7f;  // normals within 45°

/// A photon: ray of a light path, and the flux it carries.
struct Photon {
    Ray ray;
    Rgb flux;
};

/// The point that a photon has hit. Normals are on its side.
struct Landing {
    const SurfacePoint& s;
    const Material& material;
    ShadingPoint sp;  ///< with the direction the photon came from, and normals on its side
    Vec3 ng, ns, wi;  ///< wi: direction the photon came from
    bool front;
};

/// Continues the photon. False if its flux is not finite.
bool leave(Photon& photon, const Landing& l, Vec3 side, Vec3 direction, Rgb flux, float extent) {
    // From the side on which the photon leaves, off the surface by more than rounding
    photon = {{spawn(l.s.position, side, extent), 0, direction, kInfinity}, flux};
    return is_finite(flux);
}

/// Reflects the photon by the rule of eye paths: with the shading normal, or with the geometric normal if the
/// shading normal would reflect below the surface.
bool mirror(Photon& photon, const Landing& l, Rgb factor, float extent) {
    Vec3 n = l.ns, direction = n * (2 * dot(l.wi, n)) - l.wi;
    // As in paths from the eye, so that both see the same mirror
    if (dot(direction, l.ng) <= 0) {
        n = l.ng;
        direction = n * (2 * dot(l.wi, n)) - l.wi;
    }
    return leave(photon, l, l.ng, normalize(direction),
                 photon.flux * factor * adjoint(n, l.ng, l.wi, direction), extent);
}

/// What a mirror reflects of a photon.
Rgb tint(const Landing& l, const Scene& scene) {
    return mirror_reflectance(l.material.specular, scene.metal(l.s.material), std::fabs(dot(l.wi, l.ns)));
}

/// Glass reflects or refracts at random. False where an eye path would end as well.
bool pass_glass(Photon& photon, const Landing& l, Rng& rng, float extent) {
    // One branch at random, with the probability of its share: in clear glass the photon keeps its flux
    const GlassShares shares = glass_shares(l.sp, dot(l.s.ns, l.wi));
    const float fresnel = max_component(shares.mirrored);
    if (rng.next() < fresnel) return mirror(photon, l, shares.mirrored / fresnel, extent);
    photon.flux = photon.flux * (shares.passed / (1 - fresnel));
    if (l.material.thin) return leave(photon, l, -l.ng, -l.wi, photon.flux, extent);
    const float eta = l.material.eta;
    const auto through = refract(l.wi, l.ns, l.front ? 1 / eta : eta);
    // The shading normal would bend it back to its own side
    if (!through || dot(*through, l.ng) >= 0) return false;
    return leave(photon, l, -l.ng, normalize(*through), photon.flux * adjoint(l.ns, l.ng, l.wi, *through),
                 extent);
}

/// Stores a VPL and continues in a cosine-distributed direction, with the probability of the albedo. VPLs do
/// not carry the glossy lobe: they reflect the rest diffusely.
bool reflect_diffusely(Photon& photon, const Landing& l, Rng& rng, std::vector<Vpl>& out, float extent) {
    const Rgb albedo = diffuse_albedo(l.sp);
    // Light arrives by the shading normal, flux by the geometric one: the quotient turns one into
    // the other
    const Rgb reflected = photon.flux * albedo * (dot(l.wi, l.ns) / dot(l.wi, l.ng));
    if (!(max_component(reflected) > 0) || !is_finite(reflected)) return false;
    // Over π: a Lambertian patch of this exitance
    out.push_back({l.s.position, l.ng, reflected / kPi});
    // Russian roulette by albedo: photons keep about the same flux. Below one, so that white scenes
    // end
    const float survive = std::min(0.95f, max_component(albedo));
    if (rng.next() >= survive) return false;
    const Vec3 local = square_to_cosine_hemisphere(rng.next2());
    return leave(photon, l, l.ng, frame_around(l.ng).to_world(local), reflected / survive, extent);
}

/// Follows one light path and stores a VPL at every diffuse bounce.
void trace_path(const Scene& scene, const RayCaster& caster, Photon photon, int max_depth, Rng& rng,
                std::vector<Vpl>& out, Counters& counters) {
    const float extent = scene.offset_extent();
    bool goes_on = true;
    for (int depth = 0; goes_on && depth < max_depth; ++depth) {
        Hit hit;
        caster.intersect({&photon.ray, 1}, {&hit, 1}, Coherence::kIncoherent);
        ++counters.light_rays;
        if (!hit.valid()) return;
        const SurfacePoint s = scene.surface(hit.mesh, hit.triangle,
                                             hit.instance == kNoHit ? -1 : int(hit.instance), hit.u, hit.v);
        // A degenerate triangle has no sides
        if (length2(s.ng) == 0) return;
        const Material& material = scene.materials()[size_t(s.material)];
        const bool front = dot(s.ng, photon.ray.d) < 0;
        // Backs of one-sided surfaces absorb
        if (!front && !material.two_sided && material.kind != MaterialKind::kDielectric) return;
        Landing l{
            s,    material, scene.reflection(s), front ? s.ng : -s.ng, front ? s.ns : -s.ns, -photon.ray.d,
            front};
        l.sp.ng = l.ng;
        l.sp.ns = l.ns;
        l.sp.wo = l.wi;
        switch (material.kind) {
            case MaterialKind::kMirror: goes_on = mirror(photon, l, tint(l, scene), extent); break;
            case MaterialKind::kDielectric: goes_on = pass_glass(photon, l, rng, extent); break;
            case MaterialKind::kDiffuse:
            case MaterialKind::kGlossy: {
                const float pass = pass_share(l.sp);
                if (pass > 0) {
                    const bool through = rng.next() < pass;
                    photon.flux = through ? photon.flux * (glass_shares(l.sp, dot(l.ns, l.wi)).passed / pass)
                                          : photon.flux / (1 - pass);
                    if (through) {
                        goes_on = leave(photon, l, -l.ng, -l.wi, photon.flux, extent);
                        break;
                    }
                }
                goes_on = reflect_diffusely(photon, l, rng, out, extent);
                break;
            }
        }
    }
}

/// VPLs of `paths` light paths. `pass` keys the random numbers.
std::vector<Vpl> trace_paths(const LightSampler& lights, const Scene& scene, const RayCaster& caster,
                             size_t paths, int max_depth, uint64_t seed, uint64_t pass, int threads,
                             Control& control, Counters& counters) {
    const size_t chunks = (paths + kPathsPerChunk - 1) / kPathsPerChunk;
    std::vector<std::vector<Vpl>> found(chunks);
    std::vector<Counters> counted(chunks);
    parallel_for(chunks, threads, [&](size_t chunk, int) {
        control.check();
        for (size_t i = chunk * kPathsPerChunk; i < std::min(paths, (chunk + 1) * kPathsPerChunk); ++i) {
            // Two streams: how many numbers a light takes to emit does not shift those of the
            // bounces
            Rng emission(seed, Purpose::kVplEmission, i, pass), bounce(seed, Purpose::kVplBounce, i, pass);
            const auto emitted = lights.emit(emission);
            if (!emitted) continue;
            // Each path carries its share, so the sum over all virtual lights is the estimate
            Photon photon{emitted->ray, emitted->flux / float(paths)};
            trace_path(scene, caster, photon, max_depth, bounce, found[chunk], counted[chunk]);
        }
    });
    std::vector<Vpl> all;
    for (size_t c = 0; c < chunks; ++c) {
        all.insert(all.end(), found[c].begin(), found[c].end());
        counters.merge(counted[c]);
    }
    return all;
}

}  // namespace

std::vector<Vpl> trace_vpls(const Scene& scene, const RayCaster& caster, size_t candidates, int max_depth,
                            uint64_t seed, int threads, Control& control, Counters& counters) {
    const LightSampler lights(scene);
    if (lights.empty() || candidates == 0) return {};
    // A pilot estimates how many VPLs a path leaves. There are few where light enters only through windows.
    // The VPLs of the pilot are dropped, so that the number of paths is independent of the paths that count.
    const auto pilot =
        trace_paths(lights, scene, caster, kPilotPaths, max_depth, seed, 0, threads, control, counters);
    // At least one, so that a dark pilot does not ask for endless paths
    const double per_path = std::max(double(pilot.size()), 1.0) / double(kPilotPaths);
    const double paths = std::min(std::ceil(double(candidates) / per_path),
                                  double(kMaxPathsPerCandidate) * double(candidates));
    return trace_paths(lights, scene, caster, size_t(paths), max_depth, seed, 1, threads, control, counters);
}

namespace {

/// First diffuse or glossy hits of stratified camera samples. The candidates are weighted at these points.
std::vector<EyeShade> judging_points(const Scene& scene, const RayCaster& caster, const FilmCamera& film,
                                     int count, uint64_t seed, std::vector<float>& albedo,
                                     Counters& counters) {
    // A grid of about square cells with one random point in each
    const int columns = std::max(1, int(std::lround(std::sqrt(double(count) * film.width / film.height))));
    const int rows = std::max(1, (count + columns - 1) / columns);
    std::vector<EyeShade> points;
    for (int i = 0; i < rows * columns; ++i) {
        Rng rng(seed, Purpose::kVplResampling, uint64_t(i), 1);
        const Vec2 u = rng.next2();
        const float x = (i % columns + u.x) / columns * film.width,
                    y = (i / columns + u.y) / rows * film.height;
        const Ray ray{film.origin(x, y), 0, normalize(film.direction(x, y)), kInfinity};
        Hit hit;
        // Few rays, once per frame: a packet would not pay for the code
        caster.intersect({&ray, 1}, {&hit, 1}, Coherence::kIncoherent);
        ++counters.light_rays;
        if (!hit.valid()) continue;
        const SurfacePoint s = scene.surface(hit.mesh, hit.triangle,
                                             hit.instance == kNoHit ? -1 : int(hit.instance), hit.u, hit.v);
        if (length2(s.ng) == 0) continue;
        // Normals on the side of the camera
        const float side = dot(s.ng, ray.d) < 0 ? 1.f : -1.f;
        points.push_back({s.position, s.ng * side, s.ns * side});
        // Black surfaces count a little: what they do not show, lobes on them may
        albedo.push_back(std::max(0.05f, luminance(s.base_color)));
    }
    return points;
}

/// Exact contributions of the candidates in [first, last) to those points. Returns the number of rays.
uint64_t judge(const std::vector<Vpl>& candidates, size_t first, size_t last,
               const std::vector<EyeShade>& eyes, const std::vector<float>& albedo, float extent,
               const RayCaster& caster, float bound2, std::vector<double>& value) {
    uint64_t traced = 0;
    std::vector<Ray> rays;
    std::vector<size_t> who;
    std::vector<float> what;
    std::vector<uint8_t> blocked;
    // One eye point at a time, so that a call traces rays with one origin
    for (size_t e = 0; e < eyes.size(); ++e) {
        rays.clear();
        who.clear();
        what.clear();
        for (size_t i = first; i < last; ++i) {
            const Vpl& v = candidates[i];
            const Vec3 d = v.position - eyes[e].position;
            const float d2 = length2(d), near_cos = dot(eyes[e].ng, d), far_cos = -dot(v.normal, d);
            if (!(near_cos > 0 && far_cos > 0 && d2 > 0)) continue;
            const float g = near_cos * far_cos / (d2 * (d2 + bound2)) * luminance(v.flux) * albedo[e];
            // A candidate at the eye point itself would win against all others
            if (!std::isfinite(g)) continue;
            rays.push_back(segment_to_point(spawn(eyes[e].position, eyes[e].ng, extent),
                                            spawn(v.position, v.normal, extent), extent));
            who.push_back(i);
            what.push_back(g);
        }
        blocked.resize(rays.size());
        caster.occluded(rays, blocked);
        traced += rays.size();
        for (size_t j = 0; j < rays.size(); ++j)
            // Candidates of a chunk belong to this thread alone
            if (!blocked[j]) value[who[j]] += what[j];
    }
    return traced;
}

/// The same for all candidates, on all threads.
std::vector<double> judge_all(const std::vector<Vpl>& candidates, const std::vector<EyeShade>& eyes,
                              const std::vector<float>& albedo, float extent, const RayCaster& caster,
                              float bound2, int threads, Control& control, Counters& counters) {
    std::vector<double> value(candidates.size(), 0.0);
    // A count, whose order does not matter
    std::atomic<uint64_t> rays{0};
    parallel_for((candidates.size() + kCandidatesPerChunk - 1) / kCandidatesPerChunk, threads,
                 [&](size_t chunk, int) {
                     control.check();
                     const size_t first = chunk * kCandidatesPerChunk,
                                  last = std::min(candidates.size(), first + kCandidatesPerChunk);
                     rays += judge(candidates, first, last, eyes, albedo, extent, caster, bound2, value);
                 });
    counters.light_rays += rays;
    return value;
}

}  // namespace

std::vector<Vpl> resample_vpls(const std::vector<Vpl>& candidates, size_t wanted, const Scene& scene,
                               const RayCaster& caster, const FilmCamera& film,
                               const IntegratorSettings& settings, const FrameSettings& frame,
                               Control& control, Counters& counters) {
    if (candidates.empty() || wanted == 0) return {};
    std::vector<float> albedo;
    // Candidates that the camera's points see get most of the probability
    const auto eyes = judging_points(scene, caster, film, kVplEyePoints, frame.seed, albedo, counters);
    const float bound = float(settings.vpl_bound) * scene.bounds().diagonal();
    // With an unbounded geometry term single pairs would dominate: use the default bound here
    const float judge_bound = bound > 0 ? bound : 0.01f * scene.bounds().diagonal();
    const auto value = judge_all(candidates, eyes, albedo, scene.offset_extent(), caster,
                                 judge_bound * judge_bound, frame.threads, control, counters);
    // Two distributions: by contribution, and by flux for what no judging point sees
    double total_value = 0, total_flux = 0;
    for (size_t i = 0; i < candidates.size(); ++i) {
        total_value += value[i];
        total_flux += luminance(candidates[i].flux);
    }
    if (!(total_flux > 0)) return {};
    // Systematic resampling: one random offset, `wanted` equal steps through the cumulative probability
    std::vector<Vpl> kept;
    // One offset for all steps: a candidate with probability q is picked ⌊q·n⌋ or ⌈q·n⌉ times
    const double offset = Rng(frame.seed, Purpose::kVplResampling, 0, 0).next();
    double cumulative = 0;
    size_t next = 0;
    for (size_t i = 0; i < candidates.size(); ++i) {
        const double by_flux = luminance(candidates[i].flux) / total_flux;
        const double q = total_value > 0 ? (1 - kFloor) * value[i] / total_value + kFloor * by_flux : by_flux;
        cumulative += q * double(wanted);
        size_t picks = 0;
        while (next < wanted && double(next) + offset < cumulative) {
            ++picks;
            ++next;
        }
        if (!picks) continue;
        Vpl v = candidates[i];
        // Times picks over their expectation, which keeps the sum unbiased
        v.flux = v.flux * float(double(picks) / (q * double(wanted)));
        kept.push_back(v);
    }
    return kept;
}

namespace {

/// Density of the VPLs at one of them.
float density_at(const std::vector<Vpl>& vpls, size_t i) {
    std::array<float, 4> nearest;  // squared distances, ascending
    nearest.fill(kInfinity);
    for (size_t j = 0; j < vpls.size(); ++j) {
        // Lights on the other side of a wall or on another wall serve other eye points
        if (j == i || !(dot(vpls[i].normal, vpls[j].normal) > kCompatibleCos)) continue;
        float d2 = length2(vpls[i].position - vpls[j].position);
        // Insertion into four sorted distances: what is swapped out is compared with the next
        for (float& n : nearest)
            if (d2 < n) std::swap(d2, n);
    }
    // With fewer than four neighbours, use the farthest one
    for (size_t k = 4; k-- > 0;)
        if (nearest[k] < kInfinity) return nearest[k] > 0 ? 4 / (kPi * nearest[k]) : kInfinity;
    return 0;
}

}  // namespace

std::vector<float> vpl_densities(const std::vector<Vpl>& vpls, int threads, Control& control) {
    std::vector<float> density(vpls.size(), 0.f);
    // Quadratic in the number of lights, which is small; chunks keep the threads even
    constexpr size_t kChunk = 16;
    parallel_for((vpls.size() + kChunk - 1) / kChunk, threads, [&](size_t chunk, int) {
        control.check();
        for (size_t i = chunk * kChunk; i < std::min(vpls.size(), (chunk + 1) * kChunk); ++i)
            density[i] = density_at(vpls, i);
    });
    return density;
}

}  // namespace viscache
