#pragma once
// Places in a lat-long image of directions that lie along a row of the equal-area octahedral map. The loops
// are vectorised; the variant is chosen at run time.
#include <cstddef>
#include <cstdint>
#include <span>

#include "viscache/math/affine.h"
#include "viscache/math/isa.h"

namespace viscache {

/// Turns directions of the world into those of an image's frame (convention in description.h).
struct LatLongTurn {
    float rows[3][3];
    /// `to_world` is a rotation, times a scale > 0 that does not matter: the transpose inverts it.
    explicit LatLongTurn(const Affine& to_world);
};

/// Points ((first + i) · step, y) for i < n of the octahedral square [0, 1]²: column u[i] and row v[i] in
/// [0, 1] of their directions. Within 2e-6 of exact arithmetic, where u may differ by 1. All variants give
/// the same bits.
void latlong_batch(const LatLongTurn& turn, float y, float first, float step, size_t n, float* u, float* v,
                   Isa isa = active_isa());

/// The four pixels around each place (u, v) of an image, as row-major indices, and the shares of the right
/// column and the lower row in a bilinear look-up. Columns wrap around; rows are clamped at the poles.
struct BilinearPlaces {
    static constexpr size_t kMost = 512;
    alignas(64) int32_t up_left[kMost], up_right[kMost], down_left[kMost], down_right[kMost];
    alignas(64) float right[kMost], down[kMost];
    int32_t greatest;  ///< index
};
/// At most kMost places of an image of at most 2³¹ pixels. All variants give the same bits.
void bilinear_places(std::span<const float> u, std::span<const float> v, int width, int height,
                     BilinearPlaces& out, Isa isa = active_isa());

typedef float ColorLanes __attribute__((vector_size(16)));  ///< a colour and a number without meaning

/// The bilinear look-up at place k, where pixel(i) is the colour of pixel i.
template <class Pixel>
inline __attribute__((always_inline)) ColorLanes bilinear(const BilinearPlaces& p, size_t k, Pixel pixel) {
    const float fx = p.right[k], fy = p.down[k], gx = 1 - fx, gy = 1 - fy;
    return (pixel(p.up_left[k]) * gx + pixel(p.up_right[k]) * fx) * gy +
           (pixel(p.down_left[k]) * gx + pixel(p.down_right[k]) * fx) * fy;
}

/// Adds to each sum the look-ups at the next `each` places in an image of three floats per pixel. Reads a
/// float behind each pixel: `greatest` must not be the last one.
void sum_bilinear(const float* rgb, const BilinearPlaces& places, size_t each, std::span<ColorLanes> sums,
                  Isa isa = active_isa());

}  // namespace viscache
