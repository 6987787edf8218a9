#pragma once
// Validation of rays and segments from user input. The asserts in Embree's release builds would abort the
// process.
#include <optional>
#include <span>

#include "viscache/casters/ray_arrays.h"
#include "viscache/visibility/query.h"

namespace viscache {

/// Index of the first vector that is not finite or larger than kMaxCoordinate; empty if there is none.
inline std::optional<size_t> first_unusable(std::span<const Vec3> vectors) {
    for (size_t i = 0; i < vectors.size(); ++i)
        if (!(max_abs(vectors[i]) <= kMaxCoordinate) || !is_finite(vectors[i])) return i;
    return std::nullopt;
}

/// The same for rows of a caller's array.
inline std::optional<size_t> first_unusable(const Rows& rows, size_t n) {
    for (size_t i = 0; i < n; ++i)
        if (const Vec3 row = rows[i]; first_unusable({&row, 1})) return i;
    return std::nullopt;
}

}  // namespace viscache
