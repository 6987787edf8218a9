#pragma once
// The quantized visibility cache as an oracle (AQVC Sec. 3–4).
//
// The parameters choose between two forms. Groups of shared lights use level waves or the hash table. Samples
// of single eye points use bit rows by light cell or the table. Other connections of single eye points use
// the table. Exact rays answer the light groups of `exact_groups`. Nothing is kept after the tile, except in
// a table of the frame or a kept table.
//
// Counters: look-ups and hits count single bits. Neighbour probes are counted per query in `pairs` and per
// cell in waves. A boundary query is one whose neighbours disagree at the last level before the finest.
#include <array>
#include <deque>
#include <vector>

#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/exact_part.h"
#include "viscache/aqvc/miss_tracer.h"
#include "viscache/aqvc/pairs.h"
#include "viscache/aqvc/parameters.h"
#include "viscache/aqvc/pixel_order.h"
#include "viscache/aqvc/sample_rows.h"
#include "viscache/aqvc/tile_anchors.h"
#include "viscache/aqvc/waves.h"
#include "viscache/visibility/oracle.h"

namespace viscache {

class QuantizedCache final : public VisibilityOracle {
public:
    /// Center and radius are those of the bounding sphere of the scene, `spp` the number of samples per
    /// pixel. `exact` answers the exact groups. A table of the frame must outlive the cache; `pairs` then
    /// uses it for all tiles and accepts queries in any order.
    QuantizedCache(const RayCaster& caster, ExactAnswers exact, const AqvcParameters& parameters,
                   Vec3 scene_center, float scene_radius, int spp, FrameTable* frame_table = nullptr);

    /// Makes tiles read and extend a kept table, which must outlive the cache. Requires Form::kPairs and
    /// Storage::kTable.
    void use_kept(const KeptTable& table, KeptChecks checks);

    /// Level waves start from these rows and extend them. They must outlive the cache. Requires
    /// Form::kWaves.
    void use_rows(AqvcRows& rows);

    void watch(const Control& control) override;
    void begin_tile(const EyeBlock& eyes) override;
    PairOrder order(const EyeBlock& eyes, std::optional<int> group) override;
    /// Level waves doubt what only the finest cells answer.
    Answer block(const BlockAsk& ask, Counters& counters) override;
    Answer pairs(const PairsAsk& ask, Counters& counters) override;

    /// Deferred writes to the table of the frame.
    std::vector<TableWrite>& writes() { return pairs_.writes(); }
    /// Writes of the tile, for the kept table.
    std::vector<PackedWrite>& kept_writes() { return pairs_.kept_writes(); }
    const std::vector<double>& levels(int group) const { return levels_[size_t(group)]; }

private:
    void run_pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                   const std::vector<uint32_t>& run_of_eye, Counters& counters);
    void cached_pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                      Counters& counters);
    void cached_samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                        Counters& counters);
    /// True if samples use bit rows. They use the table if the form is pairs, or if the frame has one table.
    bool has_sample_rows() const { return parameters_.form != Form::kPairs && !shares_; }
    void make_anchors(const EyeBlock& eyes);
    void begin_sample_rows(const EyeBlock& eyes, int group, Counters& counters);
    void samples_by_pairs(const EyeBlock& eyes, const LocalSamples& samples,
                          std::span<const uint32_t> numbers, const std::vector<uint32_t>& run_of_eye,
                          std::span<Word> visible, Counters& counters);
    void block_by_pairs(const BlockAsk& ask, BitMatrix& visible, Counters& counters);
    const BitMatrix* block_by_waves(const BlockAsk& ask, BitMatrix& visible, Counters& counters);
    const BitMatrix* doubts(const FarEnds& lights);
    uint64_t trace_bright(const BlockAsk& ask, BitMatrix& visible);
    uint64_t trace_bypassing(const BlockAsk& ask, BitMatrix& visible, Counters& counters);
    void make_order(const EyeBlock& eyes);
    uint32_t batch() const {
        // With a queue, a batch is one call only
        return parameters_.batch && !parameters_.queue ? uint32_t(parameters_.batch) : 1024;
    }

    const RayCaster& caster_;
    AqvcParameters parameters_;
    CellGrid grid_;
    int spp_;
    ContributionLevels contribution_levels_;
    bool shares_;  ///< uses the table of the frame
    ExactPart exact_;
    std::array<std::vector<double>, kLightGroups> levels_;
    size_t tile_size_ = 0;
    TileAnchors tile_;
    OrderMaker order_maker_;
    TileOrder order_;
    std::vector<uint32_t> run_end_, run_of_eye_;  ///< for `pairs`
    bool has_order_ = false;
    Columns columns_;
    MissTracer tracer_;
    BitMatrix doubts_by_light_;
    struct LevelCells {
        std::vector<double> levels;
        TileCells cells;
    };
    const TileCells& cells_of(const std::vector<double>& levels);
    CellPlacer placer_;
    std::deque<LevelCells> cells_;  ///< cells of the tile; entries from cells_in_use_ on are spare
    size_t cells_in_use_ = 0;
    Waves waves_;
    AqvcRows* rows_ = nullptr;  ///< kept from frame to frame
    BitMatrix bright_;
    Pairs pairs_;
    BitMatrix by_column_;
    SampleRows sample_rows_;
    int sample_group_ = -1;     ///< the light group of sample_rows_
    Counters sample_counters_;  ///< counters of its preparation, until `pairs` is called
    std::vector<uint32_t> left_;
};

}  // namespace viscache
