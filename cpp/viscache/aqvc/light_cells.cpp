#include "viscache/aqvc/light_cells.h"

#include "viscache/aqvc/octahedral_batch.h"

namespace viscache {

void LightCells::clear(uint32_t limit) {
    // Only tables in use, since most resolutions never occur.
    for (size_t k : used_) dense_[k].clear();
    used_.clear();
    sparse_.clear();
    column_of_.clear();
    limit_ = limit;
    count_ = 0;
}

void LightCells::number(const LocalSamples& samples, const CellGrid& grid, const AqvcParameters& p,
                        std::vector<uint32_t>& column, ClampCounts& clamps) {
    const std::vector<float>& density =
        p.cell_density == CellDensity::kLight ? samples.light_density : samples.density;
    column.resize(samples.size());
    if (samples.semantic == Semantic::kSolidAngle)
        number_directions(samples, grid, p, density, column, clamps);
    else
        number_points(samples, grid, p, density, column, clamps);
}

uint32_t LightCells::number_in(std::vector<uint32_t>& table, size_t at) {
    // 0 is "none", so numbers are stored plus one.
    if (!table[at]) {
        if (count_ == limit_) return kFull;
        table[at] = ++count_;
    }
    return table[at] - 1;
}

uint32_t LightCells::number_sparse(const Cell& cell) {
    // At the limit, known cells keep their columns and new ones get none.
    if (count_ == limit_) {
        const uint32_t known = sparse_.find(cell, 0);
        return known == kNoCell ? kFull : column_of_[known];
    }
    const uint32_t number = sparse_.number(cell, 0);
    if (number == column_of_.size()) column_of_.push_back(count_++);
    return column_of_[number];
}

/// Uses the same cells as CellGrid::far_key: i, j and the rung.
void LightCells::number_directions(const LocalSamples& s, const CellGrid& grid, const AqvcParameters& p,
                                   const std::vector<float>& density, std::vector<uint32_t>& column,
                                   ClampCounts& clamps) {
    u_.resize(s.size());
    v_.resize(s.size());
    octahedral_batch(s.x, s.y, s.z, u_, v_);
    // Consecutive densities are often equal; for a uniform sky all are
    double last_density = -1;
    const Rung* rung = nullptr;
    // Clamps are counted per sample, as if each had looked up its rung.
    ClampCounts met, once;
    for (size_t i = 0; i < s.size(); ++i) {
        // Written so that NaN looks up its rung each time
        if (!(double(density[i]) == last_density)) {
            last_density = density[i];
            once = {};
            rung =
                &grid.direction_ladder.rung(far_resolution(s.semantic, last_density, grid.radius(), p), once);
        }
        met.low += once.low;
        met.high += once.high;
        met.nan += once.nan;
        // NaN: the direction is zero or not finite
        if (!(u_[i] >= 0 && v_[i] >= 0)) {
            column[i] = kNoKey;
            continue;
        }
        const double r = rung->resolution, last = r - 1;
        const double ci = std::min(last, std::floor(u_[i] * r)), cj = std::min(last, std::floor(v_[i] * r));
        // Fine resolutions have too many cells for a table.
        if (r > kDense) {
            column[i] = number_sparse({0, rung->slot, int64_t(ci), int64_t(cj), 0});
            continue;
        }
        // Rungs with equal R share a table
        const size_t across = size_t(r);
        if (dense_[across].empty()) {
            dense_[across].assign(across * across, 0);
            used_.push_back(across);
        }
        column[i] = number_in(dense_[across], size_t(cj) * across + size_t(ci));
    }
    clamps.low += met.low;
    clamps.high += met.high;
    clamps.nan += met.nan;
}

void LightCells::number_points(const LocalSamples& s, const CellGrid& grid, const AqvcParameters& p,
                               const std::vector<float>& density, std::vector<uint32_t>& column,
                               ClampCounts& clamps) {
    for (size_t i = 0; i < s.size(); ++i) {
        const Anchor a = grid.anchor(s.far(i), s.normal[i]);
        // Without a normal there is no cell, and the sample bypasses the cache.
        column[i] = kNoKey;
        if (!a.valid) continue;
        const Rung& rung = grid.ladder.rung(far_resolution(s.semantic, density[i], grid.radius(), p), clamps);
        column[i] = number_sparse(grid.cell(a, rung).cell);
    }
}

}  // namespace viscache
