#pragma once
// Affine transforms: three rows of four numbers, applied to column vectors.
#include <array>

#include "viscache/math/vec.h"

namespace viscache {

struct Affine {
    /// m[row][column]; column 3 is the translation. The identity by default.
    std::array<std::array<double, 4>, 3> m = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

    Vec3 point(Vec3 p) const { return apply(p, 1.0); }
    Vec3 vector(Vec3 v) const { return apply(v, 0.0); }
    /// Normals transform by the inverse transpose = cofactors / determinant. The result is not normalised.
    Vec3 normal(Vec3 n) const;
    double determinant() const {
        return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    }
    /// Lower and upper bounds on how much the transform stretches lengths: 1 / |M⁻¹| and |M| by the
    /// Frobenius norm, each tight up to a factor of √3. The lower bound is 0 for a singular transform.
    double least_stretch() const;
    double most_stretch() const {
        double sum = 0;
        for (const auto& row : m) sum += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
        return std::sqrt(sum);
    }

    /// Row i of the cofactor matrix: column i of the inverse, times the determinant.
    std::array<double, 3> cofactors(int i) const {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        return {m[j][1] * m[k][2] - m[j][2] * m[k][1], m[j][2] * m[k][0] - m[j][0] * m[k][2],
                m[j][0] * m[k][1] - m[j][1] * m[k][0]};
    }

private:
    Vec3 apply(Vec3 v, double w) const {
        double r[3];
        for (int i = 0; i < 3; ++i) r[i] = m[i][0] * v.x + m[i][1] * v.y + m[i][2] * v.z + m[i][3] * w;
        return {float(r[0]), float(r[1]), float(r[2])};
    }
};

inline Vec3 Affine::normal(Vec3 n) const {
    // The determinant itself is left out, since the result is not normalised; its sign decides the side for
    // mirrored instances.
    const double sign = determinant() < 0 ? -1 : 1;
    double r[3];
    for (int i = 0; i < 3; ++i) {
        const auto c = cofactors(i);
        r[i] = sign * (c[0] * n.x + c[1] * n.y + c[2] * n.z);
    }
    return {float(r[0]), float(r[1]), float(r[2])};
}

inline double Affine::least_stretch() const {
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        for (double c : cofactors(i)) sum += c * c;
    return sum > 0 ? std::fabs(determinant()) / std::sqrt(sum) : 0;
}

/// The transform that applies `b` first, then `a`.
inline Affine operator*(const Affine& a, const Affine& b) {
    Affine c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 4; ++j) {
            c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
            if (j == 3) c.m[i][j] += a.m[i][3];
        }
    return c;
}

}  // namespace viscache
