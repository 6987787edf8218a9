#include "viscache/scene/vertex_color.h"

#include <algorithm>
#include <cmath>

namespace viscache {

namespace {

/// NaN is 0.
uint8_t byte_of(float share) { return share > 0 ? uint8_t(std::lround(255 * std::min(share, 1.f))) : 0; }

}  // namespace

VertexColor vertex_color(Rgb c, float alpha) {
    return {byte_of(linear_to_srgb(c.x)), byte_of(linear_to_srgb(c.y)), byte_of(linear_to_srgb(c.z)),
            byte_of(alpha)};
}

bool has_alpha(std::span<const VertexColor> colors) {
    return std::any_of(colors.begin(), colors.end(), [](VertexColor c) { return c.a < 255; });
}

}  // namespace viscache
