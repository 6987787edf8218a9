#pragma once
// Images of a scene: pixels as bytes where the file has 8 bits, as floats otherwise; both are read as linear
// floats.
#include <cstdint>
#include <string>
#include <vector>

#include "viscache/math/vec.h"

namespace viscache {

/// The linear values of the 256 bytes: sRGB-encoded, or n/255.
const float* byte_values(bool srgb);

float srgb_to_linear(float encoded);
float linear_to_srgb(float linear);

/// What an image shows beyond its borders.
enum class Wrap : uint8_t { kRepeat, kMirror, kClamp };

struct Image {
    std::string path;                         ///< file that the scene names; empty for images given as arrays
    std::string where;                        ///< "file:line" that names the file
    bool srgb = true;                         ///< `bytes` are sRGB-encoded colour (false: linear data)
    int width = 0, height = 0, channels = 0;  ///< 0 until decoded
    std::vector<float> pixels;                ///< row-major, row 0 at the top, linear
    std::vector<uint8_t> bytes{};             ///< the same, of 8 bits; only one of the two has values
    bool nearest = false;                     ///< look-ups take the nearest pixel, without interpolation
    Wrap wrap_u = Wrap::kRepeat;
    Wrap wrap_v = Wrap::kRepeat;

    /// Number of values: width x height x channels.
    size_t size() const { return bytes.empty() ? pixels.size() : bytes.size(); }
    size_t memory_bytes() const { return pixels.size() * sizeof(float) + bytes.size(); }
    bool is_alpha(int channel) const { return (channels == 2 || channels == 4) && channel == channels - 1; }
    /// Linear values of the bytes of a channel. Alpha is never encoded.
    const float* values_of(int channel) const { return byte_values(srgb && !is_alpha(channel)); }
    /// Linear value `i`, in the order of `pixels`.
    float value(size_t i) const {
        return bytes.empty() ? pixels[i] : values_of(int(i % size_t(channels)))[bytes[i]];
    }
};

/// Bilinear lookup, or the nearest pixel; row 0 of the image is v = 1. Returns RGBA; missing
/// channels are grey or 1.
struct Rgba {
    Rgb rgb;
    float a = 1;
};
Rgba sample_image(const Image& image, Vec2 uv);

}  // namespace viscache
