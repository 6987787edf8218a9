#pragma once
// Resamples a lat-long image to texels of the equal-area octahedral map.
#include "viscache/math/affine.h"
#include "viscache/scene/description.h"
#include "viscache/scene/octahedral_texels.h"

namespace viscache {

struct ResampledImage {
    OctahedralTexels texels;
    double power_ratio = 1;  ///< power of the texels over that of the image, before the correction
};

/// False for a colour that light cannot have.
bool usable_radiance(Rgb c);

/// Integral of the luminance of rows [first, last) over the sphere.
double latlong_power(const Image& image, Rgb scale, int first, int last);

/// See `EnvironmentMap::from_latlong`.
ResampledImage resample_latlong(const Image& image, Rgb scale, const Affine& to_world, int resolution,
                                int threads);

}  // namespace viscache
