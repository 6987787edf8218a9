#pragma once
// Bit rows of cells that are kept from frame to frame.
//
// Frames of the same camera, lights and parameters have mostly the same cells, though their eye points
// differ. What one frame traced answers the next. A frame starts from the rows that the last finished frame
// left; what a frame that did not finish wrote is taken back. So its bytes do not depend on interrupts.
#include <array>
#include <cstdint>
#include <deque>
#include <span>
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
    /// Keeps the rows of the cells that `load` was given. New cells are kept as long as the rows take at
    /// most `most_bytes`. Returns the number of cells that did not fit.
    uint64_t store(const TileCells& cells, const BitMatrix& known, const BitMatrix& value,
                   uint64_t most_bytes);
    /// Ends a frame.
    void commit();
    /// Takes back what was stored since the last `commit`.
    void roll_back();

    size_t cells() const { return numbers_.size(); }
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
class AqvcRows {
public:
    explicit AqvcRows(uint64_t max_bytes) : max_bytes_(max_bytes) {}
    AqvcRows(const AqvcRows&) = delete;

    /// Forgets all rows.
    void clear() { tiles_.clear(); }
    /// Starts from the rows of the last commit.
    void begin_frame(size_t tiles);
    /// Ends a frame that is finished and in its caller's hands.
    void commit();
    /// Threads may call this at once for different tiles.
    KeptRows& rows(size_t tile, int group) { return tiles_.at(tile)[size_t(group)]; }
    /// The most that the rows of one tile and group may take.
    uint64_t most_bytes(size_t tile, int group) const;

    uint64_t frames() const { return frames_; }
    uint64_t cells() const;
    uint64_t bytes() const;
    size_t tiles() const { return tiles_.size(); }

    KeptRows::State state(size_t tile, int group) const { return tiles_.at(tile)[size_t(group)].state(); }
    /// Starts from saved rows: first this, then `restore` per tile and group.
    void begin_restore(size_t tiles, uint64_t frames);
    void restore(size_t tile, int group, const KeptRows::State& state) {
        tiles_.at(tile)[size_t(group)].restore(state);
    }

private:
    using Tile = std::array<KeptRows, kLightGroups>;
    uint64_t max_bytes_;
    uint64_t frames_ = 0;  ///< number of commits
    std::deque<Tile> tiles_;
};

}  // namespace viscache
