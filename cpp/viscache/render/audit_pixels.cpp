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

std::vector<AuditPixel> draw_audit_pixels(std::span<const std::pair<uint32_t, uint32_t>> pixels,
                                          std::span<const float> light, size_t n, uint64_t seed,
                                          uint64_t first_sample) {
    std::vector<AuditPixel> out;
    if (n >= pixels.size()) {
        for (const auto& [x, y] : pixels) out.push_back({x, y, 1});
        return out;
    }
    const auto known = [](float v) { return v > 0 && v < kInfinity ? double(v) : 0.0; };
    double sum = 0;
    for (const float v : light) sum += known(v);
    const double mean = sum > 0 ? sum / double(pixels.size()) : 1;
    std::vector<double> end(pixels.size());  // running sum of the sizes
    double total = 0;
    for (size_t i = 0; i < pixels.size(); ++i) end[i] = total += known(light[i]) + mean;
    const size_t strata = (n + 1) / 2;
    for (size_t stratum = 0; stratum < strata; ++stratum) {
        Rng rng(seed, Purpose::kAudit, stratum, first_sample);
        for (int draw = 0; draw < 2; ++draw) {
            const double u = double(rng.next_u64() >> 11) * 0x1p-53;
            const double at = (double(stratum) + u) / double(strata) * total;
            const auto found = std::upper_bound(end.begin(), end.end(), at);
            const size_t i = std::min(size_t(found - end.begin()), pixels.size() - 1);
            const double size = known(light[i]) + mean;
            out.push_back({pixels[i].first, pixels[i].second, total / (2 * double(strata) * size)});
        }
    }
    return out;
}

}  // namespace viscache
