#pragma once
// Who answered each query of a block: of caches whose queries share answers.
#include <cstdint>

namespace viscache {

struct QueryRecord {
    uint64_t cluster = 0;         ///< queries of one tile with equal numbers share one answer
    uint32_t representative = 0;  ///< the eye point whose ray answered, an index into the tile
    uint8_t level = 0;            ///< of refinement, 0 = coarsest
    bool traced = false;          ///< the query's own ray was the one that answered
};

class QueryLog {
public:
    virtual ~QueryLog() = default;
    /// Called once for every query of a block, in any order.
    virtual void answered(uint32_t eye, uint32_t column, const QueryRecord& record) = 0;
};

}  // namespace viscache
