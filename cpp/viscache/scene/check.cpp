#include "viscache/scene/check.h"

#include <cmath>
#include <sstream>

#include "viscache/scene/vertex_limit.h"

namespace viscache {

namespace {

constexpr float kMaxPlace = 1e16f;  // of cameras and lights, as rays may have it (visibility/query.h)
/// Beyond these, the inverse that rays need has no digits left in single precision.
constexpr double kLeastStretch = 1e-24, kMostUneven = 1e10;  // for the transforms of instances
constexpr float kMaxShift = 1e3f;                            // of a camera's picture, in sizes of it

template <class... Parts>
[[noreturn]] void refuse(const Parts&... parts) {
    std::ostringstream s;
    (s << ... << parts);
    throw SceneError(s.str());
}

bool usable(Vec3 p) { return is_finite(p) && std::max(max_component(p), max_component(-p)) <= kMaxPlace; }
/// Light that is negative would take away what others bring, and cancel in means.
bool usable_color(Rgb c) { return is_finite(c) && std::min({c.x, c.y, c.z}) >= 0; }
std::string text(Vec3 p) {
    std::ostringstream s;
    s << "(" << p.x << ", " << p.y << ", " << p.z << ")";
    return s.str();
}

// The loaders check what they read; descriptions also come from Python and from bytes, and the scene trusts
// them all alike.
void check_mesh(const Mesh& m, size_t index, size_t materials, size_t images) {
    const std::string name = "mesh " + std::to_string(index) + (m.name.empty() ? "" : " '" + m.name + "'");
    if (m.vertices.size() >= (size_t{1} << 32))
        refuse(name, ": at most 2^32 - 1 vertices, got ", m.vertices.size());
    if (m.triangles.size() >= (size_t{1} << 31))
        refuse(name, ": at most 2^31 triangles, got ", m.triangles.size());
    for (size_t i = 0; i < m.vertices.size(); ++i)
        if (!is_usable_vertex(m.vertices[i]))
            refuse(name, ": vertex ", i, " must be finite and at most 1e12 in size, got ",
                   text(m.vertices[i]));
    for (size_t i = 0; i < m.triangles.size(); ++i) {
        const Vec3u t = m.triangles[i];
        // One comparison per triangle; the largest index is the one to name
        const uint32_t worst = std::max({t.x, t.y, t.z});
        if (worst >= m.vertices.size())
            refuse(name, ": triangle ", i, " names vertex ", worst, ", but there are ", m.vertices.size(),
                   " vertices");
    }
    if (!m.normals.empty() && m.normals.size() != m.vertices.size())
        refuse(name, ": normals must be one per vertex (", m.vertices.size(), "), got ", m.normals.size());
    if (!m.uvs.empty() && m.uvs.size() != m.vertices.size())
        refuse(name, ": uvs must be one per vertex (", m.vertices.size(), "), got ", m.uvs.size());
    if (!m.colors.empty() && m.colors.size() != m.vertices.size())
        refuse(name, ": colors must be one per vertex (", m.vertices.size(), "), got ", m.colors.size());
    if (m.material < 0 || size_t(m.material) >= materials)
        refuse(name, ": material must be in [0, ", materials, "), got ", m.material);
    if (!usable_color(m.emission)) refuse(name, ": emission must be finite and >= 0, got ", text(m.emission));
    if (m.emission_texture < -1 || m.emission_texture >= int(images))
        refuse(name, ": emission_texture must be -1 or in [0, ", images, "), got ", m.emission_texture);
}

void check_metal(const Material& m, const std::string& name) {
    constexpr float kLargest = 1e4f;
    if (!m.metal.is_given()) return;
    const Rgb eta = m.metal.eta, k = m.metal.k, sum = eta + k;
    if (!usable_color(eta) || !usable_color(k) || std::max(max_component(eta), max_component(k)) > kLargest ||
        !(std::min({sum.x, sum.y, sum.z}) > 0))
        refuse(name, ": metal_eta and metal_k must be in [0, 10000] and not both 0, got ", text(eta), " and ",
               text(k));
    // Fresnel's formulas of metals hold for a surface without a base, a coat or a mixture.
    const bool bare = m.kind == MaterialKind::kGlossy && m.coat == CoatKind::kNone && m.metallic == 0 &&
                      m.metallic_roughness_texture < 0 && !(max_component(m.base_color) > 0);
    if (!bare && m.kind != MaterialKind::kMirror)
        refuse(name, ": only mirrors and glossy materials with a base_color of 0 have metal_eta and metal_k");
}

/// Fresnel mixes, sheets and glass.
void check_transmission(const Material& m, const std::string& name) {
    const bool mix = m.coat == CoatKind::kFresnelMix, glass = m.kind == MaterialKind::kDielectric;
    if (mix && m.kind != MaterialKind::kGlossy && !(glass && m.thin))
        refuse(name, ": only a glossy material or a thin dielectric is a fresnel_mix");
    if (m.thin && !glass && !mix) refuse(name, ": only a dielectric or a fresnel_mix can be thin");
    if (!(m.f90 >= max_component(m.specular) || !mix) || !(m.f90 <= 1))
        refuse(name, ": f90 must be in [specular, 1], got ", m.f90);
    if (!mix && m.f90 != 1) refuse(name, ": only a fresnel_mix has f90");
    if (!usable_color(m.transmission) || max_component(m.transmission) > 1)
        refuse(name, ": transmission must be in [0, 1], got ", text(m.transmission));
    if (m.kind == MaterialKind::kGlossy && m.thin && max_component(m.transmission + m.base_color) > 1 + 1e-5f)
        refuse(name, ": base_color and transmission of a sheet must add up to at most 1, got ",
               text(m.base_color), " and ", text(m.transmission));
}

void check_coat(const Material& m, const std::string& name) {
    const bool mix = m.coat == CoatKind::kFresnelMix;
    if (!mix && m.coat != CoatKind::kNone && m.kind != MaterialKind::kGlossy)
        refuse(name, ": only a glossy material has a coat");
    if (m.nonlinear && (m.coat == CoatKind::kNone || mix)) refuse(name, ": nonlinear needs a coat");
    // A rough coat says by its kind which distribution it has
    const bool has_rough_coat = m.coat != CoatKind::kNone && m.coat != CoatKind::kSmooth;  // or a mix, GGX's
    if (m.beckmann && (m.kind != MaterialKind::kGlossy || has_rough_coat))
        refuse(name,
               ": only a glossy material without a rough coat has beckmann; such a coat has its own kind");
}

void check_material(const Material& m, size_t index, size_t images) {
    const std::string name = "material " + std::to_string(index);
    for (Rgb c : {m.base_color, m.specular})
        if (!usable_color(c) || max_component(c) > 1)
            refuse(name, ": base_color and specular must be in [0, 1], got ", text(c));
    if (!(m.roughness >= 1e-3f && m.roughness <= 1))
        refuse(name, ": roughness must be in [0.001, 1], got ", m.roughness);
    // Also refuses NaN, as all conditions here that are written as what must hold
    if (!(m.eta > 0.1f && m.eta < 10)) refuse(name, ": eta must be in (0.1, 10), got ", m.eta);
    // The rest are combinations that no part of the shading is written for.
    check_transmission(m, name);
    check_coat(m, name);
    if (!(m.opacity >= 0 && m.opacity <= 1)) refuse(name, ": opacity must be in [0, 1], got ", m.opacity);
    if (!(m.metallic >= 0 && m.metallic <= 1)) refuse(name, ": metallic must be in [0, 1], got ", m.metallic);
    if (m.mixes_metal() &&
        (m.kind != MaterialKind::kGlossy || (m.coat != CoatKind::kNone && m.coat != CoatKind::kFresnelMix)))
        refuse(name, ": only a glossy material without a coat is metallic or has images of its roughness");
    if (m.metallic_roughness_texture >= 0 && m.roughness_texture >= 0)
        refuse(name, ": metallic_roughness_texture and roughness_texture exclude each other");
    check_metal(m, name);
    for (int t : {m.base_texture, m.alpha_texture, m.metallic_roughness_texture, m.roughness_texture})
        if (t < -1 || t >= int(images)) refuse(name, ": texture must be -1 or in [0, ", images, "), got ", t);
}

void check_cone(const SpotCone& c, size_t light) {
    if (c.falloff == Falloff::kNone) return;
    // Written so that NaN fails, too.
    if (!(std::fabs(length(c.axis) - 1) < 1e-3f))
        refuse("point light ", light, ": the axis of its cone must not be zero or non-finite, got ",
               text(c.axis));
    // cos_outer = 1 would be a cone without any directions.
    if (!(c.cos_outer >= -1 && c.cos_outer < 1 && c.cos_inner >= c.cos_outer && c.cos_inner <= 1))
        refuse("point light ", light,
               ": its cone must have -1 <= cos_outer <= cos_inner <= 1, cos_outer < 1,", " got ", c.cos_outer,
               " and ", c.cos_inner);
}

void check_light_numbers(const SceneDescription& d) {
    for (size_t i = 0; i < d.point_lights.size(); ++i) {
        const PointLight& l = d.point_lights[i];
        if (!usable(l.position))
            refuse("point light ", i, ": position must be finite, got ", text(l.position));
        if (!usable_color(l.intensity))
            refuse("point light ", i, ": intensity must be finite and >= 0, got ", text(l.intensity));
        check_cone(l.cone, i);
    }
    for (size_t i = 0; i < d.directional_lights.size(); ++i) {
        const DirectionalLight& l = d.directional_lights[i];
        if (!(std::fabs(length(l.direction) - 1) < 1e-3f))
            refuse("directional light ", i, ": direction must not be zero or non-finite, got ",
                   text(l.direction));
        if (!usable_color(l.irradiance))
            refuse("directional light ", i, ": irradiance must be finite and >= 0, got ", text(l.irradiance));
    }
    for (size_t i = 0; i < d.sphere_lights.size(); ++i) {
        const SphereLight& l = d.sphere_lights[i];
        if (!usable(l.center)) refuse("sphere light ", i, ": center must be finite, got ", text(l.center));
        if (!(l.radius > 0 && l.radius < kMaxPlace))
            refuse("sphere light ", i, ": radius must be > 0, got ", l.radius);
        if (!usable_color(l.radiance))
            refuse("sphere light ", i, ": radiance must be finite and >= 0, got ", text(l.radiance));
    }
}

}  // namespace

void check_description(const SceneDescription& d) {
    for (size_t i = 0; i < d.images.size(); ++i) {
        const Image& image = d.images[i];
        if (image.width <= 0)
            refuse("image ", i, " '", image.path, "' (", image.where, ") has not been decoded");
        // Look-ups index the array by width, height and channels without a check of their own.
        const uint64_t values = uint64_t(image.width) * uint64_t(std::max(image.height, 0)) *
                                uint64_t(std::max(image.channels, 0));
        if (values == 0 || image.channels > 4 || image.size() != values ||
            (!image.pixels.empty() && !image.bytes.empty()))
            refuse("image ", i, " '", image.path, "' must have a value per channel and pixel, got ",
                   image.size(), " for ", image.width, " x ", image.height, " x ", image.channels);
        for (float v : image.pixels)
            if (!std::isfinite(v))
                refuse("image ", i, " '", image.path, "' must hold finite pixels, got ", v);
    }
    for (size_t i = 0; i < d.materials.size(); ++i) check_material(d.materials[i], i, d.images.size());
    for (size_t i = 0; i < d.meshes.size(); ++i)
        check_mesh(d.meshes[i], i, d.materials.size(), d.images.size());
    for (size_t i = 0; i < d.instances.size(); ++i) {
        for (int mesh : d.instances[i].meshes)
            if (mesh < 0 || size_t(mesh) >= d.meshes.size())
                refuse("instance ", i, ": mesh must be in [0, ", d.meshes.size(), "), got ", mesh);
        for (const auto& row : d.instances[i].to_world.m)
            for (double v : row)
                if (!(std::fabs(v) < kMaxPlace)) refuse("instance ", i, ": to_world must be finite, got ", v);
        // Rays are traced in the space of the instance, so its transform is inverted.
        const double least = d.instances[i].to_world.least_stretch(),
                     ratio = d.instances[i].to_world.most_stretch() / least;
        if (least == 0) refuse("instance ", i, ": to_world must be invertible");
        // Single precision can no longer invert a smaller transform
        if (!(least >= kLeastStretch))
            refuse("instance ", i, ": to_world must stretch by ", kLeastStretch, " or more, got ", least);
        if (!(ratio <= kMostUneven))
            refuse("instance ", i, ": to_world must stretch no direction more than ", kMostUneven,
                   " times as much as another, got ", ratio);
    }
    check_light_numbers(d);
    std::vector<Environment> skies = d.added_environments;
    if (d.environment) skies.push_back(*d.environment);
    for (const Environment& e : skies) {
        if (!usable_color(e.scale)) refuse("environment: scale must be finite and >= 0, got ", text(e.scale));
        if (e.image < -1 || e.image >= int(d.images.size()))
            refuse("environment: image must be -1 or in [0, ", d.images.size(), "), got ", e.image);
    }
    for (const Camera& c : d.cameras) check_camera(c);
}

void check_camera(const Camera& c) {
    if (!usable(c.origin)) refuse("camera '", c.name, "': origin must be finite, got ", text(c.origin));
    // Near 180 degrees the picture's plane would be infinitely wide
    if (!(c.fov_y_rad > 1e-4f && c.fov_y_rad < 3.1f))
        refuse("camera '", c.name, "': field of view must be in (0.006, 177) degrees, got ",
               c.fov_y_rad * 180 / kPi);
    if (!(c.view_height >= 0 && c.view_height < kMaxPlace))
        refuse("camera '", c.name, "': view_height must be finite and >= 0, got ", c.view_height);
    for (float shift : {c.shift_x, c.shift_y})
        if (!(std::fabs(shift) <= kMaxShift))
            refuse("camera '", c.name, "': the shift must be finite and at most ", kMaxShift, ", got ",
                   shift);
    // A camera whose origin and target are equal, or not finite, has axes of zero or NaN.
    for (Vec3 axis : {c.forward, c.right, c.up})
        if (!(std::fabs(length(axis) - 1) < 1e-3f))
            refuse("camera '", c.name, "': origin and target must be finite and differ");
}

}  // namespace viscache
