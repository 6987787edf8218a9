#pragma once
// The quantized visibility cache as an oracle (AQVC Sec. 3–4).
//
// Groups of shared lights go through level waves (or the hash table, by parameter);
// samples that belong to one eye point each go through rows of their light cells' bits (or the table);
// other connections of single eye points through the tile's table. Nothing outlives the tile.
//
// How the forms count: look-ups and hits are single bits. Neighbour probes are per query in `pairs`, per cell
// in waves. A boundary query found its neighbours disagreeing right above the finest level.
#include <array>
#include <deque>
#include <vector>

#include "viscache/aqvc/columns.h"
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
    /// The scene's bounding sphere gives c and B_R; `offset_extent` is the scene's, `spp` the samples per
    /// pixel. With a table of the frame, which must outlive the cache, `pairs` uses that one: it outlives
    /// tiles, and any order of queries is fine.
    QuantizedCache(const RayCaster& caster, const AqvcParameters& parameters, Vec3 scene_center,
                   float scene_radius, float offset_extent, int spp, FrameTable* frame_table = nullptr);

    /// Tiles of this cache read and extend a table that outlives frames; it must outlive the cache. Only with
    /// Form::kPairs and Storage::kTable.
    void use_kept(const KeptTable& table, KeptChecks checks);

    void watch(const Control& control) override;
    void weigh(const Contributions* worth) override { contributions_ = worth; }
    void log(QueryLog* log) override { log_ = log; }
    void begin_tile(const EyeBlock& eyes) override;
    void block(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted, BitMatrix& visible,
               Counters& counters) override;
    void pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
               Counters& counters) override;
    PairOrder pair_order(const EyeBlock& eyes) override;
    void samples(const EyeBlock& eyes, const LocalSamples& samples, std::span<Word> visible,
                 Counters& counters) override;
    PairOrder sample_order(const EyeBlock& eyes, int group) override;

    /// What waits to be written into the frame's table.
    std::vector<TableWrite>& writes() { return pairs_.writes(); }
    /// What the tile wrote, for the kept table.
    std::vector<PackedWrite>& kept_writes() { return pairs_.kept_writes(); }
    const std::vector<double>& levels(int group) const { return levels_[size_t(group)]; }

private:
    void ask_pairs(const EyeBlock& eyes, std::span<const ShadowQuery> queries, std::span<Word> visible,
                   const std::vector<uint32_t>& run_of_eye, Counters& counters);
    bool has_sample_rows(int group) const;
    void begin_sample_rows(int group, Counters& counters);
    void samples_by_pairs(const EyeBlock& eyes, const LocalSamples& samples,
                          std::span<const uint32_t> numbers, const std::vector<uint32_t>& run_of_eye,
                          std::span<Word> visible, Counters& counters);
    void block_by_pairs(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                        BitMatrix& visible, Counters& counters);
    void block_by_waves(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                        BitMatrix& visible, Counters& counters);
    uint64_t trace_bypassing(const EyeBlock& eyes, const FarEnds& lights, const BitMatrix& wanted,
                             BitMatrix& visible, Counters& counters);
    void make_order(const EyeBlock& eyes);
    uint32_t batch() const {
        // With a queue a batch is but a call
        return parameters_.batch && !parameters_.queue ? uint32_t(parameters_.batch) : 1024;
    }

    const RayCaster& caster_;
    AqvcParameters parameters_;
    CellGrid grid_;
    float extent_;
    int spp_;
    const Contributions* contributions_ = nullptr;
    QueryLog* log_ = nullptr;
    ContributionLevels worth_;
    bool shares_;  ///< the frame's table
    std::array<std::vector<double>, kLightGroups> levels_;
    TileAnchors tile_;
    OrderMaker order_maker_;
    TileOrder order_;
    std::vector<uint32_t> run_end_, run_of_eye_;  ///< of pairs
    bool has_order_ = false;
    Columns columns_;
    MissTracer tracer_;
    struct LevelCells {
        std::vector<double> levels;
        TileCells cells;
    };
    const TileCells& cells_of(const std::vector<double>& levels);
    CellPlacer placer_;
    std::deque<LevelCells> cells_;  ///< of the tile; those beyond cells_in_use_ are room for later
    size_t cells_in_use_ = 0;
    Waves waves_;
    Pairs pairs_;
    BitMatrix by_column_;
    SampleRows sample_rows_;
    int sample_group_ = -1;     ///< the group that sample_rows_ is about
    Counters sample_counters_;  ///< of preparing it, until it is asked
    std::vector<uint32_t> left_;
};

}  // namespace viscache
