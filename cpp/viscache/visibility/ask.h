#pragma once
// Queries for any number of eye points without a renderer. The points are split into tiles, and the tiles are
// distributed over threads.
#include <vector>

#include "viscache/visibility/oracle_source.h"
#include "viscache/visibility/query_log.h"

namespace viscache {

/// Eye points in tiles. Tile t holds `eyes[t]`; `row[t][i]` is the index of its point i in the arrays of the
/// caller.
struct EyeTiles {
    std::vector<EyeBlock> eyes;
    std::vector<std::vector<uint32_t>> row;
    size_t size = 0;  ///< number of points in all tiles

    /// Splits points along the Morton curve of their positions into tiles of at most `most` points. Inside a
    /// tile, order_x and order_y follow a curve through a square, for the Halton–Morton order.
    static EyeTiles along_curve(const EyeBlock& points, size_t most);
};

/// One query of a block and its answer, with the indices of the caller.
struct AskedQuery {
    uint32_t row, column;
    uint64_t cluster;         ///< numbered from 0 in order of first appearance
    uint32_t representative;  ///< row of the point whose ray was traced
    uint8_t level;
    bool traced;
};

struct BlockQuestion {
    const FarEnds* lights = nullptr;
    /// Queried bits in rows of `words` words, with the indices of the caller; nullptr: all.
    const Word* wanted = nullptr;
    /// Unoccluded contributions (rows × columns); nullptr: none. A cache can distribute its rays by them.
    const float* contributions = nullptr;
    /// Log the queries of the columns [log_begin, log_end).
    size_t log_begin = 0, log_end = 0;
};

struct BlockAnswer {
    size_t words = 0;            ///< words per row: columns rounded up to whole words
    std::vector<Word> bits;      ///< size × words; 1 = visible
    std::vector<float> weights;  ///< size × columns, or empty: 1 each
    std::vector<AskedQuery> log;
    Counters counters;
    SourceReport report;
};

/// Answers all eye points × all far ends. `source` must be new: it serves one call.
BlockAnswer ask_block(OracleSource& source, const EyeTiles& tiles, const BlockQuestion& question, int threads,
                      Control& control);

/// Connections that each belong to one eye point.
struct PairQuestion {
    std::vector<ShadowQuery> queries;  ///< `eye` is an index of the caller
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
