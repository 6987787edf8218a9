#pragma once
// Samples that every eye point has for itself, through bit rows: a row per eye cell, a column per light cell.
//
// This is Alg. 2 against an exact, tile-cleared table laid out as rows. The columns are the light
// cells the samples fall into. Samples of one eye point in one cell share a bit; of those the
// first is traced. Every eye point asks other columns, so a cell has no single representative: eye points go
// in an order that lets those near the centres of their cells ask first. Without refinement, what is traced
// does not depend on how the samples are cut into calls.
#include <array>
#include <vector>

#include "viscache/aqvc/cell_steps.h"
#include "viscache/aqvc/light_cells.h"
#include "viscache/aqvc/row_kernels.h"
#include "viscache/visibility/coherence_trial.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

class SampleRows {
public:
    SampleRows(const RayCaster& caster, float extent) : caster_(caster), extent_(extent), flag_({}, 256) {}
    void watch(const Control& control) { control_ = &control; }

    /// Starts the tile and light group whose C_E per level are given. Runs get at most `batch` eye points,
    /// rows of bits as many columns as fit `row_bytes`, at least 512.
    void begin(const TileAnchors& tile, const std::vector<double>& levels, uint32_t batch, uint64_t row_bytes,
               Counters& counters, ClampCounts& clamps);
    /// All eye points of the tile: by rank in their cell, counted outwards from its centre, in rounds of
    /// ranks 0, 1, 2–3, 4–7, … and along the tile's order inside a round.
    const std::vector<uint32_t>& order() const { return order_; }
    const std::vector<uint32_t>& run_end() const { return run_end_; }
    const std::vector<uint32_t>& run_of_eye() const { return run_of_eye_; }

    /// Answers the samples into `visible` and returns the number of rays. Samples in light cells beyond the
    /// room for columns are left to the caller: their numbers go to `left`.
    uint64_t run(const LocalSamples& samples, const AqvcParameters& p, std::span<Word> visible,
                 std::vector<uint32_t>& left, Counters& counters, ClampCounts& clamps);

private:
    static constexpr size_t kSlabWords = 8, kSlabColumns = kSlabWords * kWordBits;

    /// 512 columns of all cells.
    struct Slab {
        BitMatrix known, value, pending;
    };
    /// Bits that an eye point of the run misses at a cell.
    struct Waiting {
        uint32_t slab, cell, asker;
        std::array<Word, kSlabWords> miss;
    };
    struct PendingRay {
        uint32_t sample, eye, cell, column;  ///< cell = kNoCell: it answers its sample alone
    };

    void make_order(const TileAnchors& tile, uint32_t batch);
    void grow(size_t slabs);
    void ask(const LocalSamples& samples, size_t asker, std::vector<uint32_t>& left, Counters& counters);
    void walk(const LocalSamples& samples, size_t asker, Counters& counters);
    bool miss_at(const CellSteps::Step& step, bool last, size_t slab, size_t asker, RowCounts& counts);
    void queue_rays(const LocalSamples& samples, size_t asker, const CellSteps::Step& step);
    void trace(const LocalSamples& samples, std::span<Word> visible);
    void trace16(const LocalSamples& samples, std::span<const uint32_t> numbers, std::span<Word> visible,
                 Coherence flag);
    void answer(const LocalSamples& samples, size_t asker, std::span<Word> visible) const;

    const RayCaster& caster_;
    float extent_;
    CoherenceTrial flag_;
    const Control* control_ = nullptr;
    const RowKernels& kernels_ = row_kernels(active_isa());
    const TileAnchors* tile_ = nullptr;

    // Of the tile and group
    CellSteps cells_;
    std::vector<uint32_t> order_, run_end_, run_of_eye_;
    LightCells light_cells_;
    std::vector<Slab> slabs_;
    size_t slabs_used_ = 0;

    // Of a run
    std::vector<uint32_t> column_;  ///< of every sample
    BitMatrix asked_, seen_, fresh_;
    bool going_ = false;
    std::vector<Waiting> waiting_;
    std::vector<PendingRay> rays_;
    std::vector<uint32_t> begin_, by_column_;
};

}  // namespace viscache
