#include "viscache/scene/scene.h"

#include <sstream>

#include "viscache/math/any_length.h"
#include "viscache/scene/check.h"
#include "viscache/scene/light_tree.h"
#include "viscache/scene/vertex_limit.h"

namespace viscache {

namespace {

constexpr size_t kEmissionSamples = size_t{1} << 25;  // of a mesh, for means of its emissive image
constexpr int kSphereRings = 24;  // tessellation of a sphere light: 2·23·48 triangles, inscribed

/// Inscribed tessellation: a segment from outside to a point of the analytic sphere does not cross it.
Mesh tessellate(const SphereLight& light) {
    Mesh mesh;
    mesh.name = "sphere light";
    mesh.emission = light.radiance;
    const int rings = kSphereRings, sectors = 2 * kSphereRings;
    for (int i = 0; i <= rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            const double theta = M_PI * i / rings, phi = 2 * M_PI * j / sectors;
            const Vec3 n{float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                         float(std::sin(theta) * std::sin(phi))};
            mesh.vertices.push_back(light.center + n * (light.radius * 0.9999f));
        }
    auto at = [&](int i, int j) { return uint32_t(i * sectors + j % sectors); };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            if (i > 0) mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            if (i < rings - 1) mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    return mesh;
}

/// Mitsuba puts the first and the last row of a sky at the poles. Here they end there, as in pbrt, which
/// moves rows by up to half their height.
void warn_of_few_rows(const Image& sky, std::vector<Warning>& warnings) {
    constexpr int kFewRows = 128;
    if (sky.height >= kFewRows || sky.where.find(".xml:") == std::string::npos) return;
    const std::string text = "a sky of " + std::to_string(sky.height) +
                             " rows, which Mitsuba places up to half a row nearer to the poles";
    // A scene made from the description of this one carries the warning already
    const auto same = [&](const Warning& w) { return w.where == sky.where && w.text == text; };
    if (std::none_of(warnings.begin(), warnings.end(), same)) warnings.push_back({sky.where, text});
}

Vec3 facing(Vec3 n, Vec3 side) { return dot(n, side) < 0 ? -n : n; }

/// A number in [0, 1) for a cell of a triangle: a fixed pattern of `opacity`.
float pattern(uint32_t mesh, uint32_t triangle, float u, float v) {
    constexpr float kCells = 4096;  // along an edge
    const auto cell = [](float x) { return uint64_t(uint32_t(int(std::floor(x * kCells)))); };
    uint64_t h = (uint64_t(mesh) << 32 | triangle) * 0x9E3779B97F4A7C15ull;
    h = (h ^ h >> 32 ^ (cell(u) << 32 | cell(v))) * 0xC2B2AE3D27D4EB4Full;
    h = (h ^ h >> 29) * 0x9E3779B97F4A7C15ull;
    return float(h >> 40) * 0x1p-24f;
}

}  // namespace

std::shared_ptr<const Scene> Scene::freeze(SceneDescription description, int threads) {
    if (description.materials.empty()) description.materials.push_back({});
    check_description(description);
    std::shared_ptr<Scene> scene(new Scene);
    scene->d_ = std::move(description);
    scene->described_meshes_ = scene->d_.meshes.size();
    scene->described_materials_ = scene->d_.materials.size();
    scene->measure();
    scene->warn_of_size();
    scene->build_lights(threads);
    scene->add_sphere_light_meshes();
    scene->build_coats();
    uint64_t first = 0;
    for (const Mesh& mesh : scene->d_.meshes) {
        scene->first_triangle_.push_back(first);
        first += mesh.triangles.size();
    }
    return scene;
}

/// Area of all triangles of a mesh.
static double area_of(const Mesh& mesh) {
    double area = 0;
    for (const Vec3u t : mesh.triangles) {
        const Vec3 a = mesh.vertices[t.x], b = mesh.vertices[t.y] - a, c = mesh.vertices[t.z] - a;
        // In double: squares of products of the largest edges overflow floats
        const auto minor = [](float p, float q, float r, float s) {
            return double(p) * double(s) - double(q) * double(r);
        };
        const double x = minor(b.y, b.z, c.y, c.z), y = minor(b.z, b.x, c.z, c.x),
                     z = minor(b.x, b.y, c.x, c.y);
        area += 0.5 * std::sqrt(x * x + y * y + z * z);
    }
    return area;
}

void Scene::measure() {
    double placed_area = 0;
    for (const Mesh& mesh : d_.meshes) {
        unique_triangles_ += mesh.triangles.size();
        memory_bytes_ += mesh.vertices.size() * sizeof(Vec3) + mesh.triangles.size() * sizeof(Vec3u) +
                         mesh.normals.size() * sizeof(Vec3) + mesh.uvs.size() * sizeof(Vec2);
        if (!mesh.in_world) continue;
        placed_triangles_ += mesh.triangles.size();
        placed_area += area_of(mesh);
        for (Vec3u t : mesh.triangles)
            for (uint32_t v : {t.x, t.y, t.z}) bounds_.add(mesh.vertices[v]);
    }
    for (const Instance& instance : d_.instances) {
        const Vec3 x = instance.to_world.vector({1, 0, 0}), y = instance.to_world.vector({0, 1, 0}),
                   z = instance.to_world.vector({0, 0, 1});
        const double scale = std::cbrt(std::fabs(double(dot(x, cross(y, z)))));
        for (int index : instance.meshes) {
            const Mesh& mesh = d_.meshes[size_t(index)];
            placed_triangles_ += mesh.triangles.size();
            placed_area += scale * scale * area_of(mesh);
            for (Vec3 v : mesh.vertices) bounds_.add(instance.to_world.point(v));
        }
    }
    if (placed_triangles_) triangle_size_ = float(std::sqrt(placed_area / double(placed_triangles_)));
    for (const SphereLight& light : d_.sphere_lights)
        for (float side : {-light.radius, light.radius}) bounds_.add(light.center + Vec3{side, side, side});
    if (!bounds_.empty() && bounds_.magnitude() > kMaxVertex)
        throw SceneError("instances and sphere lights must stay below 1e12 in size, got " +
                         std::to_string(bounds_.magnitude()));
    for (const Image& image : d_.images) memory_bytes_ += image.memory_bytes();
    // Embree's BVH takes about 100 bytes per unique triangle (measured: 90–140) and 600 per instance.
    memory_bytes_ += 100 * unique_triangles_ + 600 * d_.instances.size();
}

/// Outside these lengths, products of edges and areas leave the range of single precision. Measured: images
/// of the Cornell box are bit-identical from 6e-8 to 4e9 units; small triangles need some of that range.
void Scene::warn_of_size() {
    constexpr float kSmallest = 1e-6f, kLargest = 1e9f;
    const float size = bounds_.empty() ? 0.f : bounds_.diagonal();
    if (size == 0 || (size >= kSmallest && bounds_.magnitude() <= kLargest)) return;
    std::ostringstream s;
    s << "the scene spans " << size << " units, up to " << bounds_.magnitude()
      << " from the origin; images are"
      << " reliable for scenes of " << kSmallest << " to " << kLargest << " units: scale it";
    // A scene made from the description of this one carries the warning already
    const auto same = [&](const Warning& w) { return w.text == s.str(); };
    if (std::none_of(d_.warnings.begin(), d_.warnings.end(), same)) d_.warnings.push_back({"", s.str()});
}

EmissiveImage Scene::emissive_image(const Mesh& mesh, Vec3u t) const {
    EmissiveImage picture;
    if (mesh.emission_texture < 0) return picture;
    picture.image = &d_.images[size_t(mesh.emission_texture)];
    picture.scale = mesh.emission;
    if (!mesh.uvs.empty())
        for (int k = 0; k < 3; ++k) picture.uv[k] = mesh.uvs[k == 0 ? t.x : k == 1 ? t.y : t.z];
    return picture;
}

/// Mean radiance of every triangle whose emission has an image.
void Scene::average_emission() {
    const auto has_image = [](const Mesh& m) { return m.emission_texture >= 0; };
    if (std::none_of(d_.meshes.begin(), d_.meshes.end(), has_image)) return;
    // Sphere lights follow as meshes without images
    emission_means_.resize(d_.meshes.size() + d_.sphere_lights.size());
    for (size_t i = 0; i < d_.meshes.size(); ++i) {
        const Mesh& mesh = d_.meshes[i];
        if (!has_image(mesh)) continue;
        const size_t samples = kEmissionSamples / std::max<size_t>(1, mesh.triangles.size());
        for (Vec3u t : mesh.triangles)
            emission_means_[i].push_back(mean_radiance(emissive_image(mesh, t), samples));
    }
}

void Scene::build_lights(int threads) {
    std::vector<double> power;
    average_emission();
    auto add = [&](size_t index, const Affine* to_world) {
        const Mesh& mesh = d_.meshes[index];
        if (!(max_component(mesh.emission) > 0)) return;
        const bool opaque = !has_cutout(uint32_t(index));
        for (size_t i = 0; i < mesh.triangles.size(); ++i) {
            const Vec3u t = mesh.triangles[i];
            Vec3 p[3] = {mesh.vertices[t.x], mesh.vertices[t.y], mesh.vertices[t.z]};
            if (to_world)
                for (Vec3& q : p) q = to_world->point(q);
            Vec3 n = cross(p[1] - p[0], p[2] - p[0]);
            if (to_world && to_world->determinant() < 0) n = -n;
            const float area = 0.5f * any_length(n);
            if (!(area > 0) || !std::isfinite(area)) continue;  // degenerate triangles emit nothing
            const Rgb radiance = mean_emission(uint32_t(index), uint32_t(i));
            if (!(max_component(radiance) > 0)) continue;
            area_lights_.triangles.push_back(
                {p[0], p[1], p[2], any_direction(n), radiance, area, mesh.emits_two_sided, opaque});
            if (!emission_means_.empty()) area_lights_.images.push_back(emissive_image(mesh, t));
            power.push_back(double(area) * luminance(radiance) * (mesh.emits_two_sided ? 2 : 1));
        }
    };
    for (size_t i = 0; i < d_.meshes.size(); ++i)
        if (d_.meshes[i].in_world) add(i, nullptr);
    for (const Instance& instance : d_.instances)
        for (int index : instance.meshes) add(size_t(index), &instance.to_world);
    for (const SphereLight& light : d_.sphere_lights) {
        if (!(max_component(light.radiance) > 0)) continue;
        area_lights_.spheres.push_back(light);
        power.push_back(4 * M_PI * double(light.radius) * light.radius * luminance(light.radiance));
    }
    if (!power.empty()) area_lights_.choice = Distribution1D(power);
    memory_bytes_ +=
        area_lights_.triangles.size() * sizeof(EmissiveTriangle) + area_lights_.choice.memory_bytes();

    if (!d_.environment || !(max_component(d_.environment->scale) > 0)) return;
    const Environment& e = *d_.environment;
    if (e.image >= 0) warn_of_few_rows(d_.images[size_t(e.image)], d_.warnings);
    environment_ = std::make_unique<EnvironmentMap>(
        e.image < 0
            ? EnvironmentMap::constant(e.scale)
            : EnvironmentMap::from_latlong(d_.images[size_t(e.image)], e.scale, e.to_world, 0, threads));
    memory_bytes_ += environment_->memory_bytes();
}

const LightTree& Scene::light_tree() const {
    std::call_once(light_tree_once_, [&] { light_tree_ = std::make_shared<const LightTree>(area_lights_); });
    return *light_tree_;
}

void Scene::add_sphere_light_meshes() {
    if (d_.sphere_lights.empty()) return;
    // Sphere lights reflect no light: they do not use a material of the description
    d_.materials.push_back({.base_color = {0, 0, 0}});
    for (const SphereLight& light : d_.sphere_lights) {
        d_.meshes.push_back(tessellate(light));
        d_.meshes.back().material = int(d_.materials.size()) - 1;
    }
}

void Scene::build_coats() {
    const auto coated = [](const Material& m) {
        return m.coat != CoatKind::kNone && m.coat != CoatKind::kFresnelMix;
    };
    if (std::none_of(d_.materials.begin(), d_.materials.end(), coated)) return;
    for (const Material& m : d_.materials)
        coats_.push_back(coated(m) ? &coat_of(m.coat, m.eta, m.roughness, m.nonlinear) : nullptr);
}

/// Applies images of roughness and the share of metal.
void Scene::mix_metal(const Material& material, SurfacePoint& s) const {
    float metallic = material.metallic;
    if (material.roughness_texture >= 0)
        s.roughness *= luminance(sample_image(d_.images[size_t(material.roughness_texture)], s.uv).rgb);
    if (material.metallic_roughness_texture >= 0) {
        const Rgb given = sample_image(d_.images[size_t(material.metallic_roughness_texture)], s.uv).rgb;
        s.roughness *= given.y * given.y;
        metallic *= given.z;
    }
    s.roughness = std::clamp(s.roughness, 1e-3f, 1.f);
    s.metallic = metallic = std::clamp(metallic, 0.f, 1.f);
    s.specular = s.specular * (1 - metallic) + s.base_color * metallic;
    s.base_color = s.base_color * (1 - metallic);
    s.transmission = s.transmission * (1 - metallic);
}

SurfacePoint Scene::surface(uint32_t mesh_index, uint32_t triangle, int instance, float u, float v) const {
    const Mesh& mesh = d_.meshes[mesh_index];
    const Vec3u t = mesh.triangles[triangle];
    const Affine* to_world = instance >= 0 ? &d_.instances[size_t(instance)].to_world : nullptr;
    Vec3 p[3] = {mesh.vertices[t.x], mesh.vertices[t.y], mesh.vertices[t.z]};
    if (to_world)
        for (Vec3& q : p) q = to_world->point(q);
    const float w = 1 - u - v;
    SurfacePoint s;
    s.position = p[0] * w + p[1] * u + p[2] * v;
    const Vec3 edge1 = p[1] - p[0], edge2 = p[2] - p[0];
    // In double, because the cross product of float edges cancels for thin triangles.
    const double a[3] = {edge1.x, edge1.y, edge1.z}, b[3] = {edge2.x, edge2.y, edge2.z};
    double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double norm = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (norm > 0) s.ng = {float(n[0] / norm), float(n[1] / norm), float(n[2] / norm)};
    if (to_world && to_world->determinant() < 0) s.ng = -s.ng;
    s.ns = s.ng;
    if (!mesh.normals.empty()) {
        Vec3 ns[3] = {mesh.normals[t.x], mesh.normals[t.y], mesh.normals[t.z]};
        if (to_world)
            for (Vec3& q : ns) q = to_world->normal(q);
        const Vec3 blended = ns[0] * w + ns[1] * u + ns[2] * v;
        const float blended_length = length(blended);
        if (blended_length > 1e-12f && std::isfinite(blended_length))
            s.ns = facing(blended / blended_length, s.ng);
    }
    if (!mesh.uvs.empty()) {
        const Vec2 uv[3] = {mesh.uvs[t.x], mesh.uvs[t.y], mesh.uvs[t.z]};
        s.uv = {uv[0].x * w + uv[1].x * u + uv[2].x * v, uv[0].y * w + uv[1].y * u + uv[2].y * v};
    }
    s.material = mesh.material;
    const Material& material = d_.materials[size_t(mesh.material)];
    s.base_color = material.base_color;
    s.transmission = material.transmission;
    if (material.base_texture >= 0) {
        const Rgb texel = sample_image(d_.images[size_t(material.base_texture)], s.uv).rgb;
        s.base_color = s.base_color * texel;
        s.transmission = s.transmission * texel;
    }
    s.specular = material.specular;
    s.roughness = material.roughness;
    if (material.mixes_metal()) mix_metal(material, s);
    s.emission = mesh.emission;
    if (mesh.emission_texture >= 0)
        s.emission = s.emission * sample_image(d_.images[size_t(mesh.emission_texture)], s.uv).rgb;
    s.emits_two_sided = mesh.emits_two_sided;
    return s;
}

ShadingPoint Scene::reflection(const SurfacePoint& s) const {
    const Material& material = d_.materials[size_t(s.material)];
    ShadingPoint sp;
    sp.base = s.base_color;
    sp.specular = s.specular;
    sp.roughness = s.roughness;
    sp.kind = material.kind;
    sp.eta = material.eta;
    sp.metal = metal(s.material);
    sp.beckmann = material.has_beckmann();
    sp.thin = material.thin;
    sp.transmission = s.transmission;
    if (material.coat == CoatKind::kFresnelMix)
        sp.mix = {true, s.metallic + (1 - s.metallic) * material.f90, max_component(material.specular),
                  material.f90};
    else
        sp.coat = coat(s.material);
    return sp;
}

bool Scene::has_cutout(uint32_t mesh) const {
    const Material& material = d_.materials[size_t(d_.meshes[mesh].material)];
    return material.alpha_texture >= 0 || material.opacity < 1;
}

bool Scene::solid_at(uint32_t mesh_index, uint32_t triangle, float u, float v) const {
    const Mesh& mesh = d_.meshes[mesh_index];
    const Material& material = d_.materials[size_t(mesh.material)];
    if (material.opacity < 1 && !(pattern(mesh_index, triangle, u, v) < material.opacity)) return false;
    if (material.alpha_texture < 0 || mesh.uvs.empty()) return true;
    const Vec3u t = mesh.triangles[triangle];
    const Vec2 uv[3] = {mesh.uvs[t.x], mesh.uvs[t.y], mesh.uvs[t.z]};
    const float w = 1 - u - v;
    const Image& image = d_.images[size_t(material.alpha_texture)];
    const Rgba texel = sample_image(
        image, {uv[0].x * w + uv[1].x * u + uv[2].x * v, uv[0].y * w + uv[1].y * u + uv[2].y * v});
    const bool has_alpha = image.channels == 2 || image.channels == 4;
    const float alpha = has_alpha ? texel.a : texel.rgb.x;
    if (material.alpha_cutoff < 0) return pattern(mesh_index, triangle, u, v) < alpha * material.opacity;
    return alpha >= material.alpha_cutoff;
}

}  // namespace viscache
