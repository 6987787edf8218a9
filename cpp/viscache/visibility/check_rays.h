#pragma once
// Validation of rays and segments from user input. The asserts in Embree's release builds would abort the
// process.
#include <optional>
#include <span>
#include <string>

#include "viscache/visibility/query.h"

namespace viscache {

/// True if all components are finite and at most kMaxCoordinate in size. Branch-free, so it runs at memory
/// speed.
inline bool all_usable(std::span<const Vec3> vectors) {
    static_assert(sizeof(Vec3) == 3 * sizeof(float));
    const float* v = reinterpret_cast<const float*>(vectors.data());
    int unusable = 0;
    for (size_t i = 0; i < 3 * vectors.size(); ++i) unusable |= !(std::fabs(v[i]) <= kMaxCoordinate);
    return !unusable;
}

/// Index of the first vector that is not finite or larger than kMaxCoordinate; empty if there is none.
inline std::optional<size_t> first_unusable(std::span<const Vec3> vectors) {
    for (size_t i = 0; i < vectors.size(); ++i)
        if (!(max_abs(vectors[i]) <= kMaxCoordinate) || !is_finite(vectors[i])) return i;
    return std::nullopt;
}

}  // namespace viscache
