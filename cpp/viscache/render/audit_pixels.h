#pragma once
// Draws the pixels of an audit: a stratified random sample along the Morton curve of a picture, by light
// without shadows.
//
// That light bounds the error of a pixel, also where the oracle hides a lamp: light as the oracle saw it
// would be least there. The probability of a pixel is the most such light within `kAuditReach`, plus the mean
// of all. A stratum is a run of the curve with its share of the probability. Two pixels are drawn of each, so
// that their difference estimates the variance within the stratum (Hansen, Hurwitz 1943).
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "viscache/render/tiles.h"

namespace viscache {

struct AuditPixel {
    uint32_t x, y;
    double weight;  ///< Σ weight · value over the drawn pixels estimates the sum over all
};

/// The pixels of some tiles of a picture along its Morton curve. Edges of tiles are powers of two.
std::vector<std::pair<uint32_t, uint32_t>> along_curve(std::span<const Tile> tiles);

/// Fewer pixels give no interval: they are drawn by the light that the frame has, at no cost.
constexpr size_t kLeastByUnoccluded = 1024;

/// In pixels along x and y. Chosen in garage, church, classroom_like, mushrooms, stairs and others: with 0,
/// one interval of 4096 pixels held .54 of the time (docs/performance/meter.md).
constexpr int kAuditReach = 2;

/// n pixels, an odd number rounded up, pairs of one stratum one after the other; or all pixels, with weights
/// of 1, if there are no more. `light`: without shadows, of all pixels of the picture, `width` in a row;
/// values that are negative or not finite count as 0, as must those of other tiles.
std::vector<AuditPixel> draw_audit_pixels(std::span<const std::pair<uint32_t, uint32_t>> pixels,
                                          std::span<const float> light, size_t width, size_t n, uint64_t seed,
                                          uint64_t first_sample);

}  // namespace viscache
