#pragma once
// Processing order of the eye points of a tile (AQVC Sec. 4.3). Representatives should not all lie on one
// side of their clusters, and neighbours should be known before they are probed.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "viscache/aqvc/cluster_key.h"
#include "viscache/aqvc/parameters.h"
#include "viscache/math/morton.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

/// Eye points in processing order, cut into segments of growing density.
struct TileOrder {
    std::vector<uint32_t> eye;
    std::vector<uint32_t> segment_end;
};

/// The last `digits` digits of i in `base`, reversed: the radical inverse times base^digits.
inline uint64_t reversed_digits(uint64_t i, uint64_t base, int digits) {
    uint64_t r = 0;
    for (int k = 0; k < digits; ++k) {
        r = r * base + i % base;
        i /= base;
    }
    return r;
}

/// Step at which the Halton sequence of bases 2 and 3 visits each position of a width × height grid:
/// rank[y·width + x]. Points of the smallest enclosing 2^a × 3^b grid that fall outside are skipped, so every
/// position occurs once.
///
///     columns: bits of i, reversed (base 2)           rows: digits of i in base 3, reversed
///
///     Since 2^a and 3^b have no common factor, i = 0 ... 2^a 3^b − 1 visits every position once.
inline std::vector<uint32_t> halton_ranks(uint32_t width, uint32_t height) {
    uint64_t columns = 1, rows = 1;
    int a = 0, b = 0;
    while (columns < width) {
        columns *= 2;
        ++a;
    }
    while (rows < height) {
        rows *= 3;
        ++b;
    }
    std::vector<uint32_t> rank(size_t(width) * height);
    uint32_t next = 0;
    for (uint64_t i = 0; i < columns * rows; ++i) {
        const uint64_t x = reversed_digits(i % columns, 2, a), y = reversed_digits(i % rows, 3, b);
        if (x < width && y < height) rank[y * width + x] = next++;
    }
    return rank;
}

/// Segment ends C_PI, C_PI·C_PG, C_PI·C_PG², … with C_PI = max(1, count / C_E²), up to count.
// The first segment has about one eye point per cluster. Each further segment is C_PG times as long.
inline std::vector<uint32_t> segment_ends(size_t count, double c_e, double c_pg) {
    std::vector<uint32_t> ends;
    // Ends are rounded down, so the first few may coincide.
    for (double end = std::max(1.0, double(count) / (c_e * c_e)); std::floor(end) < double(count);
         end *= c_pg)
        if (ends.empty() || uint32_t(end) > ends.back()) ends.push_back(uint32_t(end));
    if (count) ends.push_back(uint32_t(count));
    return ends;
}

/// Computes orders; keeps the ranks of the latest tile size.
class OrderMaker {
public:
    void make(const EyeBlock& eyes, const AqvcParameters& p, TileOrder& out);

private:
    void sort_by(std::vector<uint32_t>& items, size_t first, size_t last) {
        std::sort(items.begin() + std::ptrdiff_t(first), items.begin() + std::ptrdiff_t(last),
                  [&](uint32_t a, uint32_t b) { return key_[a] != key_[b] ? key_[a] < key_[b] : a < b; });
    }
    std::vector<uint32_t> ranks_;
    uint32_t width_ = 0, height_ = 0;
    std::vector<uint64_t> key_;
};

inline void OrderMaker::make(const EyeBlock& eyes, const AqvcParameters& p, TileOrder& out) {
    const size_t n = eyes.size();
    out.eye.resize(n);
    key_.resize(n);
    std::iota(out.eye.begin(), out.eye.end(), 0u);
    // Without usable positions the eye points keep their order.
    // Places must lie in the tile: the table of ranks has no others.
    bool placed = eyes.order_x.size() == n && eyes.order_y.size() == n;
    for (size_t i = 0; placed && i < n; ++i)
        placed = eyes.order_x[i] < eyes.tile_width && eyes.order_y[i] < eyes.tile_height;
    const bool halton = placed && p.order == PixelOrder::kHaltonMorton;
    if (halton && (width_ != eyes.tile_width || height_ != eyes.tile_height)) {
        width_ = eyes.tile_width;
        height_ = eyes.tile_height;
        ranks_ = halton_ranks(width_, height_);
    }
    // Sort by the sequence first. Eye points at the same position stay in index order.
    for (size_t i = 0; i < n; ++i) {
        const uint64_t at = placed ? uint64_t(eyes.order_y[i]) * eyes.tile_width + eyes.order_x[i] : i;
        if (halton)
            key_[i] = ranks_[at];
        else if (p.order == PixelOrder::kRandom)
            // A hash of the place: random, yet the same for any number of threads.
            key_[i] = murmur64(at + 0x9e3779b97f4a7c15ull * (uint64_t{p.grid_seed} + 1));
        else
            key_[i] = at;
    }
    // The index breaks ties, so the order does not depend on the library's sort.
    sort_by(out.eye, 0, n);
    if (!halton) {
        out.segment_end.assign(n ? 1 : 0, uint32_t(n));
        return;
    }
    // Then sort along the Morton curve inside each segment, for coherence.
    out.segment_end = segment_ends(n, p.c_e, p.c_pg);
    // Ranks are no longer needed.
    for (size_t i = 0; i < n; ++i) key_[i] = morton2_wide(eyes.order_x[i], eyes.order_y[i]);
    size_t first = 0;
    for (uint32_t end : out.segment_end) {
        sort_by(out.eye, first, end);
        first = end;
    }
}

/// Ends of runs of at most `batch` eye points. No run crosses a segment end.
// A segment end is also the end of a run: its values are written before the next, denser segment is looked
// up.
inline std::vector<uint32_t> run_ends(const TileOrder& order, uint32_t batch) {
    std::vector<uint32_t> ends;
    uint32_t first = 0;
    for (uint32_t segment : order.segment_end)
        for (; first < segment; ends.push_back(first)) first = std::min(segment, first + std::max(1u, batch));
    return ends;
}

}  // namespace viscache
