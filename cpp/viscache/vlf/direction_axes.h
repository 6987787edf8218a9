#pragma once
// Directions that all points share, as axes: opposite ones go together.
#include <span>
#include <vector>

#include "viscache/math/frame.h"

namespace viscache {

/// Directions are opposite if each component cancels to within this: rounding of what was meant to be so.
/// It moves a ray by less than the rotation of points does.
constexpr float kOppositeSlack = 3e-7f;

/// An axis and the directions that run along it and against it.
struct SharedAxis {
    static constexpr uint32_t kNone = 0xffffffffu;
    Frame3 frame;                             ///< z is the unit direction `along`
    float length = 1;                         ///< of the direction as given
    uint32_t along = kNone, against = kNone;  ///< numbers of directions; `against` may be kNone
};

/// One axis for every direction that has no opposite, and one for every pair of opposites. Directions of any
/// length > 0; in the order of `along`.
std::vector<SharedAxis> axes_of(std::span<const Vec3> directions);

}  // namespace viscache
