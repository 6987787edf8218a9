#pragma once
// Alg. 2 for connections that belong to one eye point each, against the tile's table.
//
// Batches of eye points, in Halton–Morton order and never across a segment, read the table as it was before
// them; equal misses of a batch share the ray of the first query. Then they are committed in order. With
// batch = 1 every query is a batch: Alg. 2 as printed. With a queue, misses are postponed instead
// (postponed.h).
#include <optional>
#include <vector>

#include "viscache/aqvc/bit_table.h"
#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/frame_table.h"
#include "viscache/aqvc/kept_table.h"
#include "viscache/aqvc/postponed.h"
#include "viscache/aqvc/refinement.h"
#include "viscache/aqvc/tile_anchors.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// What pairs need to know besides the queries.
struct PairContext {
    const TileAnchors& tile;
    const AqvcParameters& parameters;
    const std::array<std::vector<double>, kLightGroups>& levels;  ///< C_E of every group and level
    const std::vector<uint32_t>& run_of_eye;  ///< queries of one run form a batch; empty: one query
    const RayCaster& caster;
    float extent;
};

class Pairs {
public:
    /// With a table of the frame: its own is not made, and every call of `run` is an item of a round.
    explicit Pairs(const AqvcParameters& p, FrameTable* frame_table = nullptr);
    /// From now on the tile's own table lies over one that is kept.
    void use_kept(const KeptTable& table, KeptChecks checks) { kept_ = &table, checking_ = checks; }
    /// `run` ends with `Cancelled` soon after `control` says so.
    void watch(const Control& control) { control_ = &control; }
    void begin_tile();
    /// Answers queries (bit i of `visible` for queries[i], zeroed on entry) and counts rays per group.
    void run(const PairContext& context, std::span<const ShadowQuery> queries, std::span<Word> visible,
             Counters& counters, ClampCounts& clamps);
    /// What waits to be written into the frame's table.
    std::vector<TableWrite>& writes() { return writes_; }
    /// What waits to be written into the kept table.
    std::vector<PackedWrite>& kept_writes() { return kept_writes_; }

private:
    /// A reused bit that is traced as well.
    struct Check {
        uint32_t query;
        bool kept, visible;
        FullKey key;
    };
    /// Cells of the last eye point of a group.
    struct EyeCells {
        uint32_t eye = 0xffffffffu;
        CellLevels cells;
    };

    template <class Table>
    void run_batches(Table& table, const PairContext& c, std::span<const ShadowQuery> queries,
                     std::span<Word> visible, Counters& counters, ClampCounts& clamps);
    template <class Table>
    void run_batch(Table& table, const PairContext& c, std::span<const ShadowQuery> queries, size_t first,
                   size_t last, std::span<Word> visible, Counters& counters, ClampCounts& clamps);
    template <class Table>
    void run_postponed(Table& table, const PairContext& c, std::span<const ShadowQuery> queries,
                       std::span<Word> visible, Counters& counters, ClampCounts& clamps);
    /// Traces rays [first, last), writes them in their order and answers the queries that wait for them.
    template <class Table>
    void finish(Table& table, const PairContext& c, std::span<const ShadowQuery> queries, size_t first,
                size_t last, std::span<Word> visible, Counters& counters);
    template <class Table>
    void look_up(const Table& table, const PairContext& c, const ShadowQuery& q, uint32_t index,
                 std::span<Word> visible, Counters& counters, ClampCounts& clamps);
    /// Cells and far keys of a query; false if it has none.
    template <class Table>
    bool key_query(const Table& table, const PairContext& c, const ShadowQuery& q, ClampCounts& clamps);
    void trace(const PairContext& c, std::span<const ShadowQuery> queries, size_t first, size_t last);
    /// Traces the queries numbered by `number(i)` for i < count; calls `answer(i, visible)`.
    template <class Number, class Answer>
    void trace_numbered(const PairContext& c, std::span<const ShadowQuery> queries, size_t count,
                        Number number, Answer answer) const;
    void note_reuse(const PairContext& c, const ShadowQuery& q, uint32_t index, const Walk& walk,
                    Counters& counters);
    template <class Table>
    void trace_checks(Table& table, const PairContext& c, std::span<const ShadowQuery> queries,
                      std::span<Word> visible, Counters& counters);
    void check_cancelled(size_t step) const {
        if (control_ && step % 4096 == 0) control_->check();
    }
    uint32_t pending_with(const FullKey& key);

    const Control* control_ = nullptr;
    std::optional<BitTable> table_;  ///< one of the two, unless the frame has one
    std::optional<ExactTable> exact_;
    FrameTable* frame_table_;
    std::vector<TableWrite> writes_;
    const KeptTable* kept_ = nullptr;
    KeptChecks checking_;
    std::vector<PackedWrite> kept_writes_;
    std::vector<Check> checks_;
    std::array<EyeCells, kLightGroups> eye_cells_;
    CellLevels paired_cells_;  ///< Eq. 6: cells of one query
    CellLevels* cells_ = nullptr;
    std::vector<FarKey> fars_;
    PostponedQueue waiting_;  ///< of the batch, or postponed
    std::vector<uint8_t> ray_visible_;
    std::vector<uint32_t> pending_slots_;  ///< of a batch: open addressing over its rays, number + 1
    size_t pending_count_ = 0;
    bool of_thread_;              ///< the table outlives tiles
    bool slots_counted_ = false;  ///< the tile's table is in use
};

}  // namespace viscache
