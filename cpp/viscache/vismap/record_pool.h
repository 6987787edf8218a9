#pragma once
// Where records are kept. Maps never move once stored, so what a look-up points to stays while others are
// added.
#include <memory>
#include <vector>

#include "viscache/math/vec.h"
#include "viscache/vismap/dilation.h"
#include "viscache/vismap/record.h"

namespace viscache {

/// The book-keeping of a record.
struct RecordHead {
    Vec3 position, normal;
    uint32_t rays = 0, misses = 0;  ///< compared with exact rays; of these, where the map was wrong
    uint32_t last_used = 0;         ///< frame
};
static_assert(sizeof(RecordHead) == kRecordHeadBytes);

/// What ambient occlusion stores beside.
struct AmbientRecord {
    float visibility = 0;           ///< A, in [0, 1] but for the pattern's error
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

    /// Stores a copy of a map of map_words(m) words with all that follows from it.
    uint32_t add(const RecordHead& head, const Word* bits, const AmbientRecord& ambient);
    /// Keeps these records, ids increasing, and numbers them anew in order. Pointers become invalid.
    void keep(const std::vector<uint32_t>& ids);
    /// Bytes of dilated maps and ambient values, which the paper does not count.
    size_t extra_bytes_per_record() const;

private:
    static constexpr size_t kChunk = 256;
    Word* row(uint32_t id) const { return chunks_[id / kChunk]->row(id % kChunk); }

    int m_;
    size_t hierarchy_ = 0, dilated_[kMostDilations] = {}, row_words_ = 0;  ///< places in a record's row
    std::vector<std::unique_ptr<BitMatrix>> chunks_;
    std::vector<RecordHead> heads_;
    std::vector<AmbientRecord> ambient_;
};

}  // namespace viscache
