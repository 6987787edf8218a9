#pragma once
// PNG, JPEG, TGA, BMP and Radiance HDR images to linear float pixels.
#include <string>
#include <string_view>

#include "viscache/scene/loading.h"

namespace viscache::loading {

/// Decodes a file in memory: 8- and 16-bit colour to linear when `srgb`, alpha as it is; HDR as it is.
Image decode_image(std::string_view bytes, const std::string& where, bool srgb);

/// Decodes every pending image of the scene but EXR ones. A missing or unreadable file is an error when
/// strict; otherwise it is named, and the texture (or the environment) is dropped.
void decode_images(Loading& loading);

/// Mean over the pixels, channel by channel (alpha included, 1 without).
struct ImageMean {
    Rgb color;
    float alpha = 1;
};
ImageMean mean_of(const Image& image);

}  // namespace viscache::loading
