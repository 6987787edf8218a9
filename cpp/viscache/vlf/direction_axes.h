#pragma once
// Directions shared by all points, as axes: opposite directions share one axis.
#include <span>
#include <vector>

#include "viscache/math/frame.h"

namespace viscache {

/// Two directions are opposite if each component cancels to within this bound, which allows for the rounding
/// of the directions given. It moves a ray by less than the rotation of points does.
constexpr float kOppositeSlack = 3e-7f;

/// An axis, with the directions along it and against it.
struct SharedAxis {
    static constexpr uint32_t kNone = 0xffffffffu;
    Frame3 frame;                             ///< z is the unit direction `along`
    float length = 1;                         ///< length of the direction as given
    uint32_t along = kNone, against = kNone;  ///< indices of directions; `against` may be kNone
};

/// One axis for every pair of opposite directions, and one for every other direction. The directions may
/// have any length > 0. The axes are in the order of `along`.
std::vector<SharedAxis> axes_of(std::span<const Vec3> directions);

}  // namespace viscache
