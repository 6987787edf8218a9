#pragma once
// Bit rows for samples that belong to single eye points: one row per eye cell, one column per light cell.
//
// This is Alg. 2 with an exact table, cleared per tile and stored as rows. The columns are the light cells of
// the samples. Samples of one eye point in one cell share a bit, and the first of them is traced. Every eye
// point uses different columns, so a cell has no single representative. Instead, eye points near the centres
// of their cells are processed first. Without refinement, the traced rays do not depend on how the samples
// are split into calls.
#include <array>
#include <vector>

#include "viscache/aqvc/cell_steps.h"
#include "viscache/aqvc/light_cells.h"
#include "viscache/aqvc/row_kernels.h"
#include "viscache/visibility/packet_choice.h"

namespace viscache {

class SampleRows {
public:
    explicit SampleRows(const RayCaster& caster) : caster_(caster) {}
    void watch(const Control& control) { control_ = &control; }

    /// Begins a tile and a light group with the given C_E per level. Runs have at most `batch` eye points.
    /// The number of columns is limited by `row_bytes`, but is at least 512.
    void begin(const TileAnchors& tile, const std::vector<double>& levels, uint32_t batch, uint64_t row_bytes,
               Counters& counters, ClampCounts& clamps);
    /// All eye points of the tile in processing order. Eye points are ranked in their cell by distance to its
    /// centre. Rounds take ranks 0, 1, 2–3, 4–7, …; inside a round the order is that of the tile.
    const std::vector<uint32_t>& order() const { return order_; }
    const std::vector<uint32_t>& run_end() const { return run_end_; }
    const std::vector<uint32_t>& run_of_eye() const { return run_of_eye_; }

    /// Answers the samples into `visible` and returns the number of rays. Samples in light cells without a
    /// column are left to the caller: their indices are stored in `left`.
    uint64_t run(const LocalSamples& samples, const AqvcParameters& p, std::span<Word> visible,
                 std::vector<uint32_t>& left, Counters& counters, ClampCounts& clamps);

private:
    static constexpr size_t kSlabWords = 8, kSlabColumns = kSlabWords * kWordBits;

    /// 512 columns of all cells.
    struct Slab {
        BitMatrix known, value, pending;
    };
    /// Bits that a row of the run misses at a cell.
    struct Waiting {
        uint32_t slab, cell, row;
        std::array<Word, kSlabWords> miss;
    };
    struct PendingRay {
        uint32_t sample, eye, cell, column;  ///< cell = kNoCell: the ray answers only its sample
    };

    void make_order(const TileAnchors& tile, uint32_t batch);
    void grow(size_t slabs);
    void look_up(const LocalSamples& samples, size_t row, std::vector<uint32_t>& left, Counters& counters);
    void walk(const LocalSamples& samples, size_t row, Counters& counters);
    bool step_slab(const CellSteps::Step& step, bool last, size_t slab, size_t row, RowCounts& counts);
    void queue_rays(const LocalSamples& samples, size_t row, const CellSteps::Step& step);
    void trace(const LocalSamples& samples, std::span<Word> visible);
    void trace16(const LocalSamples& samples, std::span<const uint32_t> numbers, std::span<Word> visible);
    void answer(const LocalSamples& samples, size_t row, std::span<Word> visible) const;

    const RayCaster& caster_;
    const Control* control_ = nullptr;
    const RowKernels& kernels_ = row_kernels(active_isa());
    const TileAnchors* tile_ = nullptr;

    // State of the tile and light group
    CellSteps cells_;
    std::vector<uint32_t> order_, run_end_, run_of_eye_;
    LightCells light_cells_;
    std::vector<Slab> slabs_;
    size_t slabs_used_ = 0;

    // State of a run; a row holds the bits of one eye point
    std::vector<uint32_t> column_;  ///< column of every sample
    BitMatrix active_, seen_, fresh_;
    bool going_ = false;
    std::vector<Waiting> waiting_;
    std::vector<PendingRay> rays_;
    std::vector<uint32_t> begin_, by_column_;
};

}  // namespace viscache
