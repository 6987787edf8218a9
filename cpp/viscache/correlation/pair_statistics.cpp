#include "viscache/correlation/pair_statistics.h"

#include <mutex>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>

#include "viscache/math/morton.h"

namespace viscache {
namespace {

/// Panels of rows that stay in the L2 cache while the columns are processed.
constexpr size_t kStripPanels = 16;

/// Calls visit(pa, pb) for the panels [a0, a1) × [b0, b1), strip by strip. For a block with itself only
/// those with pa <= pb.
///
///         b0 ............ b1
///     a0  | strip: 16 rows of panels stay in the cache,
///         | while each column of panels passes once
///     a1  |
template <class Visit>
void for_each_panel_pair(size_t a0, size_t a1, size_t b0, size_t b1, Visit visit) {
    for (size_t strip = a0; strip < a1; strip += kStripPanels) {
        const size_t end = std::min(a1, strip + kStripPanels);
        // A block with itself: columns begin at the strip, and rows end at the column.
        for (size_t pb = a0 == b0 ? strip : b0; pb < b1; ++pb)
            for (size_t pa = strip; pa < (a0 == b0 ? std::min(end, pb + 1) : end); ++pa) visit(pa, pb);
    }
}

/// The points of the required blocks. Each block is padded to whole panels and sorted by normal.
struct Packed {
    Packed(const PairRows& rows, const PairTiles& tiles, std::span<const uint64_t> chosen);

    std::vector<uint32_t> order;
    std::vector<size_t> first_panel;  ///< first panel of every block, and the end
    PairPoints points;
};

Packed::Packed(const PairRows& rows, const PairTiles& tiles, std::span<const uint64_t> chosen) {
    std::vector<char> needed(tiles.blocks.size());
    // Only blocks of chosen tiles are packed: a sample of tiles needs a part of the memory.
    for (uint64_t t : chosen) needed[tiles.tiles[t].a] = needed[tiles.tiles[t].b] = 1;
    for (size_t b = 0; b < tiles.blocks.size(); ++b) {
        first_panel.push_back(order.size() / kPanelRows);
        if (!needed[b]) continue;
        const PointBlock& block = tiles.blocks[b];
        // Along the Morton curve of the normals: a panel has similar normals, so it shares dead units and few
        // bins of angle.
        for (uint32_t i : morton_order(rows.normal.subspan(block.first, block.size())))
            order.push_back(uint32_t(block.first) + i);
        // Panels never mix blocks.
        order.resize((order.size() + kPanelRows - 1) / kPanelRows * kPanelRows, kNoPoint);
    }
    first_panel.push_back(order.size() / kPanelRows);

    points.resize(order.size());
    for (size_t k = 0; k < order.size(); ++k) {
        if (order[k] == kNoPoint) {
            points.ordinary[k / kPanelRows] = false;
            continue;
        }
        const Vec3 p = rows.position[order[k]], n = rows.normal[order[k]];
        points.x[k] = p.x;
        points.y[k] = p.y;
        points.z[k] = p.z;
        points.nx[k] = n.x;
        points.ny[k] = n.y;
        points.nz[k] = n.z;
    }
}

/// One call of pair_statistics.
class PairRun {
public:
    PairRun(const PairRows& rows, const PairTiles& tiles, std::span<const uint64_t> chosen,
            const PairBinning& binning, const PairWork& work, Control& control)
        : rows_(rows),
          binning_(binning),
          control_(control),
          kernel_(pair_kernel(work.isa)),
          bin_(bin_panels(work.isa)),
          packed_(rows, tiles, chosen),
          visible_([&](uint32_t i, Word* row) { rows.visible(i, row); }, rows.words, packed_.order,
                   work.skip_dead, work.threads, control) {
        if (rows.domain != PairDomain::kSphere)
            above_.emplace([&](uint32_t i, Word* row) { rows.above(i, row); }, rows.words, packed_.order,
                           work.skip_dead, work.threads, control);
        count_rows();
    }

    // Sums are packed in one thread, and flushed before a count could overflow and at the end of the tile.
    void tile(const PairTile& tile, TileBins& bins, PairTable& table, std::mutex& mutex) const {
        auto flush = [&] {
            const std::lock_guard lock(mutex);
            bins.flush(table, tile.group_pair);
        };
        constexpr int64_t kPairs = kPanelRows * kPanelRows;
        for_each_panel_pair(packed_.first_panel[tile.a], packed_.first_panel[tile.a + 1],
                            packed_.first_panel[tile.b], packed_.first_panel[tile.b + 1],
                            [&](size_t pa, size_t pb) {
                                control_.check();
                                if (bins.is_full(kPairs)) flush();
                                bins.count(kPairs);
                                panels(pa, pb, bins);
                            });
        flush();
        control_.done += uint64_t(tile.pairs);
    }

private:
    void count_rows();
    void panels(size_t pa, size_t pb, TileBins& bins) const;
    void domain_panels(size_t pa, size_t pb, const int32_t* vv, TileBins& bins) const;

    const PairRows& rows_;
    PairBinning binning_;
    Control& control_;
    const PairKernel& kernel_;
    BinPanels bin_;
    Packed packed_;
    BitPanels visible_;
    std::optional<BitPanels> above_;
    std::vector<int32_t> n_above_;
};

void PairRun::count_rows() {
    PairPoints& p = packed_.points;
    auto count = [&](const BitPanels& panels, size_t k) {
        int32_t n = 0;
        for (size_t w = 0; w < rows_.words; ++w)
            n += std::popcount(panels.panel(k / kPanelRows)[w * kPanelRows + k % kPanelRows]);
        return n;
    };
    if (above_) n_above_.resize(packed_.order.size());
    for (size_t k = 0; k < packed_.order.size(); ++k) {
        // Padding rows keep the kind kPadding.
        if (packed_.order[k] == kNoPoint) continue;
        p.n1[k] = count(visible_, k);
        // What the statistics need of a row, once per row and not per pair
        p.kind[k] = rows_.kind(p.n1[k], rows_.n_directions);
        p.inverse_spread[k] =
            p.kind[k] == RowKind::kDefined ? inverse_spread(p.n1[k], rows_.n_directions) : 0.f;
        if (p.kind[k] != RowKind::kDefined) p.ordinary[k / kPanelRows] = false;
        if (above_) n_above_[k] = count(*above_, k);
    }
}

void PairRun::panels(size_t pa, size_t pb, TileBins& bins) const {
    alignas(64) int32_t counts[kPanelRows * kPanelRows];
    count_panels(kernel_, visible_, pa, visible_, pb, counts);
    if (above_)
        domain_panels(pa, pb, counts, bins);
    else
        bin_(packed_.points, pa, pb, counts, bins);
}

void PairRun::domain_panels(size_t pa, size_t pb, const int32_t* vv, TileBins& bins) const {
    // A domain that differs from pair to pair needs four intersections instead of one.
    int32_t vu[kPanelRows * kPanelRows], uv[kPanelRows * kPanelRows], uu[kPanelRows * kPanelRows];
    count_panels(kernel_, visible_, pa, *above_, pb, vu);
    count_panels(kernel_, *above_, pa, visible_, pb, uv);
    count_panels(kernel_, *above_, pa, *above_, pb, uu);
    const PairPoints& p = packed_.points;
    for (size_t c = 0; c < kPanelRows * kPanelRows; ++c) {
        const size_t i = pa * kPanelRows + c / kPanelRows, j = pb * kPanelRows + c % kPanelRows;
        if (p.kind[i] == RowKind::kPadding || p.kind[j] == RowKind::kPadding || (pa == pb && j <= i))
            continue;
        int32_t biased = 0;
        int32_t cell = binning_.cell(squared_length(p.x[j] - p.x[i], p.y[j] - p.y[i], p.z[j] - p.z[i]),
                                     squared_length(p.nx[j] - p.nx[i], p.ny[j] - p.ny[i], p.nz[j] - p.nz[i]));
        resolve_counts(rows_, binning_,
                       domain_counts(rows_.domain, vv[c], vu[c], uv[c], uu[c], p.n1[i], p.n1[j],
                                     n_above_[i] + n_above_[j]),
                       cell, biased);
        bins.sums()[cell].add(biased);
    }
}

/// Panels of the rows of an array in their order, padded.
BitPanels plain_panels(const Word* bits, size_t n, size_t words, const PairWork& work, Control& control) {
    std::vector<uint32_t> order((n + kPanelRows - 1) / kPanelRows * kPanelRows, kNoPoint);
    std::iota(order.begin(), order.begin() + int64_t(n), 0u);
    return BitPanels([&](uint32_t i, Word* row) { std::copy_n(bits + i * words, words, row); }, words, order,
                     work.skip_dead, work.threads, control);
}

}  // namespace

PairTable pair_statistics(const PairRows& rows, const PairTiles& tiles, std::span<const uint64_t> chosen,
                          const BinEdges& distances, const BinEdges& angles, const PairWork& work,
                          Control& control) {
    rows.check();
    // Checked before anything is packed
    for (uint64_t t : chosen) {
        if (t >= tiles.tiles.size())
            throw std::invalid_argument("tiles must lie in [0, " + std::to_string(tiles.tiles.size()) +
                                        "), got " + std::to_string(t));
        control.total += uint64_t(tiles.tiles[t].pairs);
    }
    PairTable table(rows.n_groups, distances.bins(), angles.bins());
    const PairBinning binning = binning_of(rows, distances, angles);
    const PairRun run(rows, tiles, chosen, binning, work, control);
    std::vector<std::unique_ptr<TileBins>> bins(size_t(resolve_threads(work.threads)));
    std::mutex mutex;
    parallel_for(chosen.size(), work.threads, [&](size_t c, int worker) {
        std::unique_ptr<TileBins>& own = bins[size_t(worker)];
        if (!own) own = std::make_unique<TileBins>(binning);
        run.tile(tiles.tiles[chosen[c]], *own, table, mutex);
    });
    return table;
}

void intersections(const Word* a, size_t n_a, const Word* b, size_t n_b, size_t words, const PairWork& work,
                   int32_t* out, Control& control) {
    const BitPanels pa = plain_panels(a, n_a, words, work, control),
                    pb = plain_panels(b, n_b, words, work, control);
    const PairKernel& kernel = pair_kernel(work.isa);
    parallel_for(pa.panels(), work.threads, [&](size_t i, int) {
        int32_t counts[kPanelRows * kPanelRows];
        // Padding rows and columns are not copied.
        const size_t rows = std::min(kPanelRows, n_a - i * kPanelRows);
        for (size_t j = 0; j < pb.panels(); ++j) {
            control.check();
            count_panels(kernel, pa, i, pb, j, counts);
            const size_t columns = std::min(kPanelRows, n_b - j * kPanelRows);
            for (size_t r = 0; r < rows; ++r)
                std::copy_n(counts + r * kPanelRows, columns,
                            out + (i * kPanelRows + r) * n_b + j * kPanelRows);
        }
    });
}

uint64_t total_intersections(const Word* a, size_t n_a, const Word* b, size_t n_b, size_t words,
                             const PairWork& work, Control& control) {
    const BitPanels pa = plain_panels(a, n_a, words, work, control),
                    pb = plain_panels(b, n_b, words, work, control);
    const PairKernel& kernel = pair_kernel(work.isa);
    std::atomic<uint64_t> total{0};
    const size_t strips = (pa.panels() + kStripPanels - 1) / kStripPanels;
    parallel_for(strips, work.threads, [&](size_t s, int) {
        alignas(64) int32_t counts[kPanelRows * kPanelRows];
        uint64_t sum = 0;
        for (size_t j = 0; j < pb.panels(); ++j)
            for (size_t i = s * kStripPanels; i < std::min(pa.panels(), (s + 1) * kStripPanels); ++i) {
                control.check();
                count_panels(kernel, pa, i, pb, j, counts);
                for (int32_t n : counts) sum += uint64_t(n);
            }
        total += sum;
    });
    return total;
}

}  // namespace viscache
