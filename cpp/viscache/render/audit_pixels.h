#pragma once
// Draws the pixels of an audit: a stratified random sample along the Morton curve of a picture.
//
// A stratum is a run of the curve, so its pixels lie close together. Two pixels are drawn of each, without
// replacement, so that their difference estimates the variance within the stratum.
#include <cstddef>
#include <cstdint>
#include <vector>

namespace viscache {

struct AuditPixel {
    uint32_t x, y;
    uint32_t stratum;
    uint32_t pixels;  ///< of its stratum
    uint32_t drawn;   ///< of these
};

/// Pixel number `rank` along the Morton curve of a picture.
AuditPixel morton_pixel(uint64_t rank, uint32_t width, uint32_t height);

/// About n pixels, in the order of their strata: n rounded up to an even number, or all pixels, in one
/// stratum, if the picture has no more. Only the arguments decide.
std::vector<AuditPixel> draw_audit_pixels(uint32_t width, uint32_t height, size_t n, uint64_t seed,
                                          uint64_t first_sample);

}  // namespace viscache
