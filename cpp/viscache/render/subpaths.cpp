#include "viscache/render/subpaths.h"

#include "viscache/sampling/pixel_place.h"
#include "viscache/visibility/shadow_ray.h"

namespace viscache {

void SubpathTracer::start(const SampleTile& work) {
    const int width = work.tile.x1 - work.tile.x0, height = work.tile.y1 - work.tile.y0;
    width_ = width;
    // Path p starts in pixel places_[p], in both kinds of sub-paths
    places_ = morton_pixels(width, height);
    walkers_.clear();
}

/// Key of the random numbers of a sample, unique in the frame.
uint64_t SubpathTracer::stream_of(const SampleTile& work, uint32_t path) const {
    const auto [x, y] = places_[path];
    const uint64_t pixel = uint64_t(work.tile.y0 + y) * uint64_t(c_.film.width) + uint64_t(work.tile.x0 + x);
    // Of pixel and sample alone, so that tiles of any size give the same paths
    return pixel * uint64_t(c_.frame.spp) + work.sample;
}

void SubpathTracer::trace_light(const SampleTile& work, Subpaths& out, Counters& counters,
                                const Control& control) {
    start(work);
    // A path that ends at the camera has one light vertex per edge; other paths have one less
    const size_t longest = size_t(c_.settings.max_depth - (c_.to_camera() ? 0 : 1));
    out.reset(places_.size(), std::max<size_t>(1, longest));
    // Paths of one edge that may not end at the camera have no vertex but the light itself
    if (c_.lights.empty() || longest == 0) return;
    for (uint32_t p = 0; p < places_.size(); ++p) {
        const uint64_t stream = stream_of(work, p);
        Rng rng(c_.frame.seed, Purpose::kLightSubpath, stream, 0);
        const auto e = c_.lights.emit(rng);
        // A path without a start keeps zero vertices and connects with nothing
        if (!e || !is_traceable(e->ray.o)) continue;
        out.start[p] = *e;
        PathVertex& y = out.append(p);
        y.infinite = is_infinite(e->kind);
        y.position = e->point;
        // Point lights have no normal, so `to_area` gives 0: no strategy meets them by chance
        y.surface.ng = e->normal;
        y.forward = e->pdf_point;
        y.density = e->pdf_point;
        // Throughput of the light itself, for connections with it (s = 1): without the factors of
        // its ray
        y.beta = e->radiance / float(e->pdf_point);
        walkers_.push_back({.path = p,
                            .stream = stream,
                            .ray = e->ray,
                            .beta = e->flux,
                            .pdf = e->pdf_ray,
                            .parallel = y.infinite,
                            .spread = e->pdf_ray,
                            .parallel_spread = y.infinite});
    }
    walk(Transport::kImportance, longest - 1, out, nullptr, counters, control);
}

void SubpathTracer::trace_eye(const SampleTile& work, Subpaths& out, EyeLight& light, Counters& counters,
                              const Control& control) {
    start(work);
    // The camera, and one vertex per edge
    const size_t longest = size_t(c_.settings.max_depth) + 1;
    out.reset(places_.size(), longest);
    light.emitted.assign(places_.size(), {});
    light.seen.assign(places_.size(), {});
    light.first.assign(places_.size(), {});
    for (uint32_t p = 0; p < places_.size(); ++p) {
        const auto [px, py] = places_[p];
        const uint64_t stream = stream_of(work, p), pixel = stream / uint64_t(c_.frame.spp);
        // The positions that all rendering methods share: frames of different methods compare pixel
        // by pixel
        const Vec2 jitter = pixel_place(c_.frame.seed, pixel, work.sample);
        const float x = float(work.tile.x0 + px) + jitter.x, y = float(work.tile.y0 + py) + jitter.y;
        const Vec3 raw = c_.film.direction(x, y);
        const bool parallel = c_.film.camera.is_orthographic();
        // Density over the whole film, because strategies that start at the light may reach any
        // pixel
        const double pdf = c_.film_pdf(1 / double(length(raw)));
        PathVertex& z = out.append(p);
        z.position = c_.film.origin(x, y);
        // The camera is given: no strategy samples it
        z.forward = 1;
        walkers_.push_back({.path = p,
                            .stream = stream,
                            .ray = {z.position, 0, normalize(raw), kInfinity},
                            .beta = {1, 1, 1},
                            .pdf = pdf,
                            .parallel = parallel,
                            .spread = pdf,
                            .parallel_spread = parallel});
    }
    walk(Transport::kRadiance, longest - 1, out, &light, counters, control);
}

/// Follows all walkers for at most `edges` edges.
void SubpathTracer::walk(Transport transport, size_t edges, Subpaths& out, EyeLight* light,
                         Counters& counters, const Control& control) {
    for (size_t edge = 0; edge < edges && !walkers_.empty(); ++edge) {
        control.check();
        rays_.clear();
        next_.clear();
        // One edge of all paths at a time, so that rays are traced in large calls
        for (const Walker& w : walkers_) rays_.push_back(w.ray);
        hits_.assign(rays_.size(), {});
        // Only primary rays are coherent
        const bool primary = transport == Transport::kRadiance && edge == 0;
        c_.caster.intersect(rays_, hits_, primary ? Coherence::kCoherent : Coherence::kIncoherent);
        (light ? counters.camera_rays : counters.light_rays) += rays_.size();
        for (size_t i = 0; i < walkers_.size(); ++i) {
            Walker& w = walkers_[i];
            if (arrive(w, hits_[i], out, light, counters) && edge + 1 < edges &&
                go_on(w, transport, out.of(w.path)))
                // Paths that end leave the list, which keeps its order
                next_.push_back(w);
        }
        walkers_.swap(next_);
    }
}

/// Adds the vertex that was hit. False if the sub-path ends without one.
bool SubpathTracer::arrive(Walker& w, const Hit& hit, Subpaths& out, EyeLight* light,
                           Counters& counters) const {
    if (!hit.valid()) {
        if (light && c_.scene.environment()) hit_environment(w, out, *light, counters);
        return false;
    }
    const int instance = hit.instance == kNoHit ? -1 : int(hit.instance);
    const SurfacePoint s = c_.scene.surface(hit.mesh, hit.triangle, instance, hit.u, hit.v);
    // The side of the triangle's normal, for materials and lights with one side
    const bool front = dot(s.ng, w.ray.d) <= 0;
    if (light) {
        // Only the camera so far: this is what the pixel shows
        if (out.count[w.path] == 1) add_first_hit(w, hit, s, *light);
        if (max_component(s.emission) > 0 && (front || s.emits_two_sided))
            hit_light(w, hit, s, out, *light, counters);
    }
    // A degenerate triangle has no sides
    if (length2(s.ng) == 0) return false;
    const Material& material = c_.scene.materials()[size_t(s.material)];
    const bool glass = material.kind == MaterialKind::kDielectric;
    // Backs of one-sided surfaces absorb, as for eye paths of the other integrators
    if (!front && !material.two_sided && !glass) return false;
    PathVertex& v = out.append(w.path);
    v = vertex_at(w, hit, s);
    // Unfolded length through mirrors and glass, over which the cache's density spreads
    w.distance += hit.t;
    v.connects = material.kind == MaterialKind::kDiffuse || material.kind == MaterialKind::kGlossy;
    return true;
}

/// The vertex at the end of the ray of a walker: position, normals, densities.
PathVertex SubpathTracer::vertex_at(const Walker& w, const Hit& hit, const SurfacePoint& s) const {
    PathVertex v;
    v.surface = c_.scene.reflection(s);
    v.front = dot(s.ng, w.ray.d) <= 0;
    v.position = s.position;
    v.surface.ng = v.front ? s.ng : -s.ng;
    v.surface.ns = v.front ? s.ns : -s.ns;
    v.surface.wo = -w.ray.d;
    v.beta = w.beta;
    const double cosine = std::fabs(double(dot(v.surface.ng, w.ray.d))), t = double(hit.t);
    // From the density of the ray to that per area of what it meets. Parallel rays do not spread
    v.forward = w.parallel ? w.pdf * cosine : w.pdf * cosine / (t * t);
    // At grazing angles the density would vanish and cells would grow without a bound
    const double clamped = std::max(cosine, double(kLeastCosine)), d = double(w.distance + hit.t);
    v.density = w.parallel_spread ? w.spread * clamped : w.spread * clamped / (d * d);
    return v;
}

/// Scatters at the last vertex. False if the sub-path ends.
bool SubpathTracer::go_on(Walker& w, Transport transport, std::span<PathVertex> path) const {
    PathVertex& v = path.back();
    // The density of the way back is known only now that the path has gone on
    PathVertex& before = path[path.size() - 2];
    const auto purpose = transport == Transport::kRadiance ? Purpose::kEyeSubpath : Purpose::kLightSubpath;
    // A stream per vertex: what one vertex draws does not shift the numbers of the next
    Rng rng(c_.frame.seed, purpose, w.stream, path.size());
    const auto s = scatter(v, transport, rng);
    if (!s) return false;
    v.passed = s->specular;
    before.reverse = to_area(s->pdf_back, v, before);
    w.beta = w.beta * s->factor;
    w.pdf = s->pdf;
    w.parallel = false;
    if (s->specular) {
        // The bundle of rays goes through mirrors unchanged; only the probability of the event
        // thins it
        w.spread *= s->pdf;
    } else {
        w.direct = false;
        w.spread = s->pdf;
        // A rough surface starts a new bundle
        w.parallel_spread = false;
        w.distance = 0;
    }
    w.ray = {spawn(v.position, s->side, c_.scene.offset_extent()), 0, s->direction, kInfinity};
    return is_finite(w.beta) && max_component(w.beta) > 0;
}

void SubpathTracer::hit_environment(const Walker& w, Subpaths& out, EyeLight& light,
                                    Counters& counters) const {
    const Rgb radiance = c_.scene.environment()->eval(w.ray.d);
    if (!(max_component(radiance) > 0)) return;
    PathVertex emitter;
    emitter.infinite = true;
    emitter.beta = w.beta;
    // At infinity densities stay per steradian
    emitter.forward = w.pdf;
    const PathVertex& before = out.of(w.path).back();
    // Density with which parallel light would have met the vertex before
    const double pdf_before = c_.lights.pdf_parallel() * std::fabs(double(dot(before.surface.ng, w.ray.d)));
    add_emitted(w, emitter, c_.lights.pdf_environment(w.ray.d), pdf_before, radiance, out, light, counters,
                {c_.to_camera(), true});
}

void SubpathTracer::hit_light(const Walker& w, const Hit& hit, const SurfacePoint& s, Subpaths& out,
                              EyeLight& light, Counters& counters) const {
    const PathVertex emitter = vertex_at(w, hit, s);
    const PathVertex& before = out.of(w.path).back();
    // Cosine emission from one side, or from either with half the density
    const double emitted = std::fabs(double(dot(s.ng, w.ray.d))) / M_PI * (s.emits_two_sided ? 0.5 : 1.0);
    // Sphere lights are traced as meshes and sampled as spheres. Hits by chance count only where no other
    // strategy finds the light
    const bool sphere = c_.scene.sphere_light_of(hit.mesh) >= 0;
    add_emitted(
        w, emitter, c_.lights.pdf_point(c_.scene.mean_emission(hit.mesh, hit.triangle), s.emits_two_sided),
        to_area(emitted, emitter, before), s.emission, out, light, counters, {c_.to_camera(), !sphere});
}

/// Adds the light of an emitter that the eye path has hit.
void SubpathTracer::add_emitted(const Walker& w, const PathVertex& emitter, double pdf_point,
                                double pdf_before, Rgb radiance, Subpaths& out, EyeLight& light,
                                Counters& counters, StrategyRules rules) const {
    // The emitter is a vertex for the weights alone and is taken off again: the path may go on
    // through the light's surface
    out.append(w.path) = emitter;
    const double weight = path_weight(out.of(w.path), {}, {pdf_point, pdf_before, 0, 0}, rules);
    --out.count[w.path];
    const Rgb value = w.beta * radiance * float(weight / c_.frame.spp);
    if (!is_finite(value)) {
        ++counters.non_finite;
        return;
    }
    light.emitted[pixel_of(w.path)] += value;
    // What the camera sees through mirrors and glass only is no matter of visibility caches
    if (w.direct) light.seen[pixel_of(w.path)] += value;
}

void SubpathTracer::add_first_hit(const Walker& w, const Hit& hit, const SurfacePoint& s,
                                  EyeLight& light) const {
    FirstHits& first = light.first[pixel_of(w.path)];
    ++first.count;
    first.depth += hit.t;
    first.normal += dot(s.ng, w.ray.d) <= 0 ? s.ns : -s.ns;
    first.albedo += s.base_color;
}

}  // namespace viscache
