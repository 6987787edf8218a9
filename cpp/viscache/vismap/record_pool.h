#pragma once
// Storage of records. Maps never move once stored, so that pointers from lookups stay valid while records
// are added.
#include <memory>
#include <vector>

#include "viscache/math/vec.h"
#include "viscache/vismap/dilation.h"
#include "viscache/vismap/record.h"

namespace viscache {

/// Metadata of a record.
struct RecordHead {
    Vec3 position, normal;
    uint32_t rays = 0,
             misses = 0;     ///< number of comparisons with exact rays; of these, how often the map was wrong
    uint32_t last_used = 0;  ///< last frame in which it was used
};
static_assert(sizeof(RecordHead) == kRecordHeadBytes);

/// Additional data for ambient occlusion.
struct AmbientRecord {
    float visibility = 0;           ///< A, in [0, 1] up to the error of the pattern
    float nearest_hit = kInfinity;  ///< R
};

class RecordPool {
public:
    explicit RecordPool(int m);

    int m() const { return m_; }
    size_t size() const { return heads_.size(); }
    RecordHead& head(uint32_t id) { return heads_[id]; }
    const RecordHead& head(uint32_t id) const { return heads_[id]; }
    const AmbientRecord& ambient(uint32_t id) const { return ambient_[id]; }
    const Word* bits(uint32_t id) const { return row(id); }
    const Word* hierarchy(uint32_t id) const { return row(id) + hierarchy_; }
    const Word* dilated(uint32_t id, int level) const { return row(id) + dilated_[level - 1]; }

    /// Stores a copy of a map of map_words(m) words, together with all data derived from it.
    uint32_t add(const RecordHead& head, const Word* bits, const AmbientRecord& ambient);
    /// Keeps only these records and renumbers them in order; the ids increase. Pointers become invalid.
    void keep(const std::vector<uint32_t>& ids);
    /// Bytes of dilated maps and ambient values, which the paper does not count.
    size_t extra_bytes_per_record() const;

private:
    // Records per block of memory
    static constexpr size_t kChunk = 256;
    Word* row(uint32_t id) const { return chunks_[id / kChunk]->row(id % kChunk); }

    int m_;
    size_t hierarchy_ = 0, dilated_[kMostDilations] = {}, row_words_ = 0;  ///< offsets in the row of a record
    std::vector<std::unique_ptr<BitMatrix>> chunks_;
    std::vector<RecordHead> heads_;
    std::vector<AmbientRecord> ambient_;
};

}  // namespace viscache
