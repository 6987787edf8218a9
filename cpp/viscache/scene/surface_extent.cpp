#include "viscache/scene/surface_extent.h"

namespace viscache {

namespace {

constexpr double kLeastShare = 0x1p-20;  // of a triangle's size
constexpr double kMostSizes = 4;         // the same, for needles
constexpr double kRoundings = 3 / 16.0;  // three times half an ulp in units of eight ulps

/// |M| |M⁻¹| (|p| + |t|), its largest component. A singular transform has no surface that rays could leave.
double moved(Vec3 p, const Affine& m) {
    const double det = std::fabs(m.determinant());
    if (!(det > 0)) return 0;
    double back[3] = {}, most = 0;
    for (int l = 0; l < 3; ++l) {
        const auto row = m.cofactors(l);
        for (size_t j = 0; j < 3; ++j)
            back[j] += std::fabs(row[j]) * (std::fabs(double(p[l])) + std::fabs(m.m[size_t(l)][3]));
    }
    for (const auto& row : m.m) {
        double sum = 0;
        for (size_t j = 0; j < 3; ++j) sum += std::fabs(row[j]) * back[j];
        most = std::max(most, sum / det);
    }
    return most;
}

}  // namespace

float surface_extent(Vec3 a, Vec3 b, Vec3 c) {
    double edge[3][3], size[3], n[3], norm2 = 0, longest = 0, sum = 0;
    for (int k = 0; k < 3; ++k) {
        edge[0][k] = double(c[k]) - a[k];
        edge[1][k] = double(a[k]) - b[k];
        edge[2][k] = double(b[k]) - c[k];
        size[k] = std::max({std::fabs(edge[0][k]), std::fabs(edge[1][k]), std::fabs(edge[2][k])});
        longest = std::max(longest, size[k]);
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        n[k] = edge[0][i] * edge[1][j] - edge[0][j] * edge[1][i];
        norm2 += n[k] * n[k];
    }
    if (!(norm2 > 0)) return float(longest);
    const double inverse = 1 / std::sqrt(norm2);
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        const auto products = [&](const double* e, const double* f) {
            return std::fabs(e[i] * f[j]) + std::fabs(e[j] * f[i]);
        };
        // Embree takes the two edges whose products are smaller
        const double least = std::min(products(edge[0], edge[1]), products(edge[1], edge[2]));
        sum += size[k] * (std::fabs(n[k]) + least) * inverse;
    }
    return float(std::min(0.5 * sum, kMostSizes * longest) + kLeastShare * longest);
}

float surface_extent(Vec3 a, Vec3 b, Vec3 c, const Affine& to_world) {
    const Vec3 p = to_world.point(a), q = to_world.point(b), r = to_world.point(c);
    const double mesh = to_world.most_stretch() * double(surface_extent(a, b, c));
    const Vec3 farthest = max(max(max(p, -p), max(q, -q)), max(r, -r));
    return float(std::max(mesh, double(surface_extent(p, q, r))) + kRoundings * moved(farthest, to_world));
}

float instance_extent(float mesh, const Bounds& placed, const Affine& to_world) {
    return float(to_world.most_stretch() * double(mesh) +
                 kRoundings * moved(max(max(placed.lo, -placed.lo), max(placed.hi, -placed.hi)), to_world));
}

}  // namespace viscache
