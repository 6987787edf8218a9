#pragma once
// Validation of rays and segments that come from outside. Embree's live asserts would abort the process.
#include <optional>
#include <span>
#include <string>

#include "viscache/visibility/query.h"

namespace viscache {

/// Index of the first vector that is not finite or larger than kMaxCoordinate; empty when all are fine.
inline std::optional<size_t> first_unusable(std::span<const Vec3> vectors) {
    for (size_t i = 0; i < vectors.size(); ++i)
        if (!(max_abs(vectors[i]) <= kMaxCoordinate) || !is_finite(vectors[i])) return i;
    return std::nullopt;
}

}  // namespace viscache
