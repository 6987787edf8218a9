#include "viscache/render/audit_pixels.h"

#include <algorithm>

#include "viscache/math/morton.h"
#include "viscache/sampling/rng.h"

namespace viscache {

std::vector<std::pair<uint32_t, uint32_t>> along_curve(std::span<const Tile> tiles) {
    // Tiles are aligned squares with an edge of a power of two, so the curve through their corners,
    // refined inside of each, is the curve of the picture
    std::vector<Tile> sorted(tiles.begin(), tiles.end());
    std::sort(sorted.begin(), sorted.end(), [](const Tile& a, const Tile& b) {
        return morton2_wide(uint32_t(a.x0), uint32_t(a.y0)) < morton2_wide(uint32_t(b.x0), uint32_t(b.y0));
    });
    std::vector<std::pair<uint32_t, uint32_t>> out;
    for (const Tile& tile : sorted)
        for (const auto& [x, y] : morton_pixels(tile.x1 - tile.x0, tile.y1 - tile.y0))
            out.emplace_back(uint32_t(tile.x0) + x, uint32_t(tile.y0) + y);
    return out;
}

/// The most light of a pixel within `kAuditReach` of each.
static std::vector<float> most_light_near(std::span<const float> light, size_t width) {
    // The maximum over a square is separable: along rows first, then along columns. `step` is the
    // distance in memory of neighbours on the axis, `n` their number
    const auto spread = [](std::span<const float> from, std::span<float> to, size_t step, size_t n) {
        for (size_t i = 0; i < from.size(); ++i) {
            // The window stops at the border of the picture
            const size_t at = i / step % n, first = at - std::min<size_t>(at, kAuditReach),
                         last = std::min(n - 1, at + kAuditReach);
            for (size_t k = first; k <= last; ++k) to[i] = std::max(to[i], from[i - (at - k) * step]);
        }
    };
    std::vector<float> known(light.size()), in_row(light.size()), near(light.size());
    // One pixel that is not finite must not decide the draw of all
    for (size_t i = 0; i < light.size(); ++i) known[i] = light[i] > 0 && light[i] < kInfinity ? light[i] : 0;
    spread(known, in_row, 1, width);
    spread(in_row, near, width, light.size() / width);
    return near;
}

std::vector<AuditPixel> draw_audit_pixels(std::span<const std::pair<uint32_t, uint32_t>> pixels,
                                          std::span<const float> light, size_t width, size_t n, uint64_t seed,
                                          uint64_t first_sample) {
    std::vector<AuditPixel> out;
    // Every pixel once has no error of sampling; a draw of that many would still miss some
    if (n >= pixels.size()) {
        for (const auto& [x, y] : pixels) out.push_back({x, y, 1});
        return out;
    }
    const std::vector<float> near = most_light_near(light, width);
    const auto light_at = [&](size_t i) { return double(near[pixels[i].second * width + pixels[i].first]); };
    double sum = 0;
    for (size_t i = 0; i < pixels.size(); ++i) sum += light_at(i);
    // The mean of all keeps every probability positive, also of pixels that are black without
    // shadows: the estimate stays unbiased, and no weight exceeds 2·pixels/n. In a black picture
    // all are equal
    const double mean = sum > 0 ? sum / double(pixels.size()) : 1;
    std::vector<double> end(pixels.size());  // running sum of the sizes
    double total = 0;
    // A pixel is a stretch of the running sum, as long as its size; a point that falls into it
    // draws it
    for (size_t i = 0; i < pixels.size(); ++i) end[i] = total += light_at(i) + mean;
    // Two draws per stratum are the fewest whose difference estimates the variance within it
    const size_t strata = (n + 1) / 2;
    for (size_t stratum = 0; stratum < strata; ++stratum) {
        // Keyed by the stratum and by the frame's first sample, so that every pass of a progressive
        // picture draws other pixels
        Rng rng(seed, Purpose::kAudit, stratum, first_sample);
        for (int draw = 0; draw < 2; ++draw) {
            // 53 bits: with float steps, whole pixels of a large picture would never be drawn
            const double u = double(rng.next_u64() >> 11) * 0x1p-53;
            const double at = (double(stratum) + u) / double(strata) * total;
            const auto found = std::upper_bound(end.begin(), end.end(), at);
            // Rounding may put the last point at the very end of the sum
            const size_t i = std::min(size_t(found - end.begin()), pixels.size() - 1);
            const double size = light_at(i) + mean;
            // 1 / expected number of draws of this pixel: each of the 2·strata draws takes it with
            // probability size/total on average over the strata
            out.push_back({pixels[i].first, pixels[i].second, total / (2 * double(strata) * size)});
        }
    }
    return out;
}

}  // namespace viscache
