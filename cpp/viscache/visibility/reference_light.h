#pragma once
// The light that tells how much a wrong answer matters at an eye point.
#include <algorithm>
#include <cmath>

namespace viscache {

/// min(sqrt(a·(b + m/20)), m), with a the light that would reach the pixel from an eye point without shadows,
/// b the part of it that is thought to be visible, and m the mean of a over the picture.
///
/// A wrong answer about a contribution c, checked with probability q, adds c²/q to the variance of its pixel.
/// For a number of rays the sum over the picture is least with q proportional to c/m, the same m everywhere.
/// The sum relative to each pixel's own light, with 5 % of the mean added, is least with c/(b + m/20). The
/// minimum serves both. The root of a·b in place of b was found by trials: b alone draws too many checks
/// where little of the light is visible (docs/performance/progressive.md).
inline float reference_light(float seen, float all, float mean) {
    constexpr float kFloor = 1.f / 20;
    return std::min(std::sqrt(all * (seen + kFloor * mean)), mean);
}

}  // namespace viscache
