#pragma once
// Decodes PNG, JPEG, TGA, BMP and Radiance HDR images.
#include <string>
#include <string_view>

#include "viscache/formats/loading.h"

namespace viscache::loading {

/// Decodes a file in memory; its content tells the format. Values of 8 bits stay bytes, others become linear
/// floats. Colour of 8 and 16 bits is encoded when `srgb` is set; alpha and HDR values are linear.
Image decode_image(std::string_view bytes, const std::string& where, bool srgb);

/// Decodes every pending image of the scene except EXR images. When strict, a missing or unreadable file is
/// an error. Otherwise it is reported as a warning, and the texture (or the environment) is dropped.
void decode_images(Loading& loading);

/// Mean over the pixels for each channel; alpha is 1 if the image has none.
struct ImageMean {
    Rgb color;
    float alpha = 1;
};
ImageMean mean_of(const Image& image);

}  // namespace viscache::loading
