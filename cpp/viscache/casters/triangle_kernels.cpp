#include "viscache/casters/triangle_kernels.h"

namespace viscache {

WaldTriangle wald_triangle(Vec3 a, Vec3 b, Vec3 c, uint32_t id) {
    double e1[3], e2[3], n[3];
    for (int i = 0; i < 3; ++i) {
        e1[i] = double(b[i]) - a[i];
        e2[i] = double(c[i]) - a[i];
    }
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = e1[j] * e2[k] - e1[k] * e2[j];
    }
    int k = std::fabs(n[1]) > std::fabs(n[0]) ? 1 : 0;
    if (std::fabs(n[2]) > std::fabs(n[k])) k = 2;
    const int u = (k + 1) % 3, v = (k + 2) % 3;
    // Without area these are infinite or NaN, and all comparisons fail
    const double b_u = e2[v] / n[k], b_v = -e2[u] / n[k], c_u = -e1[v] / n[k], c_v = e1[u] / n[k];
    WaldTriangle tri{};
    tri.axis = uint32_t(k);
    tri.id = id;
    tri.n_u = float(n[u] / n[k]);
    tri.n_v = float(n[v] / n[k]);
    tri.n_d = float(a[k] + n[u] / n[k] * a[u] + n[v] / n[k] * a[v]);
    tri.b_u = float(b_u);
    tri.b_v = float(b_v);
    tri.b_d = float(-(a[u] * b_u + a[v] * b_v));
    tri.c_u = float(c_u);
    tri.c_v = float(c_v);
    tri.c_d = float(-(a[u] * c_u + a[v] * c_v));
    return tri;
}

ShearedRay::ShearedRay(const Ray& ray) : o(ray.o), d(ray.d), t_min(ray.t_min) {
    const Vec3 size{std::fabs(ray.d.x), std::fabs(ray.d.y), std::fabs(ray.d.z)};
    z = size.x > size.y ? (size.x > size.z ? 0 : 2) : (size.y > size.z ? 1 : 2);
    x = (z + 1) % 3;
    y = (z + 2) % 3;
    const float along = ray.d[int(z)];
    if (along < 0) std::swap(x, y);
    o_x = component(ray.o, x);
    o_y = component(ray.o, y);
    o_z = component(ray.o, z);
    s_x = ray.d[int(x)] / along;
    s_y = ray.d[int(y)] / along;
}

float plane_distance(const WatertightTriangle& tri, const ShearedRay& ray) {
    double e1[3], e2[3], height = 0, towards = 0;
    for (int k = 0; k < 3; ++k) {
        e1[k] = double(tri.b[k]) - tri.a[k];
        e2[k] = double(tri.c[k]) - tri.a[k];
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const double n = e1[i] * e2[j] - e1[j] * e2[i];
        height += n * (double(tri.a[k]) - ray.o[k]);
        towards += n * ray.d[k];
    }
    return float(height / towards);
}

bool within_in_double(const std::array<float, 6>& sheared, TriangleHit& hit) {
    const double ax = sheared[0], ay = sheared[1], bx = sheared[2], by = sheared[3], cx = sheared[4],
                 cy = sheared[5];
    // Products of floats are exact in double
    const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
    const double det = u + v + w;
    if (det == 0) return false;  // edge-on
    hit.u = float(v / det);
    hit.v = float(w / det);
    return true;
}

}  // namespace viscache
