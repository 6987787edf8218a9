#pragma once
// Validation of rays and segments that come from outside. Embree's live asserts would abort the process.
#include <optional>
#include <span>
#include <string>

#include "viscache/visibility/query.h"

namespace viscache {

/// True if all components are finite and at most kMaxCoordinate in size. Without branches: runs as fast as
/// memory.
inline bool all_usable(std::span<const Vec3> vectors) {
    static_assert(sizeof(Vec3) == 3 * sizeof(float));
    const float* v = reinterpret_cast<const float*>(vectors.data());
    int unusable = 0;
    for (size_t i = 0; i < 3 * vectors.size(); ++i) unusable |= !(std::fabs(v[i]) <= kMaxCoordinate);
    return !unusable;
}

/// Index of the first vector that is not finite or larger than kMaxCoordinate; empty when all are fine.
inline std::optional<size_t> first_unusable(std::span<const Vec3> vectors) {
    for (size_t i = 0; i < vectors.size(); ++i)
        if (!(max_abs(vectors[i]) <= kMaxCoordinate) || !is_finite(vectors[i])) return i;
    return std::nullopt;
}

}  // namespace viscache
