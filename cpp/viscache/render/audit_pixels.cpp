#include "viscache/render/audit_pixels.h"

#include <algorithm>

#include "viscache/math/morton.h"
#include "viscache/sampling/rng.h"

namespace viscache {

std::vector<std::pair<uint32_t, uint32_t>> along_curve(std::span<const Tile> tiles) {
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
    const auto spread = [](std::span<const float> from, std::span<float> to, size_t step, size_t n) {
        for (size_t i = 0; i < from.size(); ++i) {
            const size_t at = i / step % n, first = at - std::min<size_t>(at, kAuditReach),
                         last = std::min(n - 1, at + kAuditReach);
            for (size_t k = first; k <= last; ++k) to[i] = std::max(to[i], from[i - (at - k) * step]);
        }
    };
    std::vector<float> known(light.size()), in_row(light.size()), near(light.size());
    for (size_t i = 0; i < light.size(); ++i) known[i] = light[i] > 0 && light[i] < kInfinity ? light[i] : 0;
    spread(known, in_row, 1, width);
    spread(in_row, near, width, light.size() / width);
    return near;
}

std::vector<AuditPixel> draw_audit_pixels(std::span<const std::pair<uint32_t, uint32_t>> pixels,
                                          std::span<const float> light, size_t width, size_t n, uint64_t seed,
                                          uint64_t first_sample) {
    std::vector<AuditPixel> out;
    if (n >= pixels.size()) {
        for (const auto& [x, y] : pixels) out.push_back({x, y, 1});
        return out;
    }
    const std::vector<float> near = most_light_near(light, width);
    const auto light_at = [&](size_t i) { return double(near[pixels[i].second * width + pixels[i].first]); };
    double sum = 0;
    for (size_t i = 0; i < pixels.size(); ++i) sum += light_at(i);
    const double mean = sum > 0 ? sum / double(pixels.size()) : 1;
    std::vector<double> end(pixels.size());  // running sum of the sizes
    double total = 0;
    for (size_t i = 0; i < pixels.size(); ++i) end[i] = total += light_at(i) + mean;
    const size_t strata = (n + 1) / 2;
    for (size_t stratum = 0; stratum < strata; ++stratum) {
        Rng rng(seed, Purpose::kAudit, stratum, first_sample);
        for (int draw = 0; draw < 2; ++draw) {
            const double u = double(rng.next_u64() >> 11) * 0x1p-53;
            const double at = (double(stratum) + u) / double(strata) * total;
            const auto found = std::upper_bound(end.begin(), end.end(), at);
            const size_t i = std::min(size_t(found - end.begin()), pixels.size() - 1);
            const double size = light_at(i) + mean;
            out.push_back({pixels[i].first, pixels[i].second, total / (2 * double(strata) * size)});
        }
    }
    return out;
}

}  // namespace viscache
