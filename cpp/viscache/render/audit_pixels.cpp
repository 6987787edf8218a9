#include "viscache/render/audit_pixels.h"

#include <algorithm>
#include <bit>

#include "viscache/sampling/rng.h"

namespace viscache {

AuditPixel morton_pixel(uint64_t rank, uint32_t width, uint32_t height) {
    uint32_t x0 = 0, y0 = 0;
    // From a square around the picture down: which of its quarters has the pixel?
    for (uint32_t half = std::bit_ceil(std::max(width, height)) / 2; half > 0; half /= 2)
        for (uint32_t quarter = 0; quarter < 4; ++quarter) {
            const uint32_t x = x0 + (quarter & 1) * half, y = y0 + (quarter >> 1) * half;
            const uint64_t columns = x < width ? std::min(half, width - x) : 0;
            const uint64_t rows = y < height ? std::min(half, height - y) : 0;
            if (rank < columns * rows) {
                x0 = x;
                y0 = y;
                break;
            }
            rank -= columns * rows;
        }
    return {x0, y0, 0, 0, 0};
}

std::vector<AuditPixel> draw_audit_pixels(uint32_t width, uint32_t height, size_t n, uint64_t seed,
                                          uint64_t first_sample) {
    const uint64_t all = uint64_t(width) * height;
    const bool every = n >= all;
    const uint64_t strata = every ? 1 : std::min<uint64_t>((n + 1) / 2, all / 2);
    std::vector<AuditPixel> out;
    for (uint64_t stratum = 0; stratum < strata; ++stratum) {
        const uint64_t begin = all * stratum / strata, size = all * (stratum + 1) / strata - begin;
        const auto add = [&](uint64_t rank, uint64_t drawn) {
            AuditPixel pixel = morton_pixel(begin + rank, width, height);
            pixel.stratum = uint32_t(stratum);
            pixel.pixels = uint32_t(size);
            pixel.drawn = uint32_t(drawn);
            out.push_back(pixel);
        };
        if (every) {
            for (uint64_t rank = 0; rank < size; ++rank) add(rank, size);
            continue;
        }
        Rng rng(seed, Purpose::kAudit, stratum, first_sample);
        const auto below = [&](uint64_t limit) { return (rng.next_u64() >> 32) * limit >> 32; };
        const uint64_t first = below(size);
        uint64_t second = below(size - 1);
        second += second >= first;
        add(std::min(first, second), 2);
        add(std::max(first, second), 2);
    }
    return out;
}

}  // namespace viscache
