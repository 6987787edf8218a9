#pragma once
// Log of which ray answered each query that went through a table.
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "viscache/visibility/query_log.h"

namespace viscache {

/// Knows the latest writer of every entry of a tile's table. An entry is a cluster until another ray is
/// written to it. Keys that the table confuses share a cluster, as they share the answer.
class PairLog {
public:
    void begin_tile() {
        writers_.clear();
        clusters_ = 0;
    }
    /// `records[i]` will belong to query i of the next run.
    void begin_run(size_t queries) { records_.assign(queries, {}); }
    const std::vector<QueryRecord>& records() const { return records_; }

    /// A cluster whose ray is that of `eye`.
    // Not answered by its own ray until `answered` says so.
    QueryRecord new_cluster(uint32_t eye, int level) { return {clusters_++, eye, uint8_t(level), false}; }
    /// The ray of a cluster was written to an entry of the table.
    void written(uint64_t entry, const QueryRecord& cluster) { writers_[entry] = cluster; }
    /// A query was answered by the ray of a cluster.
    void answered(uint32_t query, QueryRecord cluster, int level, bool by_own_ray) {
        cluster.level = uint8_t(level);
        cluster.traced = by_own_ray;
        records_[query] = cluster;
    }
    /// A query was answered by an entry of the table.
    void found(uint32_t query, uint64_t entry, int level) {
        answered(query, writers_.at(entry), level, false);
    }

private:
    std::vector<QueryRecord> records_;
    std::unordered_map<uint64_t, QueryRecord> writers_;
    uint64_t clusters_ = 0;
};

}  // namespace viscache
