#include "viscache/correlation/neighbourhood.h"

#include <optional>
#include <stdexcept>

#include "viscache/correlation/point_grid.h"

namespace viscache {
namespace {

/// Rows of bits restricted to the domain, with the per-row values that the statistics of a pair need.
class NearRows {
public:
    NearRows(const PairRows& rows, const PairBinning& binning, const PairWork& work, Control& control);

    /// Cell of a pair by distance and angle. resolve() then adds the result of counting its bits.
    int32_t cell(size_t i, size_t j) const {
        const Vec3 d = rows_.position[j] - rows_.position[i], n = rows_.normal[j] - rows_.normal[i];
        return binning_.cell(squared_length(d.x, d.y, d.z), squared_length(n.x, n.y, n.z));
    }
    void resolve(size_t i, size_t j, int32_t& cell, int32_t& biased) const;

private:
    int32_t both(const Word* a, const Word* b) const { return int32_t(kernel_.dot(a, b, rows_.words)); }
    const Word* visible(size_t i) const { return visible_ ? visible_->row(i) : rows_.row(i); }

    const PairRows& rows_;
    PairBinning binning_;
    const PairKernel& kernel_;
    std::optional<BitMatrix> visible_, above_;  ///< empty if the domain is the sphere
    std::vector<int32_t> n1_, n_above_;
    std::vector<float> inverse_spread_;
    std::vector<RowKind> kind_;
};

NearRows::NearRows(const PairRows& rows, const PairBinning& binning, const PairWork& work, Control& control)
    : rows_(rows),
      binning_(binning),
      kernel_(pair_kernel(work.isa)),
      n1_(rows.size()),
      n_above_(rows.size()),
      inverse_spread_(rows.size()),
      kind_(rows.size()) {
    // On the whole sphere, rows are used as they are.
    if (rows.domain != PairDomain::kSphere) {
        visible_.emplace(rows.size(), rows.words * kWordBits);
        above_.emplace(rows.size(), rows.words * kWordBits);
    }
    parallel_for(rows.size(), work.threads, [&](size_t i, int) {
        control.check();
        if (above_) {
            rows.visible(i, visible_->row(i));
            rows.above(i, above_->row(i));
            // |u ∩ u| = |u|: the kernel counts single rows, too.
            n_above_[i] = both(above_->row(i), above_->row(i));
        }
        n1_[i] = both(visible(i), visible(i));
        kind_[i] = rows.kind(n1_[i], rows.n_directions);
        if (kind_[i] == RowKind::kDefined) inverse_spread_[i] = inverse_spread(n1_[i], rows.n_directions);
    });
}

void NearRows::resolve(size_t i, size_t j, int32_t& cell, int32_t& biased) const {
    if (above_) {
        const Word *ui = above_->row(i), *uj = above_->row(j);
        resolve_counts(
            rows_, binning_,
            domain_counts(rows_.domain, both(visible(i), visible(j)), both(visible(i), uj),
                          both(ui, visible(j)), both(ui, uj), n1_[i], n1_[j], n_above_[i] + n_above_[j]),
            cell, biased);
    } else if (kind_[i] == RowKind::kDefined && kind_[j] == RowKind::kDefined) {
        const int32_t n11 = both(rows_.row(i), rows_.row(j));
        // The common case in integers: the numerator is below 2³¹ for the number of directions that is
        // allowed.
        const int32_t numerator = phi_numerator(n11, n1_[i], n1_[j], rows_.n_directions);
        biased = biased_rho(pearson(float(numerator), inverse_spread_[i], inverse_spread_[j]));
    } else {
        resolve_pair(binning_, kind_[i], kind_[j], cell, biased);
    }
}

/// Runs work(cell, worker) over all cells of the grid.
/// Progress counts points, since cells differ in size.
template <class Work>
void over_cells(const PointGrid& grid, int threads, Control& control, Work work) {
    constexpr size_t kChunk = 32;
    const size_t chunks = (grid.cells() + kChunk - 1) / kChunk;
    for (size_t c = 0; c < grid.cells(); ++c) control.total += grid.members(c).size();
    parallel_for(chunks, threads, [&](size_t chunk, int worker) {
        for (size_t c = chunk * kChunk; c < std::min(grid.cells(), (chunk + 1) * kChunk); ++c) {
            work(c, worker);
            control.done += grid.members(c).size();
        }
    });
}

}  // namespace

PairTable near_pairs(const PairRows& rows, const BinEdges& distances, const BinEdges& angles, double d_near,
                     const PairWork& work, Control& control) {
    rows.check();
    if (!std::isfinite(d_near)) throw std::invalid_argument("d_near must be finite");
    const PairBinning binning = binning_of(rows, distances, angles);
    const NearRows near(rows, binning, work, control);
    const PointGrid grid(rows.position, d_near);
    const size_t stride = size_t(binning.stride()), cells = size_t(binning.cells());
    auto count = [&](size_t i, size_t j, PairTable& table) {
        // The bins come first: most pairs of neighbouring cells lie outside, and need no bits.
        int32_t cell = near.cell(i, j), biased = 0;
        const size_t d = size_t(cell) % stride, t = size_t(cell) / stride;
        if (d == 0 || d > table.n_distances || t == 0 || t > table.n_angles) return;
        near.resolve(i, j, cell, biased);
        // A pair of groups has one order.
        const auto [g, h] = std::minmax(rows.group[i], rows.group[j]);
        const size_t to = table.cell(group_pair(size_t(g), size_t(h), rows.n_groups), d - 1, t - 1);
        // Cells of pairs without ρ follow those of pairs with one.
        if (size_t(cell) >= cells)
            ++table.n_undefined[to];
        else
            table.add(to, 1, biased - kRhoOne, uint64_t((biased - kRhoOne) * (biased - kRhoOne)));
    };

    // One table per thread that gets work; integers make the order of their sum irrelevant.
    std::vector<std::optional<PairTable>> tables(size_t(resolve_threads(work.threads)));
    over_cells(grid, work.threads, control, [&](size_t c, int worker) {
        std::optional<PairTable>& own = tables[size_t(worker)];
        if (!own) own.emplace(rows.n_groups, distances.bins(), angles.bins());
        for (uint32_t i : grid.members(c)) {
            control.check();
            grid.around(c, [&](std::span<const uint32_t> others) {
                for (uint32_t j : others)
                    // Each pair once, although both points find each other
                    if (i < j) count(i, j, *own);
            });
        }
    });
    PairTable sum(rows.n_groups, distances.bins(), angles.bins());
    for (const std::optional<PairTable>& t : tables)
        if (t) sum.add(*t);
    return sum;
}

std::vector<float> spatial_map(const PairRows& rows, double d_max, double theta_max_deg, const PairWork& work,
                               Control& control) {
    rows.check();
    const double d_edges[] = {0, d_max}, angle_edges[] = {0, theta_max_deg};
    if (!std::isfinite(d_max)) throw std::invalid_argument("d_max must be finite");
    const BinEdges distances = BinEdges::distances(d_edges), angles = BinEdges::angles(angle_edges);
    const PairBinning binning = binning_of(rows, distances, angles);
    const NearRows near(rows, binning, work, control);
    const PointGrid grid(rows.position, d_max);
    // One bin in each direction, and codes count from 1.
    const int32_t inside = binning.stride() + 1;

    std::vector<float> mean(rows.size(), std::nanf(""));
    over_cells(grid, work.threads, control, [&](size_t c, int) {
        for (uint32_t i : grid.members(c)) {
            control.check();
            // Sums of integers: the mean does not depend on the order of points.
            int64_t n = 0, sum = 0;
            grid.around(c, [&](std::span<const uint32_t> others) {
                for (uint32_t j : others) {
                    int32_t cell = near.cell(i, j), biased = 0;
                    if (i == j || cell != inside) continue;
                    near.resolve(i, j, cell, biased);
                    if (cell == inside) {
                        ++n;
                        sum += biased - kRhoOne;
                    }
                }
            });
            if (n) mean[i] = float(double(sum) / double(n) / double(kRhoOne));
        }
    });
    return mean;
}

}  // namespace viscache
