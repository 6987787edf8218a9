#pragma once
// Colours of vertices, four bytes each.
#include <cstdint>
#include <span>

#include "viscache/math/vec.h"
#include "viscache/scene/image.h"

namespace viscache {

/// Multiplies the base colour and the alpha of the material.
// Red, green and blue are encoded as sRGB. The bytes of scans stay as they are, and steps are those of a
// screen, which show no bands: half a step is 0.0045 of linear light near white and 0.00015 near black, where
// bytes of linear values are off by 0.002, a fifth of a colour of 0.01. Alpha is linear, since cut-offs
// compare it.
struct VertexColor {
    uint8_t r = 255, g = 255, b = 255, a = 255;

    bool operator==(const VertexColor&) const = default;
    Rgb rgb() const {
        const float* linear = byte_values(true);
        return {linear[r], linear[g], linear[b]};
    }
    float alpha() const { return byte_values(false)[a]; }
};
static_assert(sizeof(VertexColor) == 4);

/// The nearest one. Values outside of [0, 1] are clamped.
VertexColor vertex_color(Rgb linear, float alpha = 1);

/// Whether any of these lets light through.
bool has_alpha(std::span<const VertexColor> colors);

}  // namespace viscache
