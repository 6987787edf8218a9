// Triangulates polygons and builds the analytic shapes of scene files.
#include "viscache/formats/loading.h"

namespace viscache::loading {

namespace {

constexpr int kSphereSlices = 64, kSphereStacks = 32;
constexpr int kDiskSlices = 64, kRevolvedSlices = 64;

/// Newell's normal: twice the area vector of the polygon.
Vec3 area_vector(const std::vector<Vec3>& p) {
    Vec3 n{};
    for (size_t i = 1; i + 1 < p.size(); ++i) n += cross(p[i] - p[0], p[i + 1] - p[0]);
    return n;
}

float turn(Vec3 a, Vec3 b, Vec3 c, Vec3 n) { return dot(cross(b - a, c - a), n); }

bool is_convex(const std::vector<Vec3>& p, Vec3 n) {
    for (size_t i = 0; i < p.size(); ++i)
        if (turn(p[i], p[(i + 1) % p.size()], p[(i + 2) % p.size()], n) < 0) return false;
    return true;
}

/// True if corner `i` of the ring is an ear: it is convex and no other corner lies in its triangle.
bool is_ear(const std::vector<Vec3>& p, const std::vector<uint32_t>& ring, size_t i, Vec3 n) {
    const size_t m = ring.size(), before = (i + m - 1) % m, after = (i + 1) % m;
    const Vec3 a = p[ring[before]], b = p[ring[i]], c = p[ring[after]];
    if (turn(a, b, c, n) <= 0) return false;
    for (size_t k = 0; k < m; ++k) {
        if (k == before || k == i || k == after) continue;
        const Vec3 q = p[ring[k]];
        if (q == a || q == b || q == c) continue;
        if (turn(a, b, q, n) >= 0 && turn(b, c, q, n) >= 0 && turn(c, a, q, n) >= 0) return false;
    }
    return true;
}

}  // namespace

void triangulate(const std::vector<Vec3>& polygon, std::vector<Vec3u>& triangles) {
    const auto n = uint32_t(polygon.size());
    const Vec3 normal = area_vector(polygon);
    std::vector<uint32_t> ring(n);
    for (uint32_t i = 0; i < n; ++i) ring[i] = i;
    // Clip ears of concave polygons. Polygons with many corners or without an ear become a fan.
    if (n > 3 && n <= 1024 && !is_convex(polygon, normal)) {
        while (ring.size() > 3) {
            size_t i = 0;
            while (i < ring.size() && !is_ear(polygon, ring, i, normal)) ++i;
            if (i == ring.size()) break;
            const size_t m = ring.size();
            triangles.push_back({ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]});
            ring.erase(ring.begin() + std::ptrdiff_t(i));
        }
    }
    for (size_t i = 1; i + 1 < ring.size(); ++i) triangles.push_back({ring[0], ring[i], ring[i + 1]});
}

void smooth_normals(Mesh& mesh) {
    std::vector<Vec3> sums(mesh.vertices.size());
    for (Vec3u t : mesh.triangles) {
        const uint32_t corners[3] = {t.x, t.y, t.z};
        const Vec3 p[3] = {mesh.vertices[t.x], mesh.vertices[t.y], mesh.vertices[t.z]};
        const Vec3 normal = cross(p[1] - p[0], p[2] - p[0]);
        const float area = length(normal);
        if (!(area > 0)) continue;
        for (int k = 0; k < 3; ++k) {
            const Vec3 a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
            sums[corners[k]] += normal * (std::atan2(area, dot(a, b)) / area);
        }
    }
    // A vertex without a triangle of its own may have any normal
    for (Vec3& n : sums) n = length2(n) > 0 ? normalize(n) : Vec3{0, 0, 1};
    mesh.normals = std::move(sums);
}

Mesh rectangle_mesh() {
    Mesh m;
    m.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    m.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    return m;
}

Mesh cube_mesh() {
    // The corners of every face, in the order of Mitsuba's texture coordinates
    constexpr float kFaces[6][4][3] = {{{1, -1, -1}, {1, -1, 1}, {-1, -1, 1}, {-1, -1, -1}},
                                       {{1, 1, -1}, {-1, 1, -1}, {-1, 1, 1}, {1, 1, 1}},
                                       {{1, -1, -1}, {1, 1, -1}, {1, 1, 1}, {1, -1, 1}},
                                       {{1, -1, 1}, {1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}},
                                       {{-1, -1, 1}, {-1, 1, 1}, {-1, 1, -1}, {-1, -1, -1}},
                                       {{1, 1, -1}, {1, -1, -1}, {-1, -1, -1}, {-1, 1, -1}}};
    Mesh m;
    for (const auto& face : kFaces) {
        Mesh side;
        for (const auto& p : face) side.vertices.push_back({p[0], p[1], p[2]});
        side.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
        side.triangles = {{0, 1, 2}, {3, 0, 2}};
        append_mesh(m, side);
    }
    return m;
}

Mesh sphere_mesh(Vec3 center, float radius) {
    Mesh m;
    for (int j = 0; j <= kSphereStacks; ++j)
        for (int i = 0; i <= kSphereSlices; ++i) {
            const float v = float(j) / kSphereStacks, u = float(i) / kSphereSlices;
            const float phi = 2 * kPi * float(i % kSphereSlices) / kSphereSlices;
            const float s = j == 0 || j == kSphereStacks ? 0.f : std::sin(kPi * v);
            m.normals.push_back({s * std::cos(phi), s * std::sin(phi), std::cos(kPi * v)});
            m.uvs.push_back({u, 1 - v});
        }
    const auto row = uint32_t(kSphereSlices + 1);
    for (uint32_t j = 0; j < uint32_t(kSphereStacks); ++j)
        for (uint32_t i = 0; i < uint32_t(kSphereSlices); ++i) {
            const uint32_t a = j * row + i, b = a + row;
            if (j > 0) m.triangles.push_back({a, b, a + 1});
            if (j + 1 < uint32_t(kSphereStacks)) m.triangles.push_back({a + 1, b, b + 1});
        }
    // The mean shadow of a convex body is a quarter of its area: both become those of the sphere
    double area = 0;
    for (const Vec3u t : m.triangles)
        area += length(cross(m.normals[t.y] - m.normals[t.x], m.normals[t.z] - m.normals[t.x])) / 2;
    const float widened = radius * float(std::sqrt(4 * M_PI / area));
    for (const Vec3 n : m.normals) m.vertices.push_back(center + n * widened);
    return m;
}

Mesh revolved_mesh(const std::vector<ProfilePoint>& profile, double phi_max) {
    Mesh m;
    const double step = phi_max / kRevolvedSlices;
    // A chord of this radius is as long as the arc
    const double widened = step / 2 / std::sin(step / 2);
    const bool closed = phi_max > 6.2831;
    for (size_t j = 0; j < profile.size(); ++j)
        for (int i = 0; i <= kRevolvedSlices; ++i) {
            const ProfilePoint& p = profile[j];
            const double phi = closed && i == kRevolvedSlices ? 0 : i * step;
            const double c = std::cos(phi), s = std::sin(phi), r = p.r * widened;
            m.vertices.push_back({float(r * c), float(r * s), float(p.z)});
            m.normals.push_back(normalize(Vec3{float(p.dz * c), float(p.dz * s), float(-p.dr)}));
            m.uvs.push_back(
                {float(i) / kRevolvedSlices, float(j) / float(std::max<size_t>(profile.size() - 1, 1))});
        }
    const auto row = uint32_t(kRevolvedSlices + 1);
    for (uint32_t j = 0; j + 1 < uint32_t(profile.size()); ++j)
        for (uint32_t i = 0; i < uint32_t(kRevolvedSlices); ++i) {
            const uint32_t a = j * row + i, b = a + row;
            if (profile[j].r > 0) m.triangles.push_back({a, a + 1, b + 1});
            if (profile[j + 1].r > 0) m.triangles.push_back({a, b + 1, b});
        }
    return m;
}

Mesh disk_mesh() {
    Mesh m;
    const float step = 2 * kPi / kDiskSlices, widened = std::sqrt(step / std::sin(step));
    m.vertices.push_back({0, 0, 0});
    for (int i = 0; i < kDiskSlices; ++i) {
        const float phi = 2 * kPi * float(i) / kDiskSlices;
        m.vertices.push_back({widened * std::cos(phi), widened * std::sin(phi), 0});
        m.triangles.push_back({0, uint32_t(i) + 1, uint32_t(i + 1) % kDiskSlices + 1});
    }
    return m;
}

Mesh polar_disk_mesh() {
    Mesh m;
    const Mesh plain = disk_mesh();
    const auto n = uint32_t(plain.triangles.size());
    for (uint32_t i = 0; i < n; ++i) {
        const Vec3u t = plain.triangles[i];
        const uint32_t first = 3 * i;
        for (uint32_t corner : {t.x, t.y, t.z}) m.vertices.push_back(plain.vertices[corner]);
        // The angle at the centre is that of the middle of the slice
        const float from = float(i) / float(n), step = 1 / float(n);
        m.uvs.insert(m.uvs.end(), {{0, from + step / 2}, {1, from}, {1, from + step}});
        m.triangles.push_back({first, first + 1, first + 2});
    }
    return m;
}

}  // namespace viscache::loading
