#include "viscache/render/light_sampling.h"

#include "viscache/render/light_choice.h"
#include "viscache/sampling/warp.h"

namespace viscache {

LightSampler::LightSampler(const Scene& scene) : scene_(scene) {
    const SceneDescription& d = scene.description();
    std::vector<double> power;
    auto add = [&](LightKind kind, size_t index, double watts) {
        // Black lights would have a start without flux
        if (watts > 0) {
            entries_.push_back({kind, index});
            power.push_back(watts);
        }
    };
    // Light from infinity: the power that meets the bounding sphere
    const double disk = M_PI * double(scene.radius()) * scene.radius();
    for (size_t i = 0; i < d.point_lights.size(); ++i)
        add(LightKind::kPoint, i,
            // Intensity integrated over the cone: a narrow spot has less power than a lamp of the
            // same intensity
            spot_integral(d.point_lights[i].cone) * luminance(d.point_lights[i].intensity));
    for (size_t i = 0; i < d.directional_lights.size(); ++i)
        add(LightKind::kDirectional, i, disk * luminance(d.directional_lights[i].irradiance));
    const AreaLights& area = scene.area_lights();
    for (size_t i = 0; i < area.triangles.size(); ++i)
        add(LightKind::kTriangle, i,
            // π·A·L, the flux of a Lambertian emitter, for each side that shines
            M_PI * area.triangles[i].area * luminance(area.triangles[i].radiance) *
                (area.triangles[i].two_sided ? 2 : 1));
    for (size_t i = 0; i < area.spheres.size(); ++i)
        add(LightKind::kSphere, i,
            4 * M_PI * M_PI * double(area.spheres[i].radius) * area.spheres[i].radius *
                luminance(area.spheres[i].radiance));
    // Last, as `pdf_environment` assumes
    if (scene.environment()) add(LightKind::kEnvironment, 0, disk * scene.environment()->total_power());
    if (!power.empty()) choice_ = Distribution1D(power);
}

std::optional<Emission> LightSampler::emit(Rng& rng) const {
    const auto pick = choice_.sample(rng.next());
    Emission e = emit_from(entries_[pick.index], rng);
    // The choice of the light is a part of both density and flux
    e.flux = e.flux / float(pick.pmf);
    e.pdf_point *= pick.pmf;
    // A texel of an emissive image may be black although its light is not
    if (!is_finite(e.flux) || !(max_component(e.flux) > 0)) return std::nullopt;
    return e;
}

double LightSampler::pdf_point(Rgb radiance, bool two_sided) const {
    // Lights are chosen by power: π·A·luminance per side
    return empty() ? 0 : M_PI * double(luminance(radiance)) * (two_sided ? 2 : 1) / choice_.total();
}

double LightSampler::pdf_environment(Vec3 wi) const {
    // The environment is the last entry
    if (empty() || entries_.back().kind != LightKind::kEnvironment) return 0;
    return choice_.pmf(choice_.size() - 1) * double(scene_.environment()->pdf(wi));
}

double LightSampler::pdf_parallel() const { return 1 / (M_PI * double(disk_radius()) * disk_radius()); }

/// Parallel light: a ray that starts on a disk as large as the bounding sphere.
Emission LightSampler::emit_through_scene(Vec3 towards_light, Rgb irradiance, Rng& rng) const {
    // The disk stands in front of the scene, so rays start outside and meet everything that the
    // light can reach
    const float radius = disk_radius();
    // Concentric: neighbouring numbers stay neighbours, which keeps stratification
    const Vec2 disk = square_to_disk_concentric(rng.next2());
    const Frame3 frame = frame_around(towards_light);
    const Vec3 start = scene_.center() + (frame.x * disk.x + frame.y * disk.y + towards_light) * radius;
    return {.ray = {start, 0, -towards_light, kInfinity},
            .flux = irradiance * (kPi * radius * radius),
            .point = start,
            .pdf_ray = pdf_parallel()};
}

Emission LightSampler::emit_from(const Entry& entry, Rng& rng) const {
    const SceneDescription& d = scene_.description();
    const AreaLights& area = scene_.area_lights();
    // Lambertian emission: directions by the cosine, so flux is π·A·L for every ray
    auto from_surface = [&](Vec3 p, Vec3 n, float extent, Rgb radiance, float surface_area, bool two_sided) {
        const Vec3 local = square_to_cosine_hemisphere(rng.next2());
        return Emission{.ray = {spawn(p, n, extent), 0, frame_around(n).to_world(local), kInfinity},
                        .flux = radiance * (kPi * surface_area * (two_sided ? 2.f : 1.f)),
                        .kind = entry.kind,
                        .point = p,
                        .normal = n,
                        .extent = extent,
                        .two_sided = two_sided,
                        .radiance = radiance,
                        .pdf_point = 1 / double(surface_area),
                        .pdf_ray = double(local.z) / M_PI * (two_sided ? 0.5 : 1.0)};
    };
    switch (entry.kind) {
        case LightKind::kPoint: {
            const PointLight& l = d.point_lights[entry.index];
            // Within the cone, evenly; the falloff is left in the flux
            const Vec3 away = sample_spot(l.cone, rng.next2());
            const double pdf = pdf_spot(l.cone);
            return {.ray = {l.position, 0, away, kInfinity},
                    .flux = l.intensity * (spot_factor(l.cone, away) / float(pdf)),
                    .kind = entry.kind,
                    .point = l.position,
                    .radiance = l.intensity,
                    .cone = l.cone,
                    .pdf_ray = pdf};
        }
        case LightKind::kDirectional: {
            const DirectionalLight& l = d.directional_lights[entry.index];
            Emission e = emit_through_scene(l.direction, l.irradiance, rng);
            e.kind = entry.kind;
            e.radiance = l.irradiance;
            return e;
        }
        case LightKind::kTriangle: {
            const EmissiveTriangle& t = area.triangles[entry.index];
            const Vec2 b = square_to_triangle(rng.next2());
            // One of both sides, which halves the density of the ray
            const bool back = t.two_sided && rng.next() < 0.5f;
            Emission e =
                from_surface(t.a + (t.b - t.a) * b.x + (t.c - t.a) * b.y, back ? -t.normal : t.normal,
                             t.extent, area.radiance_at(entry.index, b), t.area, t.two_sided);
            e.has_holes = !t.opaque;
            return e;
        }
        case LightKind::kSphere: {
            const SphereLight& s = area.spheres[entry.index];
            const Vec3 n = square_to_uniform_sphere(rng.next2());
            return from_surface(s.center + n * s.radius, n, s.radius, s.radiance,
                                4 * kPi * s.radius * s.radius, false);
        }
        case LightKind::kEnvironment: {
            // The direction by radiance, then a point on the disk across it
            const auto sample = scene_.environment()->sample(rng.next2());
            Emission e = emit_through_scene(sample.wi, sample.radiance / sample.pdf, rng);
            e.kind = entry.kind;
            e.radiance = sample.radiance;
            e.pdf_point = sample.pdf;
            return e;
        }
    }
    return {};
}

namespace {

/// `weights`: barycentric weights of the vertices b and c at the point.
AreaSample on_triangle(const LightsAt& at, size_t light, Vec3 p, Vec3 n, Vec2 weights, double pmf) {
    const AreaLights& lights = at.lights();
    const EmissiveTriangle& t = lights.triangles[light];
    const auto by_power = float(lights.choice.pmf(light));
    return {p,
            n,
            spawn(p, n, t.extent),
            lights.radiance_at(light, weights),
            float(pmf) / t.area,
            by_power / t.area,
            light};
}

/// Density of `sample_sphere_light` per area at a point of the sphere.
float cone_pdf(const SphereLight& s, Vec3 from, Vec3 point, Vec3 normal) {
    const Vec3 axis = s.center - from, back = from - point;
    // In double, as in the sampler itself: the weights divide by these densities
    const double d2 = double(axis.x) * axis.x + double(axis.y) * axis.y + double(axis.z) * axis.z;
    const double share = double(s.radius) * s.radius / d2;
    // Inside the sphere there is no cone
    if (!(share < 1)) return 0;
    // 1 − cosθ of the cone without cancellation, also for a tiny sphere far away
    const double cone = share / (1 + std::sqrt(1 - share)), distance2 = length2(back);
    const double cosine = dot(normal, back) / std::sqrt(distance2);
    return float(cosine / (2 * M_PI * cone * distance2));
}

/// `pdf_cone`: density per area of sampling the cone that the sphere spans.
AreaSample on_sphere(const LightsAt& at, size_t light, Vec3 p, Vec3 n, double pmf, float pdf_cone) {
    const AreaLights& lights = at.lights();
    const SphereLight& s = lights.spheres[light - lights.triangles.size()];
    const auto by_power = float(lights.choice.pmf(light));
    // A point sees at most half of a sphere
    return {p,
            n,
            spawn(p, n, s.radius),
            s.radiance,
            float(pmf) * pdf_cone,
            by_power / (2 * kPi * s.radius * s.radius),
            light};
}

}  // namespace

std::optional<AreaSample> sample_area_light(const LightsAt& at, const LightPick& pick, Vec2 u) {
    if (!(pick.pmf > 0)) return std::nullopt;
    const AreaLights& lights = at.lights();
    if (pick.light < lights.triangles.size()) {
        const EmissiveTriangle& t = lights.triangles[pick.light];
        const Vec2 b = square_to_triangle(u);
        const Vec3 p = t.a + (t.b - t.a) * b.x + (t.c - t.a) * b.y;
        // A one-sided light shows its back: no light, and no query
        const bool behind = dot(t.normal, at.position() - p) <= 0;
        if (behind && !t.two_sided) return std::nullopt;
        return on_triangle(at, pick.light, p, behind ? -t.normal : t.normal, b, pick.pmf);
    }
    const SphereLight& s = lights.spheres[pick.light - lights.triangles.size()];
    const auto sample = sample_sphere_light(s.center, s.radius, at.position(), u);
    if (!sample) return std::nullopt;
    return on_sphere(at, pick.light, sample->p, sample->n, pick.pmf, sample->pdf_area);
}

AreaSample area_sample_at(const LightsAt& at, size_t light, Vec3 point, Vec3 normal, Vec2 weights) {
    // What light sampling would have done here, for the weights of both techniques
    const double pmf = at.pmf(light);
    const AreaLights& lights = at.lights();
    if (light < lights.triangles.size()) return on_triangle(at, light, point, normal, weights, pmf);
    const SphereLight& s = lights.spheres[light - lights.triangles.size()];
    const float pdf = cone_pdf(s, at.position(), point, normal);
    return on_sphere(at, light, point, normal, pmf, pdf);
}

}  // namespace viscache
