#pragma once
// Log of the queries of a block, for caches whose queries share answers.
#include <cstdint>

namespace viscache {

struct QueryRecord {
    uint64_t cluster = 0;         ///< queries of one tile with equal numbers share one answer
    uint32_t representative = 0;  ///< index in the tile of the eye point whose ray was traced
    uint8_t level = 0;            ///< refinement level; 0 is the coarsest
    bool traced = false;          ///< the traced ray is that of the query itself
};

class QueryLog {
public:
    virtual ~QueryLog() = default;
    /// Called once for every query of a block, in any order.
    virtual void answered(uint32_t eye, uint32_t column, const QueryRecord& record) = 0;
};

}  // namespace viscache
