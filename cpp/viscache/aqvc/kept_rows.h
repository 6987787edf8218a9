#pragma once
// Bit rows of cells that are kept from frame to frame.
//
// Frames of the same camera, lights and parameters have mostly the same cells, though their eye points
// differ. What one frame traced answers the next. A frame starts from the rows that the last finished frame
// left; what a frame that did not finish wrote is taken back. So its bytes do not depend on interrupts.
#include <array>
#include <compare>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "viscache/aqvc/columns.h"
#include "viscache/aqvc/tile_cells.h"
#include "viscache/visibility/counters.h"

namespace viscache {

/// The rows of one light group in one tile.
class KeptRows {
public:
    /// Rows for these columns and levels. Other lights or levels than before start anew.
    void begin(const Columns& columns, const std::vector<double>& levels);
    /// Copies what is known to the rows of the tile's cells.
    void load(const TileCells& cells, BitMatrix& known, BitMatrix& value);
    /// Keeps the rows of the cells that `load` was given.
    void store(const TileCells& cells, const BitMatrix& known, const BitMatrix& value);
    /// Ends a frame.
    void commit();
    /// Takes back what was stored since the last `commit`.
    void roll_back();

    size_t cells() const { return numbers_.size(); }
    bool has_committed() const { return committed_ > 0; }
    /// Approximate memory in use.
    uint64_t bytes() const { return cells() * bytes_per_cell(); }

    /// The state as arrays, for files: cells and their levels (6 numbers each), and its rows.
    struct State {
        uint64_t digest = 0;
        uint64_t row_words = 0;
        std::vector<int64_t> cells;
        std::vector<Word> rows;
    };
    State state() const;
    void restore(const State& state);

private:
    static constexpr size_t kCellNumbers = 6;  ///< in State: bin, slot, x, y, z, level
    uint64_t bytes_per_cell() const { return 2 * row_words_ * sizeof(Word) + sizeof(Cell) + 16; }
    Word* row(size_t cell) { return rows_.data() + cell * 2 * row_words_; }
    const Word* row(size_t cell) const { return rows_.data() + cell * 2 * row_words_; }
    void clear();

    uint64_t digest_ = 0;   ///< of the lights and levels
    size_t row_words_ = 0;  ///< of one row
    CellNumbers numbers_;
    std::vector<Word> rows_;         ///< per cell: known, then value
    std::vector<uint32_t> kept_of_;  ///< per cell of the tile: its kept row, or kNoCell
    // To take a frame back: cells before it, and the rows that it changed
    size_t committed_ = 0;
    std::vector<uint32_t> changed_;
    std::vector<Word> before_;
};

/// The rows of all tiles and light groups. They belong to one grid of tiles.
///
/// Room is for whole tiles: first for those with rows of earlier frames, then for others, the smaller ones
/// first each time, until the first that would exceed it. This one and all after it keep no rows. So in
/// whatever order threads finish tiles, the same ones keep their rows. Each frame decides anew.
class AqvcRows {
public:
    explicit AqvcRows(uint64_t max_bytes) : max_bytes_(max_bytes) {}
    AqvcRows(const AqvcRows&) = delete;

    /// Forgets all rows.
    void clear();
    /// Starts from the rows of the last commit.
    void begin_frame(size_t tiles);
    /// Ends a frame that is finished and in its caller's hands.
    void commit();
    /// Threads may call this at once for different tiles.
    KeptRows& rows(size_t tile, int group) { return tiles_.at(tile)[size_t(group)]; }
    /// Ends a tile of the frame: it has room, or it or others lose their rows. Threads may call this
    /// at once. Rows of earlier frames stay until `commit`, for frames that do not finish.
    void end_tile(size_t tile);

    uint64_t frames() const { return frames_; }
    uint64_t cells() const;
    uint64_t bytes() const;
    /// Tiles of the last frame whose rows had no room.
    uint64_t tiles_not_kept() const { return tiles_not_kept_; }
    size_t tiles() const { return tiles_.size(); }

    KeptRows::State state(size_t tile, int group) const { return tiles_.at(tile)[size_t(group)].state(); }
    /// Starts from saved rows: first this, then `restore` per tile and group.
    void begin_restore(size_t tiles, uint64_t frames);
    void restore(size_t tile, int group, const KeptRows::State& state) {
        tiles_.at(tile)[size_t(group)].restore(state);
    }

private:
    using Tile = std::array<KeptRows, kLightGroups>;
    /// A tile that ended, in the order in which tiles get room.
    struct Ended {
        bool is_new;  ///< without rows of earlier frames
        uint64_t bytes;
        size_t tile;
        auto operator<=>(const Ended&) const = default;
    };
    static uint64_t bytes_of(const Tile& tile);
    void leave_out(const Ended& ended);
    void begin_room();

    uint64_t max_bytes_;
    uint64_t frames_ = 0;  ///< number of commits
    std::deque<Tile> tiles_;
    // Of the frame in progress
    std::mutex mutex_;
    std::set<Ended> with_room_;
    uint64_t bytes_with_room_ = 0;
    std::optional<Ended> first_left_out_;
    std::vector<bool> left_out_;  ///< per tile
    uint64_t tiles_not_kept_ = 0;
};

}  // namespace viscache
