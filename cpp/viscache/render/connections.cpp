#include "viscache/render/connections.h"

namespace viscache {

namespace {

/// Density per m² at `z` of a ray that the light emits towards it. `direction`: unit, from `z` to the light.
/// Strategies that start at the light would have drawn it with this density.
double emission_density(const Emission& e, const PathVertex& y, const PathVertex& z, Vec3 direction) {
    const double cos_z = std::fabs(double(dot(z.surface.ng, direction)));
    switch (e.kind) {
        // Parallel rays: per area across them, turned onto the surface
        case LightKind::kDirectional:
        case LightKind::kEnvironment: return e.pdf_ray * cos_z;
        case LightKind::kPoint: return to_area(e.pdf_ray, y, z);
        case LightKind::kTriangle:
        case LightKind::kSphere: break;
    }
    // Area lights emit by the cosine, over π; either side with half the probability
    const double cosine = -double(dot(e.normal, direction));
    const double pdf = e.two_sided ? 0.5 * std::fabs(cosine) : std::max(0.0, cosine);
    return to_area(pdf / M_PI, y, z);
}

LightGroup group_of(LightKind kind) {
    switch (kind) {
        case LightKind::kPoint: return LightGroup::kPoint;
        case LightKind::kDirectional: return LightGroup::kDirectional;
        case LightKind::kEnvironment: return LightGroup::kEnvironment;
        case LightKind::kTriangle:
        case LightKind::kSphere: break;
    }
    return LightGroup::kArea;
}

Semantic semantic_of(LightKind kind) {
    switch (kind) {
        case LightKind::kPoint: return Semantic::kPoint;
        case LightKind::kDirectional: return Semantic::kDirection;
        case LightKind::kEnvironment: return Semantic::kSolidAngle;
        case LightKind::kTriangle:
        case LightKind::kSphere: break;
    }
    return Semantic::kSurface;
}

}  // namespace

StrategyRules Connector::rules(const Emission& e) const {
    // Points and parallel light have no extent, and spheres are sampled as spheres but traced as
    // meshes. Lights with holes are sampled as a whole
    const bool hittable =
        (e.kind == LightKind::kTriangle && !e.has_holes) || e.kind == LightKind::kEnvironment;
    return {c_.to_camera(), hittable};
}

/// Connects the last eye vertex with the light (s = 1).
Connector::Joint Connector::with_light(const Emission& e, Vertices eye, const PathVertex& y) const {
    const PathVertex& z = eye.back();
    Joint j;
    const Vec3 d = y.position - z.position;
    // The light's end is a direction where the light comes from infinity
    const float d2 = length2(d);
    j.direction = is_infinite(e.kind) ? -e.ray.d : d / std::sqrt(d2);
    float leaving = 1;  // cosine at the light divided by the squared distance
    if (!is_infinite(e.kind)) leaving /= d2;
    if (e.kind == LightKind::kPoint) leaving *= spot_factor(e.cone, -j.direction);
    if (e.kind == LightKind::kTriangle || e.kind == LightKind::kSphere) {
        const float cosine = -dot(e.normal, j.direction);
        leaving *= e.two_sided ? std::fabs(cosine) : std::max(0.f, cosine);
    }
    // No light leaves towards the eye: neither a query nor its densities are needed
    if (!(leaving > 0)) return j;
    j.value = z.beta * reflected(z, z.surface.wo, j.direction) * y.beta * leaving;
    // Densities of the two ends, had the other side made them: the weights compare all strategies
    j.densities.eye_last = emission_density(e, y, z, j.direction);
    j.densities.light_last = to_area(scatter_pdf(z, z.surface.wo, j.direction), z, y);
    return j;
}

/// Connects two surfaces (s > 1).
Connector::Joint Connector::with_vertex(Vertices eye, Vertices light) const {
    const PathVertex &z = eye.back(), &y = light.back();
    Joint j;
    const Vec3 d = y.position - z.position;
    const float d2 = length2(d);
    j.direction = d / std::sqrt(d2);
    // Geometric cosines at the light's vertex: light paths carry the quotient of both normals
    // (path_vertex.h)
    const float cosine = -dot(y.surface.ng, j.direction), arrived = dot(y.surface.ng, y.surface.wo);
    if (!(cosine > 0)) return j;
    j.value = z.beta * reflected(z, z.surface.wo, j.direction);
    // The second reflection costs as much as the first, so it waits until that is known to bring
    // light
    if (!(max_component(j.value) > 0)) return j;
    j.value = j.value * y.beta * reflected(y, -j.direction, y.surface.wo) * (cosine / (d2 * arrived));
    j.densities.eye_last = to_area(scatter_pdf(y, y.surface.wo, -j.direction), y, z);
    j.densities.light_last = to_area(scatter_pdf(z, z.surface.wo, j.direction), z, y);
    j.densities.light_before =
        to_area(scatter_pdf(y, -j.direction, y.surface.wo), y, light[light.size() - 2]);
    return j;
}

void Connector::join(const Subpaths& eye_paths, const Subpaths& light_paths, size_t path, uint32_t pixel) {
    const Vertices eye = eye_paths.of(path), light = light_paths.of(path);
    const Emission& start = light_paths.start[path];
    const size_t vertices = size_t(c_.settings.max_depth) + 1;
    // t eye vertices and s of the light make a path of s + t vertices, which has one edge less. At
    // most max_depth edges are allowed
    for (size_t t = 2; t <= eye.size() && t < vertices; ++t) {
        const PathVertex& z = eye[t - 1];
        if (!z.connects || is_black(z.surface)) continue;
        // An eye vertex without a partner would leave an eye point that nothing asks about
        const size_t longest = std::min(light.size(), vertices - t);
        if (longest == 0) continue;
        const uint32_t eye_point = add_eye_point(z, true);
        for (size_t s = 1; s <= longest; ++s)
            if (light[s - 1].connects) to_surface(start, eye.first(t), light.first(s), eye_point, pixel);
    }
    if (!c_.to_camera()) return;
    // From the second vertex on: light that reaches the camera directly is what eye paths hit
    for (size_t s = 2; s <= light.size() && s < vertices; ++s)
        if (light[s - 1].connects) to_camera(start, light.first(s));
}

void Connector::to_surface(const Emission& start, Vertices eye, Vertices light, uint32_t eye_point,
                           uint32_t pixel) {
    const PathVertex &z = eye.back(), &y = light.back();
    Joint j = light.size() == 1 ? with_light(start, eye, y) : with_vertex(eye, light);
    if (!brings(j.value)) return;
    // The camera itself is never sampled, so nothing before the first surface has such a density
    if (eye.size() > 2)
        j.densities.eye_before = to_area(scatter_pdf(z, j.direction, z.surface.wo), z, eye[eye.size() - 2]);
    const double weight = path_weight(eye, light, j.densities, rules(start));
    ShadowQuery q;
    q.eye = eye_point;
    q.semantic = light.size() == 1 ? semantic_of(start.kind) : Semantic::kSurface;
    q.group = uint8_t(light.size() == 1 ? group_of(start.kind) : LightGroup::kConnection);
    // Density of light paths at the far end, from which a cache takes its cells on that side
    q.density = float(y.density);
    if (y.infinite) {
        q.far = j.direction;
    } else {
        // The ray ends off the surface, on the side of the eye. Points have no normal
        q.far_normal = dot(y.surface.ng, j.direction) <= 0 ? y.surface.ng : -y.surface.ng;
        q.far = y.position;
        q.ray_end = y.position;
        if (q.semantic == Semantic::kSurface) q.ray_end = spawn(y.position, q.far_normal, y.extent);
    }
    add(q, j.value * float(weight / c_.frame.spp), pixel);
}

/// Connects the last light vertex with the camera (t = 1). The path can fall on any pixel.
// Differs (A27): the paper does not mention these connections. Here they use the cache with the camera as a
// point, or bypass it.
void Connector::to_camera(const Emission& start, Vertices light) {
    const PathVertex& y = light.back();
    const FilmCamera& film = c_.film;
    const bool parallel = film.camera.is_orthographic();
    const Vec3 to_eye = film.camera.origin - y.position;
    // Parallel cameras have a plane instead of a point: the ray goes to it along the axis
    const Vec3 d = parallel ? film.camera.forward * dot(film.camera.forward, to_eye) : to_eye;
    const float d2 = length2(d);
    const Vec3 direction = d / std::sqrt(d2);
    const float cos_camera = -dot(film.camera.forward, direction), cos_y = dot(y.surface.ng, direction);
    if (!(cos_camera > 0 && cos_y > 0)) return;
    // Outside of the picture the camera sees nothing of this vertex
    const auto pixel = film.pixel_of(parallel ? -to_eye : -direction);
    if (!pixel) return;
    // Importance of the film: 1/(area·cos⁴), with the cosine of the edge at the camera; parallel: 1/area
    const double pdf = c_.film_pdf(cos_camera), area = parallel ? cos_y : double(cos_y) / double(d2);
    // The film's density times the geometry, over the cosine with which light arrived at the
    // geometric normal
    const Rgb value = y.beta * reflected(y, direction, y.surface.wo) *
                      float(pdf * area / double(dot(y.surface.ng, y.surface.wo)));
    if (!brings(value)) return;
    // A sub-path of one vertex, which the weights take as t = 1
    PathVertex camera;
    camera.position = parallel ? y.position + d : film.camera.origin;
    JoinDensities densities;
    densities.light_last = pdf * area;
    densities.light_before = to_area(scatter_pdf(y, direction, y.surface.wo), y, light[light.size() - 2]);
    const double weight = path_weight({&camera, 1}, light, densities, rules(start));
    ShadowQuery q;
    // The cache knows points as far ends of a connection, but no plane
    q.eye = add_eye_point(y, c_.settings.camera_connections == CameraConnections::kKeyed && !parallel);
    q.semantic = Semantic::kPoint;
    q.group = uint8_t(LightGroup::kCamera);
    q.far = q.ray_end = camera.position;
    add(q, value * float(weight / c_.frame.spp), *pixel);
}

/// Adds an eye point for the oracle. It gets no normal if the cache must not answer.
uint32_t Connector::add_eye_point(const PathVertex& v, bool keyed) {
    EyeBlock& eyes = out_.eyes;
    eyes.position.push_back(v.position);
    // Without a normal a cache has no cell for the point and passes it on to rays
    eyes.normal.push_back(keyed ? v.surface.ng : Vec3{});
    eyes.origin.push_back(spawn(v.position, v.surface.ng, v.extent));
    // Eye samples of the whole frame per area: the cells of a cache are as large as C_E of them
    eyes.density.push_back(float(v.density * c_.samples()));
    return uint32_t(eyes.size() - 1);
}

/// Whether a contribution needs a query. Non-finite values are counted.
bool Connector::brings(Rgb value) {
    if (!is_finite(value)) {
        ++counters_.non_finite;
        return false;
    }
    return max_component(value) > 0;
}

void Connector::add(const ShadowQuery& query, Rgb value, uint32_t pixel) {
    if (!brings(value)) return;
    out_.queries.push_back(query);
    out_.contribution.push_back(value);
    out_.pixel.push_back(pixel);
}

}  // namespace viscache
