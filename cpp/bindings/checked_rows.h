#pragma once
// Checks of vectors from outside: usable positions and unit vectors.
#include <span>

#include "arrays.h"
#include "viscache/casters/check_rays.h"

namespace viscache::bindings {

/// Positions as the core takes them: it divides and squares coordinates, so they must not be too large.
inline std::span<const Vec3> usable(const FloatArray& a, const char* name) {
    const std::span<const Vec3> rows(rows3(a, name), size_t(a.shape(0)));
    if (const auto i = first_unusable(rows))
        throw py::value_error(std::string(name) + " must be finite and at most 1e16 in size, row " +
                              std::to_string(*i) + " is not");
    return rows;
}

/// Normals and directions. A thousandth off is rounding of users' files; more is an error.
inline std::span<const Vec3> units(const FloatArray& a, const char* name) {
    const std::span<const Vec3> rows = usable(a, name);
    for (size_t i = 0; i < rows.size(); ++i)
        if (!(std::fabs(length2(rows[i]) - 1) < 1e-3f))
            throw py::value_error(std::string(name) + " must be unit vectors, row " + std::to_string(i) +
                                  " has length " + std::to_string(length(rows[i])));
    return rows;
}

}  // namespace viscache::bindings
