#pragma once
// Alg. 2 for connections that each belong to one eye point, with the table of the tile.
//
// Queries run in batches of eye points, in Halton–Morton order. A batch does not cross a segment. It reads
// the table in the state before the batch; misses with equal keys share the ray of the first query. Then its
// rays are written in order. With batch = 1 every query is a batch, which is Alg. 2 as printed. With a queue,
// misses are postponed instead (postponed.h).
#include <optional>
#include <vector>

#include "viscache/aqvc/bit_table.h"
#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/frame_table.h"
#include "viscache/aqvc/kept_table.h"
#include "viscache/aqvc/pair_log.h"
#include "viscache/aqvc/postponed.h"
#include "viscache/aqvc/refinement.h"
#include "viscache/aqvc/tile_anchors.h"
#include "viscache/visibility/ray_caster.h"

namespace viscache {

/// Input of `Pairs::run` besides the queries.
struct PairContext {
    const TileAnchors& tile;
    const AqvcParameters& parameters;
    const std::array<std::vector<double>, kLightGroups>& levels;  ///< C_E of every group and level
    const std::vector<uint32_t>& run_of_eye;  ///< queries of one run form a batch; if empty, each query does
    const RayCaster& caster;
};

class Pairs {
public:
    /// With `frame_table`, the object has no table of its own, and every call of `run` is an item of a round.
    explicit Pairs(const AqvcParameters& p, FrameTable* frame_table = nullptr);
    /// Puts the table of each tile on top of a kept table.
    void use_kept(const KeptTable& table, KeptChecks checks) {
        kept_ = &table;
        checking_ = checks;
    }
    /// `run` throws `Cancelled` soon after `control` requests it.
    void watch(const Control& control) { control_ = &control; }
    void begin_tile();
    /// The next runs tell `log` whose ray answered each query; nullptr: nobody. To be set between begin_tile
    /// and the first run. Throws std::invalid_argument if tiles share a table.
    void log(PairLog* log);
    /// Answers the queries: bit i of `visible` (zeroed on entry) belongs to queries[i]. Counts rays per
    /// group.
    void run(const PairContext& context, std::span<const ShadowQuery> queries, std::span<Word> visible,
             Counters& counters, ClampCounts& clamps);
    /// Deferred writes to the table of the frame.
    std::vector<TableWrite>& writes() { return writes_; }
    /// Deferred writes to the kept table.
    std::vector<PackedWrite>& kept_writes() { return kept_writes_; }

private:
    /// A reused bit that is also traced.
    struct Check {
        uint32_t query;
        bool kept, visible;
        FullKey key;
    };
    /// Cells of the latest eye point of a group.
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
    /// Traces rays [first, last), writes their values in order and answers the queries that depend on them.
    template <class Table>
    void finish(Table& table, const PairContext& c, std::span<const ShadowQuery> queries, size_t first,
                size_t last, std::span<Word> visible, Counters& counters);
    template <class Table>
    void look_up(const Table& table, const PairContext& c, const ShadowQuery& q, uint32_t index,
                 std::span<Word> visible, Counters& counters, ClampCounts& clamps);
    /// Finds the cells and far keys of a query; false if it has none.
    template <class Table>
    bool key_query(const Table& table, const PairContext& c, const ShadowQuery& q, ClampCounts& clamps);
    void trace(const PairContext& c, std::span<const ShadowQuery> queries, size_t first, size_t last);
    /// Traces the queries with index number(i) for i < count and calls answer(i, visible).
    template <class Number, class Answer>
    void trace_numbered(const PairContext& c, std::span<const ShadowQuery> queries, size_t count,
                        Number number, Answer answer) const;
    void count_reuse(const PairContext& c, const ShadowQuery& q, uint32_t index, const Walk& walk,
                     Counters& counters);
    template <class Table>
    void trace_checks(Table& table, const PairContext& c, std::span<const ShadowQuery> queries,
                      std::span<Word> visible, Counters& counters);
    void check_cancelled(size_t step) const {
        // A look at the flag per 4096 steps costs nothing.
        if (control_ && step % 4096 == 0) control_->check();
    }
    uint32_t pending_with(const FullKey& key);
    /// The key of the cell at which a walk ended.
    FullKey key_at(int level) const;

    const Control* control_ = nullptr;
    PairLog* log_ = nullptr;
    std::optional<BitTable> table_;  ///< one of the two is set, unless the frame has a table
    std::optional<ExactTable> exact_;
    FrameTable* frame_table_;
    std::vector<TableWrite> writes_;
    const KeptTable* kept_ = nullptr;
    KeptChecks checking_;
    std::vector<PackedWrite> kept_writes_;
    std::vector<Check> checks_;
    std::array<EyeCells, kLightGroups> eye_cells_;
    CellLevels paired_cells_;  ///< cells of one query under Eq. 6
    CellLevels* cells_ = nullptr;
    std::vector<FarKey> fars_;
    PostponedQueue waiting_;  ///< rays of the batch, or postponed rays
    std::vector<uint8_t> ray_visible_;
    std::vector<uint32_t> pending_slots_;  ///< open addressing over the rays of a batch: index + 1, or 0
    size_t pending_count_ = 0;
    bool of_thread_;              ///< the table belongs to the thread and is not cleared per tile
    bool slots_counted_ = false;  ///< the slots of the table are in the counters already
};

}  // namespace viscache
