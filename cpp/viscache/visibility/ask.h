#pragma once
// Any number of eye points asked about far ends, without a renderer: cut into tiles, spread over threads.
#include <optional>
#include <span>
#include <vector>

#include "viscache/visibility/oracle_source.h"
#include "viscache/visibility/query_log.h"

namespace viscache {

/// Eye points in tiles: tile t holds `eyes[t]`, and `row[t][i]` is the caller's number of its point i.
struct EyeTiles {
    std::vector<EyeBlock> eyes;
    std::vector<std::vector<uint32_t>> row;
    size_t size = 0;  ///< points in all tiles

    /// Cuts points along the Morton curve of their places into tiles of at most `most` points. Their order
    /// inside a tile is Halton–Morton order's: a curve through a square.
    static EyeTiles along_curve(const EyeBlock& points, size_t most);
};

/// One query of a block and who answered it, by the caller's numbers.
struct AskedQuery {
    uint32_t row, column;
    uint64_t cluster;         ///< numbered from 0 in order of first appearance, tile after tile
    uint32_t representative;  ///< row of the point whose ray answered
    uint8_t level;
    bool traced;
};

struct BlockQuestion {
    const FarEnds* lights = nullptr;
    /// Bits asked for, rows of `words` words by the caller's numbers; nullptr: all.
    const Word* wanted = nullptr;
    /// Unoccluded contributions (rows × columns); nullptr: none. A cache may spend rays by them.
    const float* contributions = nullptr;
    /// Tell who answered each query of the columns [log_begin, log_end).
    size_t log_begin = 0, log_end = 0;
};

struct BlockAnswer {
    size_t words = 0;            ///< of a row: the columns, rounded up to whole words
    std::vector<Word> bits;      ///< size × words; 1 = visible
    std::vector<float> weights;  ///< size × columns, or empty: 1 each
    std::vector<AskedQuery> log;
    Counters counters;
    SourceReport report;
};

/// Everything × everything. `source` must be new: it serves one call.
BlockAnswer ask_block(OracleSource& source, const EyeTiles& tiles, const BlockQuestion& question, int threads,
                      Control& control);

/// Connections of which each belongs to one eye point.
struct PairQuestion {
    std::vector<ShadowQuery> queries;  ///< `eye` is the caller's number
};

struct PairAnswer {
    std::vector<uint8_t> visible;
    std::vector<float> weights;  ///< per query, or empty: 1 each
    Counters counters;
    SourceReport report;
};

/// `source` must be new: it serves one call.
PairAnswer ask_pairs(OracleSource& source, const EyeTiles& tiles, const PairQuestion& question, int threads,
                     Control& control);

}  // namespace viscache
