#pragma once
// Rows of bits: which of a fixed set of points are visible from each point.
#include <span>

#include "viscache/visibility/oracle_source.h"
#include "viscache/visibility/row_input.h"

namespace viscache {

struct PointRows {
    uint64_t rays = 0;  ///< number of queries
    SourceReport report;
};

/// Bit k of row i is 1 if end k lies above the tangent plane of point i, and nothing stands between them.
/// The other ends are 0 by definition and cost nothing. `rows` has row_words_for(ends) words per point;
/// padding bits are set to 0. `source` makes exact oracles and must be new. `input` needs no directions.
PointRows point_rows(OracleSource& source, float extent, const RowInput& input, const FarEnds& ends,
                     std::span<Word> rows, int threads, Control& control);

}  // namespace viscache
